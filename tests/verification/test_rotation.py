"""Two bodies stuck together by friction turn by a right angle: nothing may slide, nothing is lost.

Slip is measured by the change of the mortar operators, which a rigid motion does not change; a
difference of displacements would report the chord of the turn as slip.
"""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.contact.conditions import Contact, ContactLaw
from contactfem.contact.resultants import defects
from contactfem.contact.state import ContactHistory
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.laws.friction import Coulomb
from contactfem.meshes.disk import Disk, Ring
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import line_tangents
from contactfem.mortar.search_range import SearchRange
from contactfem.run.driver import run_case

SIZE, STEPS = 1e-3, 10
HEAD = """
title = "two blocks that turn"
time = { end = "11 s", step = "1 s" }
[materials.soft]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
[materials.hard]
youngs_modulus = "300 MPa"
poisson_ratio = 0.2
[bodies.lower]
material = "soft"
mesh = { builder = "block", width = "1 mm", height = "1 mm", nx = 4, ny = 4 }
[bodies.upper]
material = "hard"
[bodies.upper.mesh]
builder = "block"
width = "WIDTH"
height = "1 mm"
corner = ["LEFT", "1 mm"]
nx = 5
ny = 4
[interfaces.joint]
nonmortar = "SIDES"
friction = { coefficient = 0.8 }
"""
UPPER = 'upper.bottom"\nmortar = "lower.top'
LOWER = 'lower.top"\nmortar = "upper.bottom'


def led(body: str, x: float, y: float, pressed: float) -> str:
    """A vertex that moves down by `pressed` in the first second and turns with the others then."""
    start = np.array((x, y - pressed))
    table = [("0 s", 0.0, 0.0)]
    for k in range(STEPS + 1):
        c, s = np.cos(k * np.pi / 2 / STEPS), np.sin(k * np.pi / 2 / STEPS)
        u = np.array(((c, -s), (s, c))) @ start - (x, y)
        table.append((f"{k + 1} s", *u))
    lines = [f'[[conditions]]\non = "{body}"\nat = ["{x!r} m", "{y!r} m"]']
    for axis in (1, 2):
        rows = ", ".join(f'["{row[0]}", "{float(row[axis])!r} m"]' for row in table)
        lines.append(f"displacement.{'xy'[axis - 1]} = [{rows}]")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("sides", [UPPER, LOWER], ids=["upper", "lower"])
@pytest.mark.parametrize(("width", "left"), [(0.7, 0.15), (1.4, -0.2)])
def test_turning_by_a_right_angle_makes_no_slip(tmp_path, width, left, sides):
    """Slip stays below 1e-9 of the bodies' size and friction dissipates nothing.

    Either side is nonmortar, so there are rim nodes too.
    """
    text = HEAD.replace("SIDES", sides)
    text = text.replace("WIDTH", f"{width} mm").replace("LEFT", f"{left} mm")
    text += "".join(led("lower", x, 0.0, 0.0) for x in (SIZE * np.linspace(0, 1, 5)).tolist())
    top = (SIZE * (left + np.linspace(0, width, 6))).tolist()
    text += "".join(led("upper", x, 2 * SIZE, 0.1 * SIZE) for x in top)
    path = tmp_path / "case.toml"
    path.write_text(text)
    pressed = run_case(read_case(path, ["time.end=1 s"]), MPI.COMM_SELF, None)
    turned = run_case(read_case(path), MPI.COMM_SELF, None)
    assert pressed.converged
    assert turned.converged
    assert len(turned.steps) == STEPS + 1
    before, after = pressed.interfaces[0], turned.interfaces[0]
    held = before.pressure > 0
    assert held.sum() >= 4
    np.testing.assert_allclose(after.pressure, before.pressure, rtol=1e-7, atol=1.0)
    assert abs(after.slip - before.slip).max() < 1e-9 * SIZE
    work = sum(step.dissipation for step in turned.steps[1:])
    assert abs(work) < 1e-9 * SIZE * np.hypot(*turned.steps[-1].forces["joint"])
    turn = np.array(((0.0, 1.0), (-1.0, 0.0)))  # of row vectors
    np.testing.assert_allclose(before.x @ turn, after.x, atol=1e-9 * SIZE)


def closed_ring(facets: int, other: int, seed: int) -> tuple[InterfaceMesh, np.ndarray]:
    """Rim of a disk in a ring with other facets, the ring turned by a part of a facet."""
    disk = Disk(builder="disk", radius="1 m", facets=facets, layers=1).build().surface("rim")
    ring = Ring(builder="ring", inner_radius="1 m", outer_radius="2 m", facets=other, layers=1)
    inner = ring.build().surface("inner")
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi / other)
    c, s = np.cos(angle), np.sin(angle)
    X = np.vstack((disk.X, inner.X @ np.array(((c, s), (-s, c)))))
    n = len(disk.X)
    return InterfaceMesh(n, disk.facets, inner.facets + n, X, np.ones(X.shape, bool)), X


def resultants(mesh: InterfaceMesh, x: np.ndarray) -> tuple[float, float]:
    """Force and moment that uneven tractions leave over, relative to all forces and R = 1."""
    n = mesh.n_nonmortar
    reach = SearchRange.within(0.5, len(mesh.nonmortar))
    law = ContactLaw(Coulomb(1.0), np.ones(n), 1.0, 1.0, 1.0, reach)
    contact = Contact(MPI.COMM_SELF, mesh, law)
    operators = contact.operators(x)
    turn = np.arctan2(x[:n, 1], x[:n, 0])[:, None]
    p, t = 1.0 + 0.5 * np.sin(turn) + 0.4 * np.cos(3 * turn), 0.7 - 0.5 * np.cos(2 * turn)
    traction = p * operators.normals.n + t * line_tangents(operators.normals.n)
    start = ActiveSet(np.full(n, Status.STICK, np.int8), np.zeros((n, 2)))
    history = ContactHistory.at(operators)
    c = contact.state(operators, traction, history, start)
    force = c.nodal_forces()
    moment = np.sum(x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0])
    radius = np.hypot(*x[:n].T).max()  # of polygons that have the area of the circle
    found = defects(c)
    assert found[1] == pytest.approx(abs(moment) / np.hypot(*force.T).sum() / radius, rel=1e-10)
    return found


def test_forces_balance_and_moments_almost():
    """Forces of the two sides cancel to round-off; the moment defect shrinks with h²."""
    facets = (16, 32, 64, 128)
    found = [resultants(*closed_ring(n, 3 * n // 2, 1)) for n in facets]
    assert max(force for force, _ in found) < 1e-14
    moments = np.array([moment for _, moment in found])
    order = -np.polyfit(np.log(facets), np.log(moments), 1)[0]
    print(moments, order)
    assert order >= 1.8
    assert moments[1] <= 1e-3
