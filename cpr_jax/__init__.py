"""Continuum parallel robots: statics, sensitivities and uncertainty ellipsoids, in JAX.

The public names are those of `__init__.pyi`, each loaded when it is first used: a command line
can then refuse a wrong argument before JAX is imported. Importing changes no setting; enable
float64 with `jax.config.update("jax_enable_x64", True)` before building a robot.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
