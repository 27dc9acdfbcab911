"""Whole runs that no case file covers: energies, obstacles, failed steps, starts with a gap."""

import textwrap
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case
from contactfem.solvers.newton import NewtonSolver, SolveReport, StepInput

HEAD = """
title = "test"
strain = "{strain}"
time = {{ end = "1 s", step = "{step}" }}
[materials.solid]
model = "{model}"
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
"""
BLOCK = """
[bodies.block]
material = "solid"
mesh = {{ builder = "block", width = "2 mm", height = "1 mm", nx = {n}, ny = 4 }}
"""
PRESCRIBED = """
[[conditions]]
on = "block.bottom"
displacement = ["0 mm", "0 mm"]
"""
USER_ENERGY = '''
"""The same solid, written by a user."""
import ufl

def psi(F, theta, parameters):
    """Free energy."""
    K, mu, alpha = (parameters[k] for k in ("bulk_modulus", "shear_modulus", "expansion"))
    J = ufl.det(F)
    return (K / 2 * (ufl.ln(J) - 3 * alpha * theta) ** 2
            + mu / 2 * (J ** (-2 / 3) * ufl.inner(F, F) - 3))
'''


def head(strain: str = "finite", step: str = "1 s", model: str = "neo-hooke") -> str:
    return HEAD.format(strain=strain, step=step, model=model)


def solve(folder: Path, text: str) -> RunResult:
    path = folder / "case.toml"
    path.write_text(textwrap.dedent(text))
    return run_case(read_case(path), MPI.COMM_SELF, None)


def test_user_energy_gives_the_same_numbers(tmp_path):
    """A law is one function of a user's; written differently it must not change the answer."""
    (tmp_path / "mine.py").write_text(USER_ENERGY)
    press = '[[conditions]]\non = "block.top"\ndisplacement = ["0.2 mm", "-0.2 mm"]\n'
    body = BLOCK.format(n=6) + PRESCRIBED + press
    ours = solve(tmp_path, head() + body)
    theirs = solve(tmp_path, head(model="mine.py:psi") + body)
    assert np.abs(ours.bodies[0].displacement).max() > 1e-4
    difference = ours.bodies[0].displacement - theirs.bodies[0].displacement
    assert np.abs(difference).max() <= 1e-15


def test_follower_pressure_turns_with_the_surface(tmp_path):
    """Pressure on all free sides of a block, its bottom on rollers, is a hydrostatic state.

    A dead load would shear it as soon as it changes shape: J from p = -K ln J / J.
    """
    sides = "".join(
        f'[[conditions]]\non = "block.{side}"\npressure = "30 MPa"\n'
        for side in ("left", "right", "top")
    )
    rollers = '[[conditions]]\non = "block.bottom"\ndisplacement.y = "0 mm"\n'
    corner = '[[conditions]]\non = "block"\nat = ["0 mm", "0 mm"]\ndisplacement.x = "0 mm"\n'
    result = solve(tmp_path, head() + BLOCK.format(n=4) + sides + rollers + corner)
    stress = result.bodies[0].fields["stress"]
    np.testing.assert_allclose(stress[:, 0], -30e6, rtol=1e-9)
    np.testing.assert_allclose(stress[:, 1], -30e6, rtol=1e-9)
    assert np.abs(stress[:, 3]).max() < 1e-9 * 30e6


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_three_dimensional_bulk(tmp_path, cell):
    """Uniaxial strain in 3D is exact on any mesh: σ = K ln λ / λ + 2/3 μ (λ² - 1) / λ^(5/3)."""
    text = f"""
    dimension = "3d"
    {head().strip()}
    [bodies.box]
    material = "solid"
    mesh = {{ builder = "box", width = "1 mm", height = "1 mm", depth = "1 mm", nx = 2, ny = 3,
             nz = 2, cell = "{cell}" }}
    """.replace("\n             ", " ")
    text = "\n".join(line.strip() for line in text.splitlines())
    held = (("left", "x"), ("right", "x"), ("back", "z"), ("front", "z"), ("bottom", "y"))
    for side, axis in held:
        text += f'\n[[conditions]]\non = "box.{side}"\ndisplacement.{axis} = "0 mm"\n'
    text += '[[conditions]]\non = "box.top"\ndisplacement.y = "-0.2 mm"\n'
    result = solve(tmp_path, text)
    E, nu, stretch = 100e6, 0.3, 0.8
    K, mu = E / (3 * (1 - 2 * nu)), E / (2 * (1 + nu))
    exact = K * np.log(stretch) / stretch + 2 / 3 * mu * (stretch**2 - 1) / stretch ** (5 / 3)
    np.testing.assert_allclose(result.bodies[0].fields["stress"][:, 1], exact, rtol=1e-9)


OBSTACLE = """
[obstacles.roll]
shape = "circle"
center = ["1 mm", "3.1 mm"]
radius = "2 mm"
displacement.y = [["0 s", "0 mm"], ["1 s", "-0.2 mm"]]
[interfaces.contact]
nonmortar = "block.top"
mortar = "roll"
search_radius = "0.5 mm"
"""


def test_circular_obstacle_pushes_down_on_its_own(tmp_path):
    """A rigid circle has no mesh and no unknowns; its nodes lie on it and forces are symmetric."""
    result = solve(tmp_path, head(step="0.25 s") + BLOCK.format(n=24) + PRESCRIBED + OBSTACLE)
    assert result.converged
    table = result.interfaces[0]
    active = table.status > 0
    assert 3 <= active.sum() < len(active)
    radius = np.hypot(*(table.x[active] - [1e-3, 2.9e-3]).T)
    # mean gaps are zero: nodes deviate by the sag of a facet, (h/2)²/2R
    assert np.abs(radius - 2e-3).max() < (2e-3 / 24 / 2) ** 2 / 4e-3 * 1.5
    fx, fy = result.steps[-1].forces["contact"]
    assert fy > 0 and abs(fx) < 1e-9 * fy
    np.testing.assert_allclose(result.reactions["block.bottom.y"][0], fy, rtol=1e-9)


WEDGE = """
[obstacles.wedge]
shape = "polyline"
points = [["-0.3 mm", "1.5 mm"], ["1 mm", "1.05 mm"], ["2.3 mm", "1.5 mm"]]
displacement.y = [["0 s", "0 mm"], ["1 s", "-0.2 mm"]]
[interfaces.contact]
nonmortar = "block.top"
mortar = "wedge"
search_radius = "1 mm"
"""


def test_polyline_obstacle(tmp_path):
    """A blunt wedge pressed into a block: symmetric, in balance, and nothing reaches into it."""
    result = solve(tmp_path, head(step="0.25 s") + BLOCK.format(n=25) + PRESCRIBED + WEDGE)
    assert result.converged
    table = result.interfaces[0]
    assert (table.status > 0).sum() >= 5
    wedge = 0.85e-3 + 0.45 / 1.3 * np.abs(table.x[:, 0] - 1e-3)
    assert (table.x[:, 1] - wedge).max() < 0.1 * 2e-3 / 25
    fx, fy = result.steps[-1].forces["contact"]
    assert fy > 0 and abs(fx) < 1e-9 * fy
    np.testing.assert_allclose(result.reactions["block.bottom.y"][0], fy, rtol=1e-9)


FALLING = """
[bodies.block]
material = "solid"
mesh = {{ builder = "block", width = "2 mm", height = "1 mm", nx = 5, ny = 3,
         corner = ["0 mm", "{gap}"] }}
[obstacles.floor]
shape = "plane"
point = ["0 mm", "0 mm"]
normal = [0, 1]
[interfaces.sole]
nonmortar = "block.bottom"
mortar = "floor"
search_radius = "2 mm"
[[conditions]]
on = "block.left"
displacement.x = "0 mm"
[[conditions]]
on = "block.top"
traction.y = "-1 MPa"
"""


@pytest.mark.parametrize("gap", ["0 mm", "0.3 mm"])
def test_body_that_only_contact_holds_comes_to_rest_on_the_floor(tmp_path, gap):
    """No springs: the body falls over its gap and carries the load, with uniform pressure.

    It acts on the current width, which the lateral strain ν (1 + ν) p/E has made larger.
    """
    text = head("small") + FALLING.format(gap=gap).replace("\n         ", " ")
    result = solve(tmp_path, text)
    assert result.converged
    exact = 1e6 / (1.0 + 0.3 * 1.3 * 1e6 / 100e6)
    np.testing.assert_allclose(result.interfaces[0].pressure, exact, rtol=1e-9)
    np.testing.assert_allclose(result.interfaces[0].x[:, 1], 0.0, atol=1e-14)


RUB = """
[obstacles.floor]
shape = "plane"
point = ["0 mm", "1 mm"]
normal = [0, -1]
displacement.x = [["0.5 s", "0 mm"], ["1 s", "0.4 mm"]]
displacement.y = [["0 s", "0 mm"], ["0.5 s", "-0.1 mm"]]
[interfaces.sole]
nonmortar = "block.top"
mortar = "floor"
friction = { coefficient = 0.3 }
"""


def test_failed_step_gives_back_everything(tmp_path, monkeypatch):
    """After a step that was solved and then refused, the run goes on as if it had not been tried.

    The reference takes the accepted steps one by one, without a failure: history must be the same.
    """
    text = BLOCK.format(n=6) + PRESCRIBED + RUB
    original, failed = NewtonSolver.solve, []

    def fails_once(self: NewtonSolver, step: StepInput) -> SolveReport:
        report = original(self, step)
        if step.t == 0.75 and not failed:
            failed.append(step.t)
            return SolveReport(False, "refused by the test", report.iterations, report.residuals)
        return report

    monkeypatch.setattr(NewtonSolver, "solve", fails_once)
    interrupted = solve(tmp_path, head(step="0.125 s") + text)
    monkeypatch.undo()
    assert failed and sum(step.cutbacks for step in interrupted.steps) == 1
    stops = ", ".join(f'"{step.t!r} s"' for step in interrupted.steps)
    smooth = solve(tmp_path, head(step="0.125 s") + f"[output]\ntimes = [{stops}]\n" + text)
    assert [step.t for step in smooth.steps] == [step.t for step in interrupted.steps]
    a, b = smooth.interfaces[0], interrupted.interfaces[0]
    assert np.abs(a.slip).max() > 1e-5 and (a.status == 2).any()
    for name in ("pressure", "traction", "slip"):
        scale = np.abs(getattr(a, name)).max()
        np.testing.assert_allclose(getattr(b, name), getattr(a, name), atol=1e-9 * scale)


LAWS = {
    'law = "tresca", limit = "1 MPa"': lambda p, v: 1e6 + 0 * p,
    'coefficient_table = [["0 MPa", 0.3], ["20 MPa", 0.1]]': lambda p, v: (0.3 - 1e-8 * p) * p,
    'coefficient_table = [["0 m/s", 0.2], ["2 mm/s", 0.4]]': lambda p, v: (0.2 + 100 * v) * p,
    'coefficient_table = [["0 K", 0.3], ["20 K", 0.1]]': lambda p, v: 0.2 * p,  # at 10 K
}


@pytest.mark.parametrize("law", LAWS)
def test_friction_laws_in_a_run(tmp_path, law):
    """Where nodes slip the traction is what the law says of pressure, speed and temperature."""
    block = BLOCK.format(n=6) + 'temperature = "10 K"\n'
    text = head(step="0.125 s") + block + PRESCRIBED + RUB.replace("coefficient = 0.3", law)
    before = solve(tmp_path, text.replace('end = "1 s"', 'end = "0.875 s"')).interfaces[0]
    result = solve(tmp_path, text)
    assert result.converged and result.steps[-1].iterations <= 8
    table = result.interfaces[0]
    slips = table.status == 2
    assert slips.sum() >= 3
    speed = np.abs(table.slip - before.slip)[slips] / 0.125
    expected = LAWS[law](table.pressure[slips], speed)
    np.testing.assert_allclose(np.abs(table.traction[slips]), expected, rtol=1e-8)


def test_penalty_converges_to_exact_contact(tmp_path):
    """Of order one in 1/ε_N, and an augmented Lagrangian gives the exact answer with any ε_N."""
    text = head(step="0.25 s") + BLOCK.format(n=6) + PRESCRIBED
    exact = solve(tmp_path, text + RUB).interfaces[0]

    def difference(normal: str) -> float:
        law = RUB.replace("friction =", f"normal = {{ {normal} }}\nfriction =")
        table = solve(tmp_path, text + law).interfaces[0]
        return float(np.abs(table.pressure - exact.pressure).max() / exact.pressure.max())

    errors = [difference(f'law = "penalty", penalty_factor = {f}') for f in (1e1, 1e2, 1e3)]
    rates = np.log10(np.divide(errors[:-1], errors[1:]))
    assert 1e-5 < errors[-1] < 1e-3
    np.testing.assert_allclose(rates, 1.0, atol=0.1)
    assert difference('law = "augmented"') < 1e-6


def test_given_up_run_keeps_the_last_good_state(tmp_path):
    """A load that no friction can carry ends with the reason and the state before it."""
    text = head("small", "0.5 s") + FALLING.format(gap="0 mm").replace("\n         ", " ")
    text = text.replace(
        'on = "block.left"\ndisplacement.x = "0 mm"',
        ('on = "block.top"\ntraction.x = [["0.5 s", "0 MPa"], ["1 s", "0.5 MPa"]]'),
    )
    text = text.replace(
        'traction.y = "-1 MPa"', 'traction.y = [["0 s", "0 Pa"], ["0.5 s", "-1 MPa"]]'
    )
    text = text.replace('search_radius = "2 mm"', "friction = { coefficient = 0.3 }")
    result = solve(tmp_path, text)
    assert not result.converged
    assert "friction" in result.message and "no equilibrium" in result.message
    assert 0.79 <= result.steps[-1].t < 0.8  # friction is exhausted at t = 0.8 s
    np.testing.assert_allclose(result.interfaces[0].pressure.mean(), 1e6, rtol=0.3)
