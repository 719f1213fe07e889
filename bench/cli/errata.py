"""`wheelbench errata`: the printed formulas of the five source documents, run against geometry and plant."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from bench.cli.output import say

if TYPE_CHECKING:
    from bench.errata.values import Evidence, Figure, Row

LABEL, NAME, RIGHT, PRINTED = 12, 26, 19, 20
"""Widths of the columns: 80 with a space between two."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's own arguments."""
    parser.add_argument("--document", metavar="000..004", help="only the rows of this document")
    parser.add_argument("--row", type=int, metavar="N", help="only this row, 1 to 28")
    parser.add_argument("--json", action="store_true", help="one JSON object a row")


def run(args: argparse.Namespace) -> int:
    """Measure and print each row that was asked for."""
    import json

    from bench.errata import DOCUMENTS, ROWS, rows
    from bench.errors import UsageError

    if args.document is not None and args.document not in DOCUMENTS:
        raise UsageError(f"--document: there is no {args.document!r}; known: {', '.join(DOCUMENTS)}")
    if args.row is not None and not any(row.number == args.row for row in ROWS):
        raise UsageError(f"--row: expected 1 to {len(ROWS)}, got {args.row}")
    chosen = rows(args.document, args.row)
    if not chosen:
        document = rows(number=args.row)[0].document
        raise UsageError(f"--row: {args.row} is a row of document {document}, not of {args.document}")
    for row in chosen:
        evidence = row.measure()
        if args.json:
            print(json.dumps(_facts(row, evidence)), flush=True)
        else:
            say(*lines_of(row, evidence), "", flush=True)
    return 0


def _facts(row: Row, evidence: Evidence) -> dict[str, object]:
    return {
        "row": row.number,
        "document": row.document,
        "where": row.where,
        "printed": row.printed,
        "right": row.right,
        "arithmetic_holds": row.holds,
        "figures": [
            {
                "name": figure.name,
                "ground": figure.ground,
                "unit": figure.unit,
                "right": [_clean(value) for value in figure.right],
                "printed": [_clean(value) for value in figure.printed],
            }
            for figure in evidence.figures
        ],
        "robot": evidence.robot,
    }


def lines_of(row: Row, evidence: Evidence) -> list[str]:
    """One row for people, in 80 columns."""
    kind = ", arithmetic right" if row.holds else ""
    lines = [
        f"{row.number:2}  document {row.document}{kind}: {row.where}",
        *_paragraph("    printed", row.printed),
        *_paragraph("    right", row.right),
        *_columns("", "", "right", "as printed"),
    ]
    ground = ""
    for figure in evidence.figures:
        label = "" if figure.ground == ground else f"    {figure.ground}"
        ground = figure.ground
        lines += _figure_lines(label, figure)
    return lines + _paragraph("    robot", evidence.robot)


def _figure_lines(label: str, figure: Figure) -> list[str]:
    name = f"{figure.name} [{figure.unit}]" if figure.unit else figure.name
    return _columns(label, name, _values(figure.right), _values(figure.printed))


def _columns(label: str, name: str, right: str, printed: str) -> list[str]:
    """One figure: cells that are too long go on in their own column."""
    import textwrap
    from itertools import zip_longest

    cells = (textwrap.wrap(name, NAME), textwrap.wrap(right, RIGHT), textwrap.wrap(printed, PRINTED))
    lines = []
    for one, two, three in zip_longest(*cells, fillvalue=""):
        lines.append(f"{label:{LABEL}} {one:{NAME}} {two:{RIGHT}} {three}".rstrip())
        label = ""
    return lines


def _paragraph(label: str, text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, 80, initial_indent=f"{label:{LABEL}} ", subsequent_indent=" " * (LABEL + 1))


def _values(values: tuple[float, ...]) -> str:
    texts = [_number(value) for value in values]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"


def _number(value: float) -> str:
    """Four significant digits, no exponent down to 0.0001, and no zeros to no purpose."""
    import math

    value = _clean(value)
    if value == 0.0:
        return "0"
    if abs(value) < 1e-4:
        return f"{value:.1e}"
    decimals = max(0, min(8, 3 - math.floor(math.log10(abs(value)))))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _clean(value: float) -> float:
    """Rounding is shown as nothing."""
    return 0.0 if abs(value) < 1e-12 else value
