"""One page that shows and turns the fields of a run."""

from __future__ import annotations

import base64
import html
import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.output.view.reader import FieldReader, outer_triangles

NAME = "view.html"
MOST_FRAMES = 40
NAN = 65535  # stands for no value
STEPS = 65534.0  # of a value between the smallest and the largest
COMPONENTS = {2: ("x", "y"), 3: ("x", "y", "z"), 6: ("xx", "yy", "zz", "xy", "yz", "xz")}
UNITS = {
    "displacement": "m", "stress": "Pa", "von_mises": "Pa", "temperature": "K",
    "mortar_temperature": "K", "heat_flux": "W/m²", "pressure": "Pa", "traction": "Pa",
    "gap": "m", "slip": "m", "dissipation": "W/m²", "conductance": "W/m²/K",
}  # fmt: skip


def write_view(folder: Path, out: Path | None = None) -> Path:
    """Write the page of a run.

    Args:
        folder: of the run.
        out: file to write to; view.html in that folder without.

    Returns:
        The file.

    Raises:
        CaseError: the run has no fields.
        OSError: the page cannot be written.
    """
    reader = FieldReader(folder)
    path = out or folder / NAME
    text = (files("contactfem.output.view") / "view_page.html").read_text("utf-8")
    data = json.dumps(scene(reader), ensure_ascii=False).replace("</", "<\\/")
    title = html.escape(folder.resolve().name)
    draft = path.with_name(f".{path.name}.part")
    draft.write_text(text.replace("__TITLE__", title).replace("__DATA__", data), "utf-8")
    draft.replace(path)
    return path


def scene(reader: FieldReader) -> dict[str, Any]:
    """What the page draws.

    Args:
        reader: the fields.

    Returns:
        Times, and per block its meshes and its frames, of at most 40 times, the last among them.
    """
    last = len(reader.times) - 1
    steps = sorted({round(k) for k in np.linspace(0, last, min(last + 1, MOST_FRAMES))})
    blocks = [_block(reader, name, steps) for name in reader.names]
    return {"times": [reader.times[k] for k in steps], "all": last + 1, "blocks": blocks}


def _block(reader: FieldReader, name: str, steps: list[int]) -> dict[str, Any]:
    """Meshes and frames of a block; a mesh that stays is there once."""
    meshes: list[dict[str, Any]] = []
    frames, before = [], b""
    for step in steps:
        frame = reader.frame(name, step)
        mark = frame.points.tobytes() + frame.cells.tobytes()
        if mark != before:
            before = mark
            triangles, edges = outer_triangles(frame.cells, frame.kind)
            seen = np.unique(np.concatenate((triangles.ravel(), edges.ravel())))
            new = np.zeros(len(frame.points), np.int64)
            new[seen] = np.arange(len(seen))
            meshes.append(_mesh(frame.points[seen], new[triangles], new[edges]))
        values = {key: data[seen] for key, data in frame.fields.items()}
        shift = values.pop("displacement", np.zeros((len(seen), 3)))
        scalars = {"displacement": np.linalg.norm(shift, axis=1)}
        for key, data in values.items():
            scalars |= _scalars(key, data)
        frames.append(
            {
                "mesh": len(meshes) - 1,
                "u": _packed(shift.astype(np.float32)),
                "fields": {key: _quantised(data) for key, data in scalars.items()},
            }
        )
    units = {key: UNITS.get(key.partition(".")[0], "") for key in scalars}
    return {"name": name, "meshes": meshes, "frames": frames, "units": units}


def _mesh(points: Floats, triangles: Ints, edges: Ints) -> dict[str, Any]:
    """A mesh as the page takes it."""
    return {
        "points": _packed(points.astype(np.float32)),
        "triangles": _packed(triangles.astype(np.uint32)),
        "edges": _packed(edges.astype(np.uint32)),
    }


def _scalars(key: str, data: Floats) -> dict[str, Floats]:
    """A field as scalars: itself, or its components and, of a vector, its length."""
    if data.ndim == 1:
        return {key: data}
    names = COMPONENTS[data.shape[1]]
    whole = {} if len(names) == 6 else {key: np.linalg.norm(data, axis=1)}
    return whole | {f"{key}.{name}": data[:, k] for k, name in enumerate(names)}


def _quantised(values: Floats) -> dict[str, Any]:
    """Values in 16 bits between the smallest and the largest of them."""
    known = np.isfinite(values)
    low, high = (float(f(values[known])) if known.any() else 0.0 for f in (np.min, np.max))
    scaled = np.full(len(values), NAN, np.uint16)
    scaled[known] = np.rint((values[known] - low) * (STEPS / ((high - low) or 1.0)))
    return {"low": low, "high": high, "data": _packed(scaled)}


def _packed(array: Any) -> str:
    """Bytes of an array, as text."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
