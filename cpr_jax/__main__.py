"""`python -m cpr_jax`."""

from .cli import main

raise SystemExit(main())
