"""Floor 4: R(y, ρ) = 0."""
