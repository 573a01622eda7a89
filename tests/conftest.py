"""Settings that all tests share."""

import gc
import os
import pathlib
import tempfile

import jax
import jaxlib

# What tests write themselves runs for moments only: it is compiled as quickly as XLA can. The
# package's own programs say how they are to be compiled. Later releases abort at the second flag.
_FLAGS = ["--xla_backend_optimization_level=1"]
if jaxlib.__version__.startswith("0.10."):
    _FLAGS.append("--xla_cpu_use_fusion_emitters=false")
os.environ["XLA_FLAGS"] = " ".join([*_FLAGS, os.environ.get("XLA_FLAGS", "")])

jax.config.update("jax_enable_x64", True)

# What has been traced stays: to look through all of it for garbage takes a second each time.
gc.set_threshold(100_000, 20, 50)

# Workers and runs share what they compile: one suite compiles each program once, however small.
_CACHE = pathlib.Path(tempfile.gettempdir()) / f"cpr_jax-tests-{os.getuid()}"
jax.config.update("jax_compilation_cache_dir", str(_CACHE))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)


def pytest_collection_modifyitems(items):
    """Notebooks and README first: they take longest, and no worker is to be left with one."""
    items.sort(key=lambda item: item.path.parent != pathlib.Path(__file__).parent)
