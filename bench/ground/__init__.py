"""The floor under a base and the walls around it: forces on wheels and body, as pure arithmetic without any engine."""
