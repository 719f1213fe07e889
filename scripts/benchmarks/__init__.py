"""Pieces of scripts/benchmark.py that are long enough for a file of their own."""
