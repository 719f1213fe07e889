"""Which of all explanations leads, and which others are worth a line."""

from __future__ import annotations

from dataclasses import replace

from bench.check.causes.cause import Cause, by_score
from bench.check.compare import rank

_BEYOND_DOUBT = 0.9
"""A score from which the next best explanation of the same wire is not worth a line."""
_MOST = 8


def in_rank(of_wires: list[list[Cause]], between: list[Cause]) -> list[Cause]:
    """The leading wire's causes by score, with the other wires that show the same; then what else there is, by time."""
    best = {found[0].wires[0]: found[0] for found in of_wires}
    for cause in by_score(between):
        if all(cause.score >= best[wire].score for wire in cause.wires if wire in best):
            best.update(dict.fromkeys(cause.wires, cause))
    first_ticks = {found[0].wires[0]: min(one.first_tick for one in found) for found in of_wires}
    for cause in between:
        for wire in cause.wires:
            first_ticks[wire] = min(cause.first_tick, first_ticks.get(wire, cause.first_tick))
    if not best:
        return []
    order = sorted(best, key=lambda wire: (first_ticks[wire], rank(wire)))
    merged: list[Cause] = []
    for wire in order:
        cause = best[wire]
        # What leads stands alone unless the very same happened elsewhere; that others differ too is no part of it.
        others = merged[1:] if cause.kind == "changed" else merged
        same = next((one for one in others if _is_same(one, cause)), None)
        if same is None:
            merged.append(cause)
        elif wire not in same.wires:
            merged[merged.index(same)] = _merged(same, cause)
    rivals = [one for found in of_wires if found[0].wires[0] == order[0] for one in found]
    rivals = [one for one in by_score([*rivals, *between]) if order[0] in one.wires and one not in best.values()]
    doubted = merged[0].score < _BEYOND_DOUBT
    return [*merged[:1], *(one for one in rivals[:2] if doubted and one.score > 0.3), *merged[1:]][:_MOST]


def _is_same(one: Cause, other: Cause) -> bool:
    if one is other:
        return True
    own = ("noise", "offset", "dropped", "duplicated", "quantised", "rate", "swapped")
    if one.kind != other.kind or one.kind in own:
        return False
    return one.amount == other.amount and bool(one.fields) == bool(other.fields)


def _merged(one: Cause, other: Cause) -> Cause:
    differing = one.differing + other.differing
    last = None if one.last_tick is None or other.last_tick is None else max(one.last_tick, other.last_tick)
    return replace(
        one,
        wires=(*one.wires, *other.wires),
        fields=tuple(dict.fromkeys((*one.fields, *other.fields))),
        last_tick=last,
        score=(one.score * one.differing + other.score * other.differing) / differing,
        differing=differing,
        left=one.left + other.left,
    )
