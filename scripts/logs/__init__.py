"""Recordings as frames, and faults put into them. Nothing here knows how the bench reads or compares recordings."""
