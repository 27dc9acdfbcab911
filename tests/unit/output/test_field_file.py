"""Fields and contact surfaces of whole runs in one file, on any number of ranks."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.errors import Interrupted, WriteError
from contactfem.output.field_file import von_mises
from contactfem.run.driver import Invocation, run_case
from contactfem.run.resume import prepare

h5py = pytest.importorskip("h5py")
ROOT = Path(__file__).parents[3]


def blocks(folder):
    """Groups of the blocks by name, in memory: fields of the last step, and times."""
    found = {}
    with h5py.File(folder / "fields.vtkhdf") as hdf:
        for name, block in hdf["VTKHDF"].items():
            if name == "Assembly":
                continue
            found[name] = {"times": block["Steps/Values"][:], "points": block["Points"][:]}
            for where in ("PointData", "CellData"):
                for key, data in block.get(where, {}).items():
                    found[name][key] = data[block["Steps"][f"{where}Offsets"][key][-1] :]
    return found


@pytest.mark.mpi
@pytest.mark.quick
def test_fields_are_those_of_the_result(tmp_path):
    folder = Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
    case = read_case(
        ROOT / "tests/data/pressed_ball.toml", ["output.figures=false", "output.fields=true"]
    )
    result = run_case(case, MPI.COMM_WORLD, folder)
    if MPI.COMM_WORLD.rank > 0:
        return
    found = blocks(folder)
    assert found.keys() == {*case.bodies, *case.interfaces}
    for body in result.bodies:
        block = found[body.name]
        assert list(block["times"]) == [step.t for step in result.steps]
        assert np.array_equal(block["points"][:, :2], body.points)
        assert np.allclose(block["displacement"][:, :2], body.displacement, rtol=1e-12)
        stress = body.fields["stress"]
        assert np.allclose(block["stress"], stress, rtol=1e-12, atol=1e-9 * abs(stress).max())
        assert np.allclose(block["von_mises"], von_mises(stress), rtol=1e-9)
    table = result.interfaces[0]
    joint = found[table.name]
    for key in ("pressure", "traction", "slip", "coverage"):
        assert np.array_equal(joint[key], getattr(table, key))
    assert np.array_equal(joint["status"], table.status)
    assert joint["pressure"].max() > 0


def test_heat_alone_has_no_stress(tmp_path):
    case = read_case(ROOT / "cases/heated_rod.toml", ["output.figures=false"])
    result = run_case(case, MPI.COMM_SELF, tmp_path)
    found = blocks(tmp_path)
    assert found.keys() == set(case.bodies) | set(case.interfaces)
    for body in result.heat:
        assert np.allclose(found[body.name]["temperature"], body.fields["temperature"][:, 0])
        assert np.allclose(found[body.name]["heat_flux"][:, :2], body.fields["heat_flux"])
        assert "stress" not in found[body.name]


def test_heat_of_contact_over_time(tmp_path):
    """The conductance times the jump of temperature is the flux; friction warms both sides."""
    quiet = ["output.figures=false", "output.checkpoint_every=1000"]
    case = read_case(ROOT / "tests/data/warm_slide.toml", quiet)
    result = run_case(case, MPI.COMM_SELF, tmp_path)
    found, table = blocks(tmp_path), result.interfaces[0]
    surface = found[table.name]
    assert np.array_equal(surface["dissipation"], table.heat.dissipation, equal_nan=True)
    known = np.isfinite(surface["conductance"])
    jump = surface["temperature"] - surface["mortar_temperature"]
    assert known.any()
    assert np.allclose((surface["conductance"] * jump)[known], surface["heat_flux"][known])


def test_a_disk_that_is_full_is_told_in_one_line(tmp_path, monkeypatch):
    def full(self, t, blocks):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("contactfem.output.vtkhdf.VtkHdfFile.append", full)
    case = read_case(
        ROOT / "tests/data/pressed_ball.toml", ["output.figures=false", "output.fields=true"]
    )
    with pytest.raises(WriteError, match=r"fields\.vtkhdf: cannot be written: No space left"):
        run_case(case, MPI.COMM_SELF, tmp_path)


def test_the_equivalent_of_uniaxial_stress_and_of_shear():
    stress = np.array([[3.0, 0, 0, 0, 0, 0], [0, 0, 0, 2.0, 0, 0], [5.0, 5.0, 5.0, 0, 0, 0]])
    assert np.allclose(von_mises(stress), [3.0, 2.0 * np.sqrt(3.0), 0.0])


def test_a_resumed_run_has_each_step_once(tmp_path):
    calls = iter(range(1000))
    invocation = Invocation("contactfem run", 0.0, lambda: next(calls) >= 2)
    changes = ["output.figures=false", "output.fields=true", "time.step='0.25 s'"]
    case = read_case(ROOT / "tests/data/pressed_ball.toml", changes)
    with pytest.raises(Interrupted):
        run_case(case, MPI.COMM_SELF, tmp_path, invocation)
    before = blocks(tmp_path)
    resumption = prepare(tmp_path, [])
    result = run_case(resumption.case, MPI.COMM_SELF, tmp_path, resumed=resumption.checkpoint)
    found = blocks(tmp_path)
    for name, block in found.items():
        assert len(before[name]["times"]) == 2
        assert list(block["times"]) == [step.t for step in result.steps]
    body = result.bodies[0]
    assert np.allclose(found[body.name]["displacement"][:, :2], body.displacement, rtol=1e-12)
