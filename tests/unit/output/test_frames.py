"""Snapshots come back as they were written, and a film has a frame for each."""

import numpy as np
import pytest

from contactfem.errors import CaseError
from contactfem.output.figures.animation import film
from contactfem.output.figures.frames import (
    Snapshot,
    clear_snapshots,
    read_snapshot,
    snapshot_files,
    write_snapshot,
)
from contactfem.results.data import BodyPicture


def body(name: str, width: float, **fields: np.ndarray) -> BodyPicture:
    points = np.array([[0.0, 0.0], [width, 0.0], [width, 1.0], [0.0, 1.0]])
    cells = np.array([[0, 1, 2], [0, 2, 3]])
    return BodyPicture(name, points, cells, 0.25 * points, fields)


def snapshot(t: float, *, heat: bool) -> Snapshot:
    stress = np.arange(24.0).reshape(4, 6)
    heated = body("block", 2.0, temperature=np.full((4, 1), t), heat_flux=np.ones((4, 2)))
    return Snapshot(t, (body("block", 2.0, stress=stress),), (heated,) if heat else ())


@pytest.mark.parametrize("heat", [False, True])
def test_round_trip(tmp_path, heat):
    written = snapshot(0.5, heat=heat)
    found = read_snapshot(write_snapshot(tmp_path, 1, written))
    assert found.t == 0.5
    for before, after in zip(written.bodies + written.heat, found.bodies + found.heat, strict=True):
        assert (before.name, set(before.fields)) == (after.name, set(after.fields))
        np.testing.assert_array_equal(before.cells, after.cells)
        np.testing.assert_allclose(
            before.points + before.displacement, after.points + after.displacement, rtol=1e-6
        )
        for key, values in before.fields.items():
            np.testing.assert_allclose(values, after.fields[key], rtol=1e-6)


def test_order_and_clearing(tmp_path):
    for number in (2, 10, 1):
        write_snapshot(tmp_path, number, snapshot(float(number), heat=False))
    assert [read_snapshot(path).t for path in snapshot_files(tmp_path)] == [1.0, 2.0, 10.0]
    clear_snapshots(tmp_path)
    assert snapshot_files(tmp_path) == []


@pytest.mark.parametrize("heat", [False, True])
def test_film(tmp_path, heat):
    from PIL import Image

    for number in (1, 2, 3):
        write_snapshot(tmp_path, number, snapshot(float(number), heat=heat))
    with Image.open(film(tmp_path, tmp_path / "film.gif")) as picture:
        assert picture.n_frames == 3 if heat else picture.n_frames >= 1  # equal frames are merged


def test_no_film_without_snapshots(tmp_path):
    with pytest.raises(CaseError, match="no snapshots"):
        film(tmp_path, tmp_path / "film.gif")
