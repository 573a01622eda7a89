"""Floor 6: many equilibria."""
