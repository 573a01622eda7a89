"""The collector rests where it is told to, and is as it was afterwards."""

import gc

import pytest

from cpr_jax.cli import main
from cpr_jax.collection import uncollected


@pytest.fixture(autouse=True, params=[True, False], ids=["on", "off"])
def before(request):
    was = gc.isenabled()
    (gc.enable if request.param else gc.disable)()
    yield request.param
    (gc.enable if was else gc.disable)()


def test_it_rests_and_is_as_it_was(before):
    with uncollected():
        assert not gc.isenabled()
        with uncollected():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled() == before


def test_what_a_block_changes_ends_with_it(before):
    with uncollected():
        gc.enable()
    assert gc.isenabled() == before


def test_after_an_error_too(before):
    with pytest.raises(KeyError), uncollected():
        raise KeyError
    assert gc.isenabled() == before


def test_a_command_leaves_it_as_it_was(before, capsys):
    assert main(["robots", "--json"]) == 0
    assert gc.isenabled() == before
    assert main(["solve", "no-such-robot", "--point", "0", "0.2"]) == 2
    assert gc.isenabled() == before
