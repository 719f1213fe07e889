"""A bench with a transmitter in front of it: what most tests of the whole chain drive."""

from bench.loop import simulated
from bench.messages import TickInput
from bench.rc.transmitter import AT_REST, Sticks, Transmitter


class Rig:
    """Our simulated robot and somebody's hands on the sticks."""

    def __init__(self, robot="m2006", bench=None):
        self.bench = bench or simulated(robot)
        self.transmitter = Transmitter(self.bench.robot.rc)
        self.core_twist = None
        self.outputs = []

    def run(self, ticks, sticks=AT_REST):
        """Hold the sticks for so many ticks; the last output comes back, all are kept in `outputs`."""
        for _ in range(ticks):
            rc = self.transmitter.step(self.bench.now_tick, sticks)
            self.outputs.append(self.bench.tick(TickInput(rc, self.core_twist)))
        return self.outputs[-1]

    def arm(self):
        self.run(50)
        self.run(50, Sticks(aux1=True))
        self.run(50)
        assert self.bench.base.drive.armed
        return self

    @property
    def truth(self):
        return self.bench.world.plant.pose

    @property
    def believed(self):
        return self.bench.base.odometry.pose
