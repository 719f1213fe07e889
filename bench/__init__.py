"""wheelbench: a hardware-in-the-loop test bench for omni-wheel robot bases. This is the map; nothing is exported.

    RC bytes ----> rc_decode --+
                               +-> drive -> kinematics -> controller -> m2006 -> CAN 0x200
    core bytes --> slamware ---+                              ^                     |
                      |                                       |  m2006              v
    answers <----- slamware <- odometry <- kinematics <-------+-------- CAN 0x201.. m2006 <- plant

`base` holds the upper half (what foreign firmware replaces), `world` the lower (ESCs, plant, SLAMWARE core), and
`loop` ticks the two, 1 ms at a time; `motors` picks `m2006` or `dm3519`. `messages` and `config` lie under all of
them; `tui` and `__main__` are the doors. Around the picture: `rc/` (a file per protocol), `slamware/` (framing,
payloads, both sides), `canbus/` (message tables, DBC, bus budget), `io/` (clock, ports, wires), `check/` (recordings,
comparison, scenarios), `dut/` (a team's own C in a process of its own), `screen/` (what the dashboard shows), `cli/` (a
file per verb), `robots/`, `profiles/` (data).

Start with `loop.py`, then `messages.py`. docs/architecture.md has the reasons.
"""

__version__ = "0.1.0"
