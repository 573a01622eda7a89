"""Settings that all tests share."""

import gc
import os
import pathlib
import tempfile

import jax
import jaxlib
import pytest

from cpr_jax import use_cache

# What tests write themselves runs for moments only: it is compiled as quickly as XLA can. Later
# releases abort at the second flag.
_FLAGS = ["--xla_backend_optimization_level=1"]
if jaxlib.__version__.startswith("0.10."):
    _FLAGS.append("--xla_cpu_use_fusion_emitters=false")
os.environ["XLA_FLAGS"] = " ".join([*_FLAGS, os.environ.get("XLA_FLAGS", "")])

jax.config.update("jax_enable_x64", True)

# What has been traced stays: to look through all of it for garbage takes a second each time.
gc.set_threshold(100_000, 20, 50)

# Runs share what they compile: one suite compiles each program once, however small.
_CACHE = pathlib.Path(tempfile.gettempdir()) / f"cpr_jax-tests-{os.getuid()}"

_PROGRAMS = "CPR_JAX_TEST_PROGRAMS"
"""Variable that tells workers where the programs of a run are."""


def pytest_configure(config):
    """Workers share what they trace; other sources than these would have no use for it."""
    if not hasattr(config, "workerinput"):
        folder = tempfile.TemporaryDirectory(prefix="cpr_jax-test-programs-")
        config.add_cleanup(folder.cleanup)
        os.environ[_PROGRAMS] = folder.name
    use_cache(os.environ[_PROGRAMS])
    jax.config.update("jax_compilation_cache_dir", str(_CACHE))


def pytest_collection_modifyitems(items):
    """What takes longest first, notebooks, README and what is optimised: no worker is to be left
    with one."""
    here = pathlib.Path(__file__).parent
    items.sort(
        key=lambda item: (item.path.parent != here, item.get_closest_marker("optimised") is None)
    )


@pytest.fixture(scope="module", autouse=True)
def optimisations(request):
    """Most tests wait for compilation: they do without XLA's optimisations, with the same numbers
    up to rounding. Files that run for longer are marked `optimised`."""
    hardly = request.node.get_closest_marker("optimised") is None
    # Both for processes that the tests start.
    os.environ["JAX_DISABLE_MOST_OPTIMIZATIONS"] = str(int(hardly))
    jax.config.update("jax_disable_most_optimizations", hardly)
