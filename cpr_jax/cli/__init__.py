"""Floor 8: the command line."""

from .main import main as main
