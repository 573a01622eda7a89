"""What XLA is told about the compilation of a program."""

import functools
from typing import Any

import jax

HOT = {
    "xla_backend_optimization_level": 3,
    "xla_cpu_use_fusion_emitters": True,
    "xla_cpu_prefer_vector_width": 512,
    "xla_cpu_experimental_ynn_fusion_type": "",
}
"""XLA's usual levels, whatever `XLA_FLAGS` says, and the widest registers that there are: it uses
half of them if it is not told. Sums without its YNN library, which takes far longer for small ones
and in jaxlib 0.10.2 gets some of them wrong."""

QUICK = HOT | {"xla_backend_optimization_level": 1, "xla_cpu_use_fusion_emitters": False}
"""LLVM's first level compiles in three quarters of the time and takes up to a fifteenth longer to
run. XLA's older code generator compiles in half to two thirds of the time and takes up to an eighth
longer. It has left later releases, which compile as quickly without it."""


BRIEF = QUICK | {"xla_backend_optimization_level": 0}
"""LLVM's lowest level halves that time once more. What it makes takes up to four times as long
where it goes through a robot once, three to nine times where it iterates."""


def is_hardly_optimised() -> bool:
    """Whether JAX is to leave most optimisations out: `jax_disable_most_optimizations`."""
    return bool(jax.config.read("jax_disable_most_optimizations"))


def options_of(wishes: dict[str, Any]) -> dict[str, Any]:
    """Options for a program, as far as this release of XLA knows them, for the devices at hand.

    Where JAX is to leave most optimisations out, in a session that compiles much and runs little,
    the package's programs are no exception.
    """
    return _known(tuple((BRIEF if is_hardly_optimised() else wishes).items()))


@functools.cache
def _known(wishes: tuple[tuple[str, Any], ...]) -> dict[str, Any]:
    if jax.default_backend() != "cpu":
        return {}
    if _are_known(wishes):
        return dict(wishes)
    return dict(wish for wish in wishes if _are_known((wish,)))


def _are_known(options: tuple[tuple[str, Any], ...]) -> bool:
    try:
        jax.jit(lambda: 0.0, compiler_options=dict(options)).lower().compile()
    except jax.errors.JaxRuntimeError:
        return False
    return True
