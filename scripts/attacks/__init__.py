"""What `fuzz.py` and the tests throw at every decoder: inputs, and what must hold whatever comes in."""
