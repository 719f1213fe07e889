"""Wires that take their time: bits, stuffing, arbitration, baud rates. What does not fit comes late, or is lost."""
