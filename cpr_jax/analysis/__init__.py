"""Floor 5: what one equilibrium says about its neighbourhood."""
