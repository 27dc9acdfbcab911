"""Cases solved from Python: dictionaries, steps as they come, fields as dolfinx functions."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from dolfinx import fem

from mpi4py import MPI

import contactfem as cf

ROOT = Path(__file__).parents[3]
BLOCK = {
    "title": "A block pressed on a plane",
    "time": {"end": "1 s", "step": "0.5 s"},
    "materials": {"steel": {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3}},
    "bodies": {
        "pad": {
            "material": "steel",
            "mesh": {
                "builder": "block", "width": "4 mm", "height": "2 mm", "nx": 8, "ny": 4,
                "corner": ["0 mm", "0 mm"],
            },
        }
    },
    "obstacles": {"floor": {"shape": "plane", "point": ["0 m", "0 m"], "normal": [0.0, 1.0]}},
    "interfaces": {"sole": {"nonmortar": "pad.bottom", "mortar": "floor"}},
    "conditions": [
        {"on": "pad.top", "displacement": ["0 mm", [["0 s", "0 mm"], ["1 s", "-0.01 mm"]]]},
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def run():
    times = []
    found = cf.solve(cf.Case.from_dict(BLOCK), MPI.COMM_WORLD, on_step=lambda s: times.append(s.t))
    return found, times


@pytest.mark.mpi
@pytest.mark.quick
def test_a_case_from_a_dictionary(run):
    found, times = run
    assert found.converged and not found.message
    assert times == [0.5, 1.0] == [step.t for step in found.steps]
    force = found.steps[-1].forces["sole"][1]
    pressure = found.interfaces["sole"].pressure
    assert np.all(pressure > 0)
    assert force == pytest.approx(-np.mean(pressure) * 4e-3, rel=0.1)


@pytest.mark.mpi
@pytest.mark.quick
def test_fields_are_functions_of_dolfinx(run):
    body = run[0].bodies["pad"]
    assert isinstance(body.u, fem.Function) and body.u.name == "displacement"
    x, u = body.mesh.geometry.x, body.u
    V = u.function_space
    assert V.mesh is body.mesh and V.dofmap.index_map_bs == 2
    values = u.x.array.reshape(-1, 2)[:, 1]
    top = np.isclose(V.tabulate_dof_coordinates()[:, 1], 2e-3)
    assert np.allclose(values[top], -1e-5)
    one = fem.Constant(body.mesh, 1.0)
    import ufl

    area = body.mesh.comm.allreduce(fem.assemble_scalar(fem.form(one * ufl.dx)))
    assert area == pytest.approx(8e-6)
    stress = body.stress.x.array.reshape(-1, 6)
    assert len(x) and stress[:, 1].max() < 0.0 and np.allclose(stress[:, 4:], 0.0)


def test_what_is_not_solved_for_is_told(run):
    with pytest.raises(cf.CaseError, match="'pad' has no temperature: the case does not solve"):
        _ = run[0].bodies["pad"].temperature
    with pytest.raises(AttributeError, match="has no 'presure'; it has X, Y, arc, gap, pressure"):
        _ = run[0].interfaces["sole"].presure


def test_a_mistake_in_a_dictionary_is_told_like_one_in_a_file():
    with pytest.raises(cf.CaseError, match=r"case.toml: time: .*longer than"):
        cf.Case.from_dict(BLOCK | {"time": {"end": "1 s", "step": "2 s"}})


def test_tables_and_pictures_for_notebooks(run):
    pd = pytest.importorskip("pandas")
    sole = run[0].interfaces["sole"].to_pandas()
    assert isinstance(sole, pd.DataFrame)
    assert set(sole["status"]) <= {"stick", "slip", "open", "none"}
    assert list(run[0].to_pandas()["t"]) == [0.5, 1.0]


def test_plot_and_html(run):
    import matplotlib as mpl

    mpl.use("agg")
    axes = run[0].interfaces["sole"].plot("pressure")
    assert axes.get_ylabel() == "pressure [MPa]"
    assert len(axes.lines[0].get_xdata()) == 9
    assert "9 nodes" in run[0].interfaces["sole"]._repr_html_()
    assert "2 steps, reached its end" in run[0]._repr_html_()


def test_temperature_is_a_function_too(tmp_path):
    case = cf.read_case(ROOT / "cases/heated_rod.toml")
    found = cf.solve(case, MPI.COMM_SELF)
    for body in found.result.heat:
        theta = found.bodies[body.name].temperature
        assert isinstance(theta, fem.Function)
        assert theta.x.array.max() == pytest.approx(body.fields["temperature"].max())


def test_the_package_is_light():
    program = (
        "import sys, contactfem as cf; assert 'solve' in dir(cf); heavy = {'dolfinx', 'mpi4py', "
        "'numpy', 'pydantic', 'scipy', 'matplotlib'} & set(sys.modules); assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
    with pytest.raises(AttributeError, match="no attribute 'slove'"):
        _ = cf.slove
