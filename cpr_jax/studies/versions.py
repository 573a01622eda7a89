"""What a result was made with."""

import importlib.metadata


def versions() -> dict[str, str]:
    """Versions of this package and of those its numbers depend on."""
    names = ("cpr_jax", "jax", "diffrax", "optimistix", "numpy")
    return {name: importlib.metadata.version(name) for name in names}
