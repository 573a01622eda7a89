"""Runs a notebook, and a cell more that prints what it has computed."""

import pathlib

import jax
import nbclient
import nbformat
import pytest

from cpr_jax import programs

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "notebooks"

_SHARED = """
__import__("cpr_jax").use_cache({!r})
__import__("jax").config.update("jax_compilation_cache_dir", {!r})
"""
"""Programs of tests are those of the notebook; it has no names from here."""


def executed(name: str, asked: str):
    """A notebook with its outputs; `asked` is the code of its last cell."""
    notebook = nbformat.read(NOTEBOOKS / name, as_version=4)
    folders = str(programs._folder), str(jax.config.jax_compilation_cache_dir)
    notebook.cells.insert(0, nbformat.v4.new_code_cell(_SHARED.format(*folders)))
    notebook.cells.append(nbformat.v4.new_code_cell(asked))
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("MPLBACKEND", "agg")
        nbclient.NotebookClient(
            notebook,
            timeout=300,
            kernel_name="python3",
            resources={"metadata": {"path": str(NOTEBOOKS)}},
        ).execute()
    return notebook
