"""Frames: all bodies at one time, in one file each."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactfem.common.files import whole_file
from contactfem.results.data import BodyPicture

FOLDER = "snapshots"
MECHANICAL, THERMAL = "body", "heat"


@dataclass(frozen=True)
class Snapshot:
    """All bodies at a time.

    Attributes:
        t: the time [s].
        bodies: on their mechanical meshes, with "stress".
        heat: on their thermal meshes, with "temperature" and "heat_flux"; empty without heat.
    """

    t: float
    bodies: tuple[BodyPicture, ...]
    heat: tuple[BodyPicture, ...]


def write_snapshot(folder: Path, number: int, snapshot: Snapshot) -> Path:
    """Write a snapshot in single precision.

    Args:
        folder: of the run.
        number: of the snapshot, from 1.
        snapshot: what to write.

    Returns:
        The file.

    Raises:
        OSError: it cannot be written.
    """
    arrays: dict[str, object] = {"t": np.array(snapshot.t)}
    for kind, pictures in ((MECHANICAL, snapshot.bodies), (THERMAL, snapshot.heat)):
        for picture in pictures:
            start = f"{kind}/{picture.name}"
            arrays[f"{start}/points"] = picture.points.astype(np.float32)
            arrays[f"{start}/cells"] = picture.cells.astype(np.int32)
            arrays[f"{start}/displacement"] = picture.displacement.astype(np.float32)
            for name, values in picture.fields.items():
                arrays[f"{start}/field/{name}"] = values.astype(np.float32)
    path = folder / FOLDER / f"{number:04d}.npz"
    path.parent.mkdir(exist_ok=True)
    with whole_file(path) as draft, draft.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    return path


def clear_snapshots(folder: Path) -> None:
    """Delete the snapshots of an earlier run."""
    for stale in (folder / FOLDER).glob("*.npz"):
        stale.unlink()


def snapshot_files(folder: Path) -> list[Path]:
    """Files of all snapshots of a run, in order of time."""
    return sorted((folder / FOLDER).glob("[0-9]*.npz"))


def read_snapshot(path: Path) -> Snapshot:
    """Read a snapshot.

    Args:
        path: the file.

    Returns:
        Its content.

    Raises:
        OSError: it cannot be read.
    """
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    names = dict.fromkeys(tuple(key.split("/")[:2]) for key in arrays if "/" in key)
    pictures = {(kind, name): _picture(arrays, kind, name) for kind, name in names}
    return Snapshot(
        float(arrays["t"]),
        tuple(picture for (kind, _), picture in pictures.items() if kind == MECHANICAL),
        tuple(picture for (kind, _), picture in pictures.items() if kind == THERMAL),
    )


def _picture(arrays: dict[str, NDArray[Any]], kind: str, name: str) -> BodyPicture:
    start = f"{kind}/{name}/"
    fields = {
        key.removeprefix(start + "field/"): values.astype(np.float64)
        for key, values in arrays.items()
        if key.startswith(start + "field/")
    }
    return BodyPicture(
        name,
        arrays[start + "points"].astype(np.float64),
        arrays[start + "cells"].astype(np.int64),
        arrays[start + "displacement"].astype(np.float64),
        fields,
    )
