"""Makes faults happen: a world whose wires, motors and floor fail as a scenario says, with a witness of every touch.

`FaultyWorld` stands where a `World` stands. What it changes, it changes where the base or the motors meet it, so a
recording holds what really arrived. A fault is a small machine that takes each tick's piece and gives what is left of
it; while it is not active it hands everything through untouched, and `touched` counts the pieces that it did not.

    injector    which faults there are, when they act, and the witness
    world       the wires, the motors and the floor on which they act
    machines    the machine of each fault; those that change a piece within its tick
    keeping     machines that keep pieces: for later, or for good
    rc_frames   machines that know whole RC frames

Several faults on one wire act in the order of the scenario file.
"""

from bench.check.faulty.injector import Injector, Touch
from bench.check.faulty.world import FaultyWorld

__all__ = ["FaultyWorld", "Injector", "Touch"]
