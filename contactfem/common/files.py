"""Files that appear as a whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Write a draft beside a file, which takes its place when the block ends without an error.

    Args:
        path: the file; what was there before is replaced.

    Yields:
        The draft to write; it is removed after an error.

    Raises:
        OSError: if it cannot be written.
    """
    draft = path.with_name(f".{path.stem}.part{path.suffix}")  # writers look at the suffix
    try:
        yield draft
        os.replace(draft, path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def write_whole(path: Path, text: str) -> None:
    """Write a text file so that it is there as a whole or not at all.

    Args:
        path: the file; what was there before is replaced.
        text: its content.

    Raises:
        OSError: if it cannot be written.
    """
    with whole_file(path) as draft:
        draft.write_text(text, encoding="utf-8")
