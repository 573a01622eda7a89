"""Devices that share a study: the numbers of one."""

import numpy as np

from .separate import run


def test_two_devices_give_the_numbers_of_one(folder, alone):
    (both,) = run(folder, devices=2)
    for name, values in alone.items():
        np.testing.assert_array_equal(both[name], values, err_msg=name)
