"""Foreign controllers: a team's own C, compiled for the host, in a process of its own, stepped in virtual time.

project    the TOML file that says what the firmware is made of and which of its handles are which wires
build      the compiler, asked; its words where it refuses
server     a process for each firmware that forks a fresh one whenever a bench is built
firmware   the base behind the seam: bytes and frames in, frames and bytes out, a packet each way a tick
one_core   bench and firmware on one core of the machine while a run lasts
trouble    what a firmware that crashed, loops or floods is said to have done, and where
start      what `wheelbench dut init` writes
shim/      the C that stands between the team's calls and the bench
"""
