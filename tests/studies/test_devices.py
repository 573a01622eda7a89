"""Devices that share a study: the numbers of one."""

import numpy as np
import pytest

from .separate import run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("studies")


@pytest.fixture(scope="module")
def alone(folder):
    (study,) = run(folder)
    return study


def test_two_devices_give_the_numbers_of_one(folder, alone):
    (both,) = run(folder, devices=2)
    for name, values in alone.items():
        np.testing.assert_array_equal(both[name], values, err_msg=name)
