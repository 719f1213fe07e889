"""Formulas of the five source documents as they are printed, faults and all, one file a document.

Nothing here is right by itself: every name ends in `_as_printed`, and its docstring says where it stands, what is wrong
and which row of the errata it is. They live together so that nobody takes one for the bench's own arithmetic. Who uses
them: `bench.errata`, which runs each against geometry and plant, and `choices`, by which a run takes one on purpose.

Units and frames are the document's own. Arithmetic is in double precision, where the documents have C floats.
"""
