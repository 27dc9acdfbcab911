"""Whole skins as surfaces: corners of the nonmortar side lean nowhere."""

from dataclasses import replace

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

from .mesh_files import block, write_case, write_msh

SIDES = ("upper.skin", "lower.skin")


def with_skin(body):
    """A block with its whole boundary as one more side."""
    rows, columns = (len(body.sides[name]) for name in list(body.sides)[::-1][:2])
    number = np.arange(rows * columns).reshape(rows, columns)
    around = (number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[::-1, 0])
    return replace(body, sides={**body.sides, "skin": np.concatenate(around)})


def pressed(folder, comm, columns, sides):
    """What two blocks of some columns give."""
    upper, lower = block("upper", columns[0], 4, 0.0, 8.0), block("lower", columns[1], 3, -6.0, 0.0)
    bodies = with_skin(upper), with_skin(lower)
    if comm.rank == 0:
        for body in bodies:
            body.sides[f"{body.name}_skin"] = body.sides.pop("skin")
        write_msh(folder / "skins.msh", bodies)
        write_case(folder, "skins.msh")
    comm.Barrier()
    nonmortar, mortar = (
        side.replace(".", f".{side.split('.')[0]}_") if "skin" in side else side for side in sides
    )
    changes = [f"interfaces.rub.nonmortar={nonmortar}", f"interfaces.rub.mortar={mortar}"]
    return measure(run_case(read_case(folder / "case.toml", changes), comm, None))


@pytest.mark.parametrize("columns", [(5, 7), (4, 4), (12, 3)])
@pytest.mark.parametrize(
    "sides",
    [SIDES, SIDES[::-1], ("upper.skin", "lower.track"), ("lower.skin", "upper.sole")],
)
def test_skins_pass_the_patch_test(tmp_path, columns, sides):
    """10 MPa on the widened sole, whichever side is nonmortar and however fine it is."""
    check(pressed(tmp_path, MPI.COMM_SELF, columns, sides))


@pytest.mark.mpi
@pytest.mark.parametrize("sides", [SIDES, SIDES[::-1]])
def test_ranks_cut_the_same_corners(tmp_path, sides):
    comm = MPI.COMM_WORLD
    check(pressed(comm.bcast(tmp_path), comm, (5, 7), sides))


def check(found):
    """The uniform state of plane strain, to round-off."""
    strain = 10e6 * (1 + 0.25) / 200e9  # over 1 - ν in height, ν in width
    assert found["rub.pressure_max"] == pytest.approx(10e6 / (1 + 0.25 * strain), rel=1e-9)
    assert found["rub.pressure_min"] == pytest.approx(10e6 / (1 + 0.25 * strain), rel=1e-9)
    assert found["rub.normal_force"] == pytest.approx(120e3, rel=1e-9)
    if MPI.COMM_WORLD.rank == 0:  # which has the fields
        assert found["upper.displacement_y.min"] == pytest.approx(-0.75 * strain * 14e-3, rel=1e-9)
