"""A file for each thing that scripts/benchmark.py measures, and what they share: timing, the empty call, the table."""
