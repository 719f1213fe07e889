"""An instant of a bench, kept as bytes: `still` takes it, `again` gives a bench that goes on from there, bit for bit.

A still is a pickle, made in about 1.5 ms, and half of it compressed. `copy.deepcopy` takes longer and keeps
objects alive; a forked process would keep megabytes and the terminal. The physics engine pickles its contacts with
their impulses, so that a robot against a wall goes on as it would have. What does not change (robots, arenas) is kept
by reference. What a pickle cannot hold is refused here, and not found out at a scrub: a lambda or a closure would go on
changing the bench that it was taken from.

Stills never leave the process: a pickle from elsewhere may run anything.
"""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Sequence
from io import BytesIO
from struct import Struct
from typing import Any, TypeVar

from bench.arena import Arena
from bench.config import Robot

Thing = TypeVar("Thing")
_LEVEL = 1
_KEPT: dict[int, object] = {}
"""Values that stills hold by reference, by their id: as long as the process lives, as do the stills."""


class _Taker(pickle.Pickler):
    shared: frozenset[int] = frozenset()

    def persistent_id(self, thing: Any) -> int | None:
        if type(thing) is not Robot and type(thing) is not Arena and id(thing) not in self.shared:
            return None
        _KEPT[id(thing)] = thing
        return id(thing)

    def reducer_override(self, thing: Any) -> Any:
        return (Struct, (thing.format,)) if type(thing) is Struct else NotImplemented


class _Giver(pickle.Unpickler):
    def persistent_load(self, number: int) -> object:
        return _KEPT[number]


def still(thing: object, shared: Sequence[object] = ()) -> bytes:
    """An instant of a bench, or of several things that share parts; `shared` values, which never change, by reference.

    Raises PicklingError, AttributeError or TypeError (by what it is) for what cannot be kept.
    """
    taken = BytesIO()
    taker = _Taker(taken, pickle.HIGHEST_PROTOCOL)
    taker.shared = frozenset(map(id, shared))
    taker.dump(thing)
    return zlib.compress(taken.getvalue(), _LEVEL)


def again(taken: bytes) -> Any:
    """The thing as it was; each call gives one of its own."""
    return _Giver(BytesIO(zlib.decompress(taken))).load()
