"""What the wires of one run say of the same thing, held against each other: needs no golden, and runs in every run.

    motion          encoder counts on CAN, what the base tells on SLAMWARE, and the truth move alike
    rest_current    who stands as commanded, and is not pushed, draws no current
    answers         every SLAMWARE answer belongs to one request, and comes in time
    bus             identifiers, rates and bus time are possible on the CAN bus and the serial lines

Everything is taken from `TickOutput`s, from outside of the base, so any base can be judged, and a recording as well as
the run that it is of. `settings` reads the `[checks]` table of a scenario, `observer` puts the four together.
"""

from bench.check.crosswire.finding import Finding, Outcome
from bench.check.crosswire.observer import CrossWire
from bench.check.crosswire.settings import Checks, read_checks

__all__ = ["Checks", "CrossWire", "Finding", "Outcome", "read_checks"]
