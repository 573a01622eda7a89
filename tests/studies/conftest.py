"""The study that devices and processes are to repeat."""

import pytest

from .separate import run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("studies")


@pytest.fixture(scope="module")
def alone(folder):
    (study,) = run(folder)
    return study
