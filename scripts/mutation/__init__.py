"""What `mutate.py` runs: mutants, their code in place, and the tests that they meet."""
