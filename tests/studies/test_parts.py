"""Parts of a long run: whole, recognised, refused where they belong to another run."""

import pathlib
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cpr_jax.errors import InputError
from cpr_jax.studies.parts import Parts, digest

ARRAYS = {"x": np.arange(12.0).reshape(3, 4), "flag": np.array([True, False])}


def test_a_part_comes_back_bit_for_bit(tmp_path):
    Parts(tmp_path / "parts", {"a": 1}, resume=False).save("one", ARRAYS)
    found = Parts(tmp_path / "parts", {"a": 1}, resume=True).load("one")
    assert found is not None and found.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(found[name], array)
        assert found[name].dtype == array.dtype


def test_parts_are_read_by_many_threads(tmp_path):
    """Each has the header of an array parsed, which older Pythons cannot do side by side."""
    parts = Parts(tmp_path / "parts", {}, resume=False)
    parts.save("one", ARRAYS | {f"array {k}": np.full(2, k) for k in range(30)})
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(parts.load, ["one"] * 100))
    finally:
        sys.setswitchinterval(before)
    assert all(part is not None and len(part) == 32 for part in found)


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "newer", "locked"])
def test_a_damaged_part_is_as_good_as_none(tmp_path, damage):
    parts = Parts(tmp_path / "parts", {}, resume=False)
    parts.save("one", ARRAYS)
    path = tmp_path / "parts" / "one.npz"
    data = bytearray(path.read_bytes())
    place = data.find(ARRAYS["x"].tobytes()) + 40
    assert place > 40
    data[place] ^= 1
    entry = data.rfind(b"PK\x01\x02")
    newer, locked = bytearray(data), bytearray(data)
    newer[entry + 6], locked[entry + 8] = 109, 1
    damaged = {"cut": data[:-50], "flip": data, "empty": b"", "newer": newer, "locked": locked}
    path.write_bytes(damaged[damage])
    assert parts.load("one") is None


def test_another_configuration_is_refused_and_named(tmp_path):
    Parts(tmp_path / "parts", {"spacing": 1.0, "steps": 10}, resume=False)
    with pytest.raises(InputError, match=r"spacing: 1.0 then, 2.0 now"):
        Parts(tmp_path / "parts", {"spacing": 2.0, "steps": 10}, resume=True)


def test_runs_that_begin_at_once_take_up_nothing_of_each_other(tmp_path):
    first = Parts(tmp_path / "parts", {"seed": 1}, resume=False)
    second = Parts(tmp_path / "parts", {"seed": 2}, resume=False)
    first.save("one", ARRAYS)
    assert second.load("one") is None
    assert first.load("one") is not None


@pytest.mark.parametrize("seeds", [(1, 1), (1, 2)], ids=["same", "other"])
def test_what_ends_first_takes_nothing_from_a_run_beside_it(tmp_path, seeds):
    folder = tmp_path / "parts"
    first, second = (Parts(folder, {"seed": seed}, resume=False) for seed in seeds)
    first.save("one", ARRAYS)
    second.save("two", ARRAYS)
    first.clear()
    assert sorted(path.name for path in folder.iterdir()) == ["configuration.json", "two.npz"]
    again = Parts(folder, {"seed": seeds[1]}, resume=True)
    assert again.load("two") is not None
    again.clear()
    assert not folder.exists()
    # The second one goes on, is killed, and resumed.
    second.save("three", ARRAYS)
    assert Parts(folder, {"seed": seeds[1]}, resume=True).load("three") is not None
    second.clear()
    second.clear()
    assert not folder.exists()


def test_a_kill_while_parts_are_removed_leaves_a_run_to_resume(tmp_path, monkeypatch):
    parts = Parts(tmp_path / "parts", {"a": 1}, resume=False)
    for name in ("one", "two"):
        parts.save(name, ARRAYS)
    real, removed = pathlib.Path.unlink, []

    def killed(path, *args, **options):
        if removed:
            raise KeyboardInterrupt
        removed.append(path)
        real(path, *args, **options)

    monkeypatch.setattr(pathlib.Path, "unlink", killed)
    with pytest.raises(KeyboardInterrupt):
        parts.clear()
    monkeypatch.undo()
    again = Parts(tmp_path / "parts", {"a": 1}, resume=True)
    assert [again.load(name) is None for name in ("one", "two")].count(True) == 1


@pytest.mark.parametrize("configuration", [{"a": 1}, {"a": 2}])
def test_without_resume_no_part_is_lost(tmp_path, configuration):
    Parts(tmp_path / "parts", {"a": 1}, resume=False).save("one", ARRAYS)
    with pytest.raises(InputError, match=r"`resume` .* 1 finished part would be lost"):
        Parts(tmp_path / "parts", configuration, resume=False)
    assert Parts(tmp_path / "parts", {"a": 1}, resume=True).load("one") is not None


def test_without_parts_a_run_begins_anew(tmp_path):
    Parts(tmp_path / "parts", {"a": 1}, resume=False)
    (tmp_path / "parts" / ".abc.part").write_text("interrupted")
    fresh = Parts(tmp_path / "parts", {"a": 2}, resume=False)
    assert fresh.load("one") is None
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["configuration.json"]


def test_to_resume_where_nothing_is_begins(tmp_path):
    parts = Parts(tmp_path / "parts", {"a": 1}, resume=True)
    assert parts.load("one") is None


@pytest.mark.parametrize("name", ["bracket.step", "arrays.npz", "drawings/a.txt"])
@pytest.mark.parametrize("resume", [False, True])
def test_files_of_others_are_not_touched(tmp_path, name, resume):
    place = tmp_path / "parts" / name
    place.parent.mkdir(parents=True)
    place.write_text("mine")
    with pytest.raises(
        InputError, match=f"`out` .*{place.relative_to(tmp_path / 'parts').parts[0]}"
    ):
        Parts(tmp_path / "parts", {}, resume, "out")
    assert place.read_text() == "mine"


def test_a_file_in_the_place_of_the_folder_is_named(tmp_path):
    (tmp_path / "parts").write_text("mine")
    with pytest.raises(InputError, match="it is a file"):
        Parts(tmp_path / "parts", {}, resume=False)


def test_what_is_put_beside_parts_outlives_them(tmp_path):
    parts = Parts(tmp_path / "parts", {}, resume=False)
    parts.save("one", ARRAYS)
    (tmp_path / "parts" / "notes.txt").write_text("mine")
    (tmp_path / "parts" / ".abc.part").write_text("interrupted")
    parts.clear()
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["notes.txt"]


def test_without_a_folder_nothing_is_kept():
    parts = Parts(None, {}, resume=False)
    parts.save("one", ARRAYS)
    assert parts.load("one") is None
    parts.clear()


def test_a_digest_sees_every_number():
    tree = {"a": np.array([1.0, 2.0]), "b": np.array(3.0)}
    assert digest(tree) == digest({"b": np.array(3.0), "a": np.array([1.0, 2.0])})
    assert digest(tree) != digest({"a": np.array([1.0, 2.0]), "b": np.array(3.0000000000000004)})
