"""Conditions in words of the field: `abs(vx_mps) < 0.05 and link == "lost"` -> an atom with a margin.

The grammar is a part of Python's: names of signals, numbers, text, True and False; + - * / and brackets; abs, min, max,
hypot, wrap (an angle into (-pi, pi]); < <= > >= == !=, chained too; `in` a list of texts; and, or, not. Nothing else is
evaluated, and no text reaches the interpreter.

The margin of a comparison of numbers is their distance on the right side, in their own unit; of `and` the lesser, of
`or` the greater. Text, flags and a bare name (true where it is not zero) hold or do not, by an infinite margin.
A comparison with something that is not there yet, or not a number, holds in neither direction.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from bench.check.temporal import Atom, Margin
from bench.config import nearest

Sample: TypeAlias = Mapping[str, Any]
"""One tick: signal -> number or text; a signal that has no value yet is None or missing."""
_Value: TypeAlias = Callable[[Sample], Any]

TEXTS = ("link", "driver")
"""Signals that are no numbers."""
MOST_CHARACTERS = 1000
_LEAST = 5e-324
"""How far a strict comparison of equals is from holding: the smallest number there is, so that the sign is right."""
_NOT_A_NUMBER = math.nan
_OPPOSITE: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_FUNCTIONS: dict[str, tuple[Callable[..., float], int, int]] = {
    "abs": (abs, 1, 1),
    "min": (min, 2, 99),
    "max": (max, 2, 99),
    "hypot": (math.hypot, 2, 2),
    "wrap": (lambda angle: math.remainder(angle, math.tau), 1, 1),
}
_ARITHMETIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}


def condition(text: str, signals: Sequence[str]) -> Atom:
    """The condition as an atom. Raises ValueError with what is wrong and the nearest signal."""
    reader = _Reader(text, signals)
    return Atom(reader.truth(reader.tree, True), reader.truth(reader.tree, False))


def signals_in(text: str, signals: Sequence[str]) -> frozenset[str]:
    """Which signals a condition reads, in the same grammar. Raises ValueError as `condition` does."""
    condition(text, signals)
    return frozenset(node.id for node in ast.walk(_parsed(text)) if isinstance(node, ast.Name)) & frozenset(signals)


def _parsed(text: str) -> ast.expr:
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"expected a condition of at most {MOST_CHARACTERS} characters, got {len(text)}")
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        shown = text if len(text) <= 60 else f"{text[:57]}..."
        raise ValueError(f"{shown!r} is no condition; expected something like abs(vx_mps) < 0.05") from None


class _Reader:
    """Turns a tree into functions of a sample."""

    def __init__(self, text: str, signals: Sequence[str]) -> None:
        self._text, self._signals = text, signals
        self.tree = _parsed(text)

    def truth(self, node: ast.expr, wanted: bool) -> Margin:
        """By how much the condition holds (`wanted`) or does not."""
        match node:
            case ast.BoolOp(op=op, values=values):
                margins = [self.truth(value, wanted) for value in values]
                least = isinstance(op, ast.And) == wanted
                return _all_of(margins) if least else _any_of(margins)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return self.truth(operand, not wanted)
            case ast.Compare(left=left, ops=ops, comparators=comparators):
                sides = [left, *comparators]
                pairs = zip(sides, ops, comparators, strict=False)
                margins = [self._comparison(one, op, other, wanted) for one, op, other in pairs]
                return _all_of(margins) if wanted else _any_of(margins)
            case ast.Constant(value=bool() as value):
                margin = math.inf if value == wanted else -math.inf
                return lambda _sample: margin
            case ast.Name():
                return _flag(self.value(node), wanted)
        raise self._refuse(node, "expected a comparison, a flag, and, or, not")

    def value(self, node: ast.expr) -> _Value:
        """A number or a text."""
        match node:
            case ast.Name(id=name):
                if name not in self._signals:
                    raise ValueError(
                        f"in {self._text!r}: no signal is called {name!r}{nearest(name, list(self._signals))}"
                    )
                return lambda sample: sample.get(name)
            case ast.Constant(value=int() | float() | str() as value):
                return lambda _sample: value
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return _arithmetic(lambda a: -a, [self.value(operand)])
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
                return _arithmetic(_ARITHMETIC[type(op)], [self.value(left), self.value(right)])
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in _FUNCTIONS:
                function, fewest, most = _FUNCTIONS[name]
                if not fewest <= len(args) <= most:
                    expected = fewest if fewest == most else f"{fewest} or more"
                    raise self._refuse(node, f"{name} takes {expected} values")
                return _arithmetic(function, [self.value(arg) for arg in args])
        raise self._refuse(node, "expected a signal, a number, a text, + - * /, abs, min, max, hypot or wrap")

    def _comparison(self, one: ast.expr, op: ast.cmpop, other: ast.expr, wanted: bool) -> Margin:
        kind = type(op) if wanted else _OPPOSITE.get(type(op), type(op))
        left = self.value(one)
        if kind in (ast.In, ast.NotIn):
            if not isinstance(other, ast.List | ast.Tuple | ast.Set):
                raise self._refuse(other, "expected a list of texts or numbers after in")
            return _member(left, [self.value(entry) for entry in other.elts], kind is ast.In)
        if kind not in _OPPOSITE:
            raise self._refuse(one, "expected <, <=, >, >=, == or !=")
        for side, facing in ((one, other), (other, one)):
            if isinstance(side, ast.Constant) and isinstance(side.value, str):
                if kind not in (ast.Eq, ast.NotEq):
                    raise self._refuse(side, "a text is compared with ==, != or in")
                if not isinstance(facing, ast.Name) or facing.id not in TEXTS:
                    raise self._refuse(facing, f"only {' and '.join(TEXTS)} are texts, so nothing else equals one")
        return _compared(kind, left, self.value(other))

    def _refuse(self, node: ast.expr, what: str) -> ValueError:
        return ValueError(f"in {self._text!r}: {what}; got {ast.unparse(node)}")


def _all_of(margins: Sequence[Margin]) -> Margin:
    if len(margins) == 1:
        return margins[0]
    return lambda sample: min([margin(sample) for margin in margins])


def _any_of(margins: Sequence[Margin]) -> Margin:
    if len(margins) == 1:
        return margins[0]
    return lambda sample: max([margin(sample) for margin in margins])


def _flag(value: _Value, wanted: bool) -> Margin:
    def margin(sample: Sample) -> float:
        found = value(sample)
        return -math.inf if found is None or bool(found) != wanted else math.inf

    return margin


def _member(value: _Value, entries: Sequence[_Value], wanted: bool) -> Margin:
    def margin(sample: Sample) -> float:
        found = value(sample)
        if found is None:
            return -math.inf
        return math.inf if any(found == entry(sample) for entry in entries) == wanted else -math.inf

    return margin


def _arithmetic(function: Callable[..., float], values: Sequence[_Value]) -> _Value:
    """Of what is no number, or has no result, the result is not a number."""

    def value(sample: Sample) -> float:
        given = [each(sample) for each in values]
        try:
            return _NOT_A_NUMBER if any(isinstance(one, str) for one in given) else function(*given)
        except (TypeError, ArithmeticError, ValueError):
            return _NOT_A_NUMBER

    return value


def _compared(kind: type[ast.cmpop], left: _Value, right: _Value) -> Margin:
    strict = kind in (ast.Lt, ast.Gt, ast.NotEq)

    def margin(sample: Sample) -> float:
        a, b = left(sample), right(sample)
        if isinstance(a, str) or isinstance(b, str):
            if kind not in (ast.Eq, ast.NotEq) or a is None or b is None:
                return -math.inf
            return math.inf if (a == b) == (kind is ast.Eq) else -math.inf
        if a is None or b is None or a != a or b != b:
            return -math.inf
        if a == b:  # infinities too: their difference is no number
            return -_LEAST if strict else 0.0
        apart: float = b - a
        if kind in (ast.Gt, ast.GtE):
            return -apart
        if kind is ast.Eq:
            return -abs(apart)
        return abs(apart) if kind is ast.NotEq else apart

    return margin
