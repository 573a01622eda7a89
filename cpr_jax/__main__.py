"""`python -m cpr_jax`."""

from .cli import command

command()
