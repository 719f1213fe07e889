"""The faults of the five source documents, row by row, each measured when it is asked for.

    values           what a row is, what its evidence is
    algebra, trial   the two grounds: formulas against the wheel equation, a run of the plant
    document_000 ..  the rows of one document
    rows()           all of them, or those of one document or number

The printed forms are in `bench.as_printed`; the numbers to expect are in `tests/test_errata.py`, from outside.
"""

from __future__ import annotations

from bench.errata import document_000, document_001, document_002, document_003, document_004
from bench.errata.values import Row

DOCUMENTS = ("000", "001", "002", "003", "004")
ROWS: tuple[Row, ...] = (
    *document_000.ROWS,
    *document_001.ROWS,
    *document_002.ROWS,
    *document_003.ROWS,
    *document_004.ROWS,
)


def rows(document: str | None = None, number: int | None = None) -> list[Row]:
    """The rows of one document, or with one number; both None: all."""
    return [row for row in ROWS if document in (None, row.document) and number in (None, row.number)]
