"""The VTKHDF file of a run, read back with h5py and, where it is installed, with VTK."""

import numpy as np
import pytest

from contactfem.output.vtkhdf import CELLS, Block, VtkHdfFile

h5py = pytest.importorskip("h5py")

CORNERS = {  # of a cell of every kind, in dolfinx order, in a space of so many dimensions
    "interval": [[0, 0], [1, 0]],
    "triangle": [[0, 0], [1, 0], [0, 1]],
    "quadrilateral": [[0, 0], [1, 0], [0, 1], [1, 1]],
    "tetrahedron": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "hexahedron": [[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)],
}


def square(n, t):
    """A square of n by n quadrilaterals and its lower side, with fields that tell the time."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    points = np.column_stack((x.ravel(), y.ravel()))
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    cells = np.column_stack((corner, corner + 1, corner + n + 1, corner + n + 2))
    lower, line = points[: n + 1], np.arange(n)
    fields = {"displacement": t * points, "temperature": t * points[:, 0]}
    error = {"error_density": t * np.arange(n * n)}
    facets = np.column_stack((line, line + 1))
    return [
        Block("pad", points, cells, "quadrilateral", fields, error),
        Block("sole", lower, facets, "interval", {"pressure": t * lower[:, 0]}),
    ]


def at_step(path, name, step):
    """Points, connectivity and fields of a block at one step, by the offsets of the format."""
    with h5py.File(path) as hdf:
        block = hdf["VTKHDF"][name]
        steps = block["Steps"]
        part = steps["PartOffsets"][step]
        n, m = block["NumberOfPoints"][part], block["NumberOfCells"][part]
        first = steps["PointOffsets"][step]
        found = {"points": block["Points"][first : first + n]}
        first, length = steps["ConnectivityIdOffsets"][step, 0], block["NumberOfConnectivityIds"]
        found["cells"] = block["Connectivity"][first : first + length[part]]
        for where, count in (("PointData", n), ("CellData", m)):
            for key, data in block.get(where, {}).items():
                start = steps[f"{where}Offsets"][key][step]
                found[key] = data[start : start + count]
        return found


def test_every_step_has_its_mesh_and_its_fields(tmp_path):
    path = tmp_path / "fields.vtkhdf"
    file = VtkHdfFile(path, None)
    sizes = (3, 3, 5, 5, 2)
    for k, n in enumerate(sizes):
        file.append(0.5 * (k + 1), square(n, 0.5 * (k + 1)))
    with h5py.File(path) as hdf:
        assert list(hdf["VTKHDF"]["pad"]["NumberOfPoints"]) == [16, 36, 9]  # each mesh once
        assert list(hdf["VTKHDF"]["sole"]["Steps/Values"]) == [0.5, 1.0, 1.5, 2.0, 2.5]
    for k, n in enumerate(sizes):
        pad, sole = square(n, 0.5 * (k + 1))
        found = at_step(path, "pad", k)
        assert np.array_equal(found["points"][:, :2], pad.points)
        assert np.array_equal(found["displacement"][:, :2], pad.point_data["displacement"])
        assert np.array_equal(found["temperature"], pad.point_data["temperature"])
        assert np.array_equal(found["error_density"], pad.cell_data["error_density"])
        assert np.array_equal(at_step(path, "sole", k)["pressure"], sole.point_data["pressure"])


def test_a_resumed_run_goes_on_in_the_same_file(tmp_path):
    path, straight = tmp_path / "resumed.vtkhdf", tmp_path / "straight.vtkhdf"
    file = VtkHdfFile(path, None)
    for t, n in ((1.0, 3), (2.0, 3), (3.0, 5), (4.0, 2)):  # the last two do not count
        file.append(t, square(n, t))
    again, once = VtkHdfFile(path, 2.0), VtkHdfFile(straight, None)
    for t, n in ((1.0, 3), (2.0, 3)):
        once.append(t, square(n, t))
    for t, n in ((2.5, 3), (3.5, 4)):
        again.append(t, square(n, t))
        once.append(t, square(n, t))
    for step in range(4):
        for name in ("pad", "sole"):
            found, expected = at_step(path, name, step), at_step(straight, name, step)
            for key in expected:
                assert np.array_equal(found[key], expected[key]), (step, name, key)


def test_an_earlier_run_is_forgotten(tmp_path):
    path = tmp_path / "fields.vtkhdf"
    VtkHdfFile(path, None).append(1.0, square(3, 1.0))
    VtkHdfFile(path, None).append(5.0, square(2, 5.0))
    with h5py.File(path) as hdf:
        assert list(hdf["VTKHDF"]["pad"]["Steps/Values"]) == [5.0]


@pytest.mark.parametrize("kind", CORNERS)
def test_vtk_sees_the_size_of_every_kind_of_cell(tmp_path, kind):
    """A cell whose vertices came in a wrong order would have another size, or none."""
    io = pytest.importorskip("vtkmodules.vtkIOHDF")
    pyvista = pytest.importorskip("pyvista")
    points = 2.0 * np.array(CORNERS[kind], float)
    cells = np.arange(len(points))[None, :]
    path = tmp_path / "fields.vtkhdf"
    VtkHdfFile(path, None).append(1.0, [Block("one", points, cells, kind, {"x": points[:, 0]})])
    reader = io.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = pyvista.wrap(reader.GetOutputDataObject(0))["one"]
    size = grid.compute_cell_sizes()
    dimension = {1: "Length", 2: "Area", 3: "Volume"}[grid.GetCell(0).GetCellDimension()]
    whole = {"interval": 2, "triangle": 2, "quadrilateral": 4, "tetrahedron": 8 / 6}
    assert size[dimension][0] == pytest.approx(whole.get(kind, 8.0), rel=1e-12)
    assert CELLS[kind][0] == grid.celltypes[0]


def test_vtk_sees_meshes_that_change(tmp_path):
    io = pytest.importorskip("vtkmodules.vtkIOHDF")
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "fields.vtkhdf"
    file = VtkHdfFile(path, None)
    for t, n in ((1.0, 3), (2.0, 3), (4.0, 6)):
        file.append(t, square(n, t))
    reader = io.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    for k, (t, n) in enumerate(((1.0, 3), (2.0, 3), (4.0, 6))):
        reader.SetStep(k)
        reader.Update()
        found = pyvista.wrap(reader.GetOutputDataObject(0))
        assert found.keys() == ["pad", "sole"]
        assert (found["pad"].n_cells, found["sole"].n_cells) == (n * n, n)
        assert found["sole"]["pressure"].max() == pytest.approx(t)
        assert found["pad"]["displacement"].max() == pytest.approx(t)
