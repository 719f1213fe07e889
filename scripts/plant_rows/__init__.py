"""The rows of scripts/plant_checks.py: a file for each kind of check, and what they share."""
