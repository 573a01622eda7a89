"""Floor 7: figures; matplotlib is imported here only."""
