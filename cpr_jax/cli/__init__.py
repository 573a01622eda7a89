"""Floor 8: the command line."""

from .main import command as command
from .main import main as main
