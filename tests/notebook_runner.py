"""Runs a notebook, and a cell more that prints what it has computed."""

import pathlib

import jax
import nbclient
import nbformat
import pytest

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "notebooks"


def executed(name: str, asked: str):
    """A notebook with its outputs; `asked` is the code of its last cell."""
    notebook = nbformat.read(NOTEBOOKS / name, as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell(asked))
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("MPLBACKEND", "agg")
        cache = jax.config.jax_compilation_cache_dir
        if cache:
            environment.setenv("JAX_COMPILATION_CACHE_DIR", str(cache))
            environment.setenv("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
        nbclient.NotebookClient(
            notebook,
            timeout=300,
            kernel_name="python3",
            resources={"metadata": {"path": str(NOTEBOOKS)}},
        ).execute()
    return notebook
