"""Writing files whole."""

import pytest

from cpr_jax.atomic import write_atomically


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "result.txt"
    write_atomically(target, lambda file: file.write_text("old"))

    def broken(file):
        file.write_text("half")
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        write_atomically(target, broken)
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["result.txt"]


def test_a_file_that_another_process_tidies_up_is_written_again(tmp_path):
    target, scratch = tmp_path / "out" / "map.nc", tmp_path / "out" / "parts"
    seen = []

    def disturbed(file):
        file.write_text("whole")
        seen.append(file)
        if len(seen) == 1:
            file.unlink()
            scratch.rmdir()

    write_atomically(target, disturbed, scratch)
    assert target.read_text() == "whole" and len(seen) == 2

    def hopeless(file):
        file.unlink()

    with pytest.raises(FileNotFoundError):
        write_atomically(target, hopeless)
    assert target.read_text() == "whole"
