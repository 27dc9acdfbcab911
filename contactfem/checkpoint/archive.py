"""A file of named arrays and JSON with a checksum."""

import io
import json
import math
import os
import struct
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from contactfem.errors import CheckpointError

type Array = npt.NDArray[Any]
type Tree = dict[str, Any]  # arrays, or trees, by names without a slash

HEAD = "head"


def write_archive(path: Path, head: dict[str, Any], tree: Tree) -> None:
    """Write a file, and return when it is safe on the disk.

    Args:
        path: the file.
        head: what JSON can say, and numbers that are not finite.
        tree: the arrays.

    Raises:
        OSError: it cannot be written; nothing is left of it.
    """
    arrays = dict(_flat(tree, "/"))
    text = json.dumps({"head": head, "arrays": list(arrays)}).encode()
    whole = io.BytesIO()
    np.savez(whole, **(arrays | {HEAD: np.frombuffer(text, dtype=np.uint8)}))  # type: ignore[arg-type]
    try:
        with path.open("wb") as file:
            file.write(whole.getbuffer())
            file.flush()
            os.fsync(file.fileno())
    except OSError:
        path.unlink(missing_ok=True)
        raise


def read_archive(path: Path) -> tuple[dict[str, Any], Tree]:
    """Read a file that `write_archive` wrote.

    Args:
        path: the file.

    Returns:
        Its head and its arrays.

    Raises:
        CheckpointError: it is not there, not whole, or something else.
    """
    try:
        arrays = _arrays(path)
        said = json.loads(arrays.pop(HEAD).tobytes())
        head = dict(said["head"])
        if said["arrays"] != list(arrays):  # zip files do not guard their list of contents
            raise ValueError("arrays are missing")
        tree = _nested(arrays)
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file") from None
    except OSError as error:
        reason = error.strerror or "not whole"
        raise CheckpointError(f"{path}: cannot be read: {reason}") from None
    except (ValueError, TypeError, KeyError, EOFError, NotImplementedError, RuntimeError,
            AttributeError, MemoryError, OverflowError, struct.error, zipfile.BadZipFile,
            zlib.error):  # fmt: skip
        raise CheckpointError(f"{path}: is damaged, or was never a checkpoint") from None
    return head, tree


def _arrays(path: Path) -> dict[str, Array]:
    """Arrays of a file by name; what does not fit into the file takes no memory.

    Raises:
        ValueError: An array is compressed, of objects, or of another size than its header says.
    """
    arrays = {}
    with zipfile.ZipFile(path) as archive:
        whole = path.stat().st_size
        for info in archive.infolist():
            if info.compress_type != zipfile.ZIP_STORED or info.file_size > whole:
                raise ValueError("not stored as this program stores")
            with archive.open(info) as file:
                arrays[info.filename.removesuffix(".npy")] = _array(file.read())
    return arrays


def _array(data: bytes) -> Array:
    """One array of the bytes of an .npy file."""
    file = io.BytesIO(data)
    version = npy.read_magic(file)
    header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, fortran, dtype = header(file)
    size = math.prod(shape) * dtype.itemsize
    if dtype.hasobject or any(n < 0 for n in shape) or size != len(data) - file.tell():
        raise ValueError("an array of another size than its header says")
    flat = np.frombuffer(data, dtype, offset=file.tell()) if size else np.empty(0, dtype)
    return flat.reshape(shape, order="F" if fortran else "C").copy()


def _flat(tree: Tree, where: str) -> Iterator[tuple[str, Array]]:
    for name, item in tree.items():
        if isinstance(item, dict):
            yield from _flat(item, f"{where}{name}/")
        else:
            yield f"{where}{name}", item


def _nested(arrays: dict[str, Array]) -> Tree:
    tree: Tree = {}
    for path, array in arrays.items():
        *folders, name = path.strip("/").split("/")
        place = tree
        for folder in folders:
            place = place.setdefault(folder, {})
        place[name] = array
    return tree
