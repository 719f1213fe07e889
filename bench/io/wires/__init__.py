"""The traffic of each wire in figures and words, for a screen that asks: `wiretap` reads it, `table` is the answer."""
