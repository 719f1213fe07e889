"""A real-time loop in a process of its own: `child` runs it, `link` is what its parent holds, `wire` what they say."""
