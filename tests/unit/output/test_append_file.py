"""A file that grows step by step is whole after every step, wherever the process dies."""

import os

import numpy as np
import pytest

from contactfem.output.append_file import PAGE, AppendFile, recover, undo_path


class Killed(BaseException):
    """What no handler of the program catches."""


def changed(path, seed):
    """Make random changes that are not committed; returns the file and what it would become."""
    rng = np.random.default_rng(seed)
    file = AppendFile(path)
    expected = bytearray(path.read_bytes())
    for _ in range(12):
        at = int(rng.integers(0, len(expected) + 1))
        data = rng.bytes(int(rng.integers(1, 3 * PAGE)))
        file.seek(at)
        assert file.write(data) == len(data)
        expected[at : at + len(data)] = data
    return file, bytes(expected)


@pytest.mark.parametrize("seed", range(8))
def test_reads_what_was_written_before_and_after_the_commit(tmp_path, seed):
    path = tmp_path / "f"
    path.write_bytes(np.random.default_rng(99).bytes(5 * PAGE + 17))
    file, expected = changed(path, seed)
    file.seek(0)
    assert file.read() == expected
    file.seek(PAGE - 3)
    assert file.read(2 * PAGE) == expected[PAGE - 3 : 3 * PAGE - 3]
    file.commit()
    assert path.read_bytes() == expected
    file.seek(0)
    assert file.read() == expected
    file.close()


def test_without_a_commit_nothing_is_changed(tmp_path):
    path = tmp_path / "f"
    path.write_bytes(b"before" * 1000)
    file, _ = changed(path, 1)
    file.close()
    assert path.read_bytes() == b"before" * 1000


@pytest.mark.parametrize("dies_at", range(12))
def test_dying_anywhere_leaves_the_old_or_the_new_content(tmp_path, monkeypatch, dies_at):
    path = tmp_path / "f"
    before = np.random.default_rng(7).bytes(6 * PAGE + 100)
    path.write_bytes(before)
    file, after = changed(path, dies_at)
    put, calls = AppendFile._put, []

    def dying(self, number):
        if len(calls) == dies_at:
            raise Killed
        calls.append(number)
        put(self, number)

    monkeypatch.setattr(AppendFile, "_put", dying)
    try:
        file.commit()
    except Killed:
        os.close(os.dup(file._file.fileno()))  # whatever the buffer holds may or may not arrive
        file._file.flush()
    file.close()
    recover(path)
    found = path.read_bytes()
    assert found == after or found[: len(before)] == before
    assert not undo_path(path).exists()


def test_an_unfinished_note_is_not_believed(tmp_path):
    path = tmp_path / "f"
    path.write_bytes(b"whole")
    undo_path(path).write_bytes(b"\x01" * 50)
    recover(path)
    assert path.read_bytes() == b"whole"
    assert not undo_path(path).exists()


def test_a_full_disk_leaves_the_file_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "f"
    path.write_bytes(b"x" * (2 * PAGE))
    file, _ = changed(path, 3)

    def full(self, numbers):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(AppendFile, "_note", full)
    with pytest.raises(OSError, match="No space left"):
        file.commit()
    file.close()
    assert path.read_bytes() == b"x" * (2 * PAGE)


def test_pages_that_are_cut_off_are_gone(tmp_path):
    path = tmp_path / "f"
    path.write_bytes(b"abc" * PAGE)
    file = AppendFile(path)
    file.truncate(5)
    file.seek(0)
    assert file.read() == b"abcab"
    file.commit()
    file.close()
    assert path.read_bytes() == b"abcab"
