"""What touches the world outside: the clock, and how a screen follows a bench. Ports and adapters belong here too."""
