"""Floor 2: one rod."""
