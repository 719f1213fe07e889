"""Proof around the bench: recordings, their comparison, goldens, scenarios."""
