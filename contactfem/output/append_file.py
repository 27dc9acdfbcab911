"""A binary file that grows by whole steps, wherever the process dies."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

PAGE = 4096
HEAD = struct.Struct("<QQI")  # size of the file before, number of pages, checksum of what follows


def undo_path(path: Path) -> Path:
    """Where pages stand that are about to be overwritten.

    Args:
        path: the file.

    Returns:
        The path of its undo file.
    """
    return path.with_name(f".{path.name}.undo")


def recover(path: Path) -> None:
    """Bring a file back to its last whole state, if a process died while it was written.

    Args:
        path: the file.

    Raises:
        OSError: that cannot be done.
    """
    undo = undo_path(path)
    if not undo.exists():
        return
    found = _pages_before(undo.read_bytes())
    if found is not None and path.exists():
        size, pages = found
        with path.open("r+b") as file:
            for number, content in pages.items():
                file.seek(number * PAGE)
                file.write(content)
            file.truncate(size)
    undo.unlink()


def _pages_before(text: bytes) -> tuple[int, dict[int, bytes]] | None:
    """Size and pages that an undo file keeps; None if it was not finished: nothing was changed."""
    if len(text) < HEAD.size:
        return None
    size, count, checksum = HEAD.unpack_from(text)
    body = text[HEAD.size :]
    if len(body) != count * (8 + PAGE) or zlib.crc32(body) != checksum:
        return None
    pages = {}
    for k in range(count):
        start = k * (8 + PAGE)
        number = int.from_bytes(body[start : start + 8], "little")
        pages[number] = body[start + 8 : start + 8 + PAGE]
    return size, pages


class AppendFile:
    """What HDF5 takes for a file: changes stay in memory until they are committed.

    A commit first appends, which no reader sees; then it notes the pages that it will overwrite in
    an undo file, overwrites them and removes the note. Die where it may, `recover` makes it whole.

    Args:
        path: the file; made if it is missing.
    """

    def __init__(self, path: Path) -> None:
        recover(path)
        self._path = path
        self._file = path.open("r+b" if path.exists() else "w+b")
        self._before = self._size = self._file.seek(0, os.SEEK_END)
        self._pages: dict[int, bytearray] = {}
        self._at = 0

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place; arguments and result as for every file."""
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        self._at = base + offset
        return self._at

    def tell(self) -> int:
        """Where it is."""
        return self._at

    def flush(self) -> None:
        """Nothing: what counts is the commit."""

    def truncate(self, size: int) -> int:
        """Set the size, in bytes; returns it."""
        self._size = size
        return size

    def readinto(self, buffer: memoryview) -> int:
        """Fill a buffer from here on; returns the number of bytes."""
        length = max(0, min(len(buffer), self._size - self._at))
        self._file.seek(self._at)
        found = self._file.read(min(length, max(0, self._before - self._at)))
        view = memoryview(buffer).cast("B")
        view[:length] = found.ljust(length, b"\0")
        for number, start, stop in _split(self._at, length):
            page = self._pages.get(number)
            if page is not None:
                at = number * PAGE + start - self._at
                view[at : at + stop - start] = page[start:stop]
        self._at += length
        return length

    def read(self, length: int = -1) -> bytes:
        """So many bytes from here on; all by default."""
        buffer = bytearray(max(0, self._size - self._at) if length < 0 else length)
        return bytes(buffer[: self.readinto(memoryview(buffer))])

    def write(self, data: bytes) -> int:
        """Write here, in memory; returns the number of bytes."""
        view = memoryview(data).cast("B")
        for number, start, stop in _split(self._at, len(view)):
            at = number * PAGE + start - self._at
            self._page(number)[start:stop] = view[at : at + stop - start]
        self._at += len(view)
        self._size = max(self._size, self._at)
        return len(view)

    def commit(self) -> None:
        """Write all changes to the disk.

        Raises:
            OSError: there is no room; the file is what it was.
        """
        old = sorted(n for n in self._pages if n * PAGE < self._before)
        try:
            for number in sorted(self._pages.keys() - set(old)):
                self._put(number)
            self._file.flush()
            self._note(old)
        except OSError:
            self._file.truncate(self._before)
            undo_path(self._path).unlink(missing_ok=True)
            raise
        for number in old:
            self._put(number)
        self._file.flush()
        self._file.truncate(self._size)
        undo_path(self._path).unlink(missing_ok=True)
        self._before, self._pages = self._size, {}

    def close(self) -> None:
        """Close, without changes that were not committed."""
        self._file.close()

    def _note(self, numbers: list[int]) -> None:
        """Keep what is about to be overwritten."""
        parts = []
        for number in numbers:
            self._file.seek(number * PAGE)
            content = self._file.read(min(PAGE, self._before - number * PAGE))
            parts.append(number.to_bytes(8, "little") + content.ljust(PAGE, b"\0"))
        body = b"".join(parts)
        head = HEAD.pack(self._before, len(numbers), zlib.crc32(body))
        undo_path(self._path).write_bytes(head + body)

    def _put(self, number: int) -> None:
        """Write one page to its place."""
        start = number * PAGE
        self._file.seek(start)
        self._file.write(self._pages[number][: max(0, min(PAGE, self._size - start))])

    def _page(self, number: int) -> bytearray:
        """A page in memory, as it is now."""
        if number not in self._pages:
            self._file.seek(number * PAGE)
            there = self._file.read(max(0, min(PAGE, self._before - number * PAGE)))
            self._pages[number] = bytearray(there.ljust(PAGE, b"\0"))
        return self._pages[number]


def _split(at: int, length: int) -> list[tuple[int, int, int]]:
    """Pages that a range touches: number, first byte, byte after the last one."""
    parts = []
    for number in range(at // PAGE, -(-(at + length) // PAGE)):
        first = number * PAGE
        parts.append((number, max(0, at - first), min(PAGE, at + length - first)))
    return parts
