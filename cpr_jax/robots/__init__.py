"""Floor 3: descriptions of robots, without any solving."""
