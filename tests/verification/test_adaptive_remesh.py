"""New meshes at every step, without need: what a run has found must hardly change."""

from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
import pytest
from verification.watched import watch

from contactfem.adaptivity.adaptation import Adaptation
from contactfem.adaptivity.decisions import Advance, NewSizes, RemeshAndRepeat
from contactfem.case.read import read_case
from contactfem.results.data import Status

HEAD = """
title = "Two blocks"
strain = "finite"
time = { end = "1 s", step = "0.1 s" }
adaptivity = { mechanics = "99 %" }
[materials.solid]
bulk_modulus = "60 MPa"
shear_modulus = "20 MPa"
expansion = "1e-4 1/K"
density = "1000 kg/m^3"
heat_capacity = "100 J/kg/K"
conductivity = "0.02 W/m/K"
[bodies.upper]
material = "solid"
initial_temperature = "20 K"
mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 12, ny = 6, cell = "triangle" }
[bodies.lower]
material = "solid"
mesh = { builder = "block", width = "2 mm", height = "1 mm", corner = ["0 mm", "-1 mm"], nx = 14, \
ny = 7, cell = "triangle" }
[interfaces.seam]
nonmortar = "upper.bottom"
mortar = "lower.top"
friction = { coefficient = 0.9 }
[[conditions]]
on = "lower.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "upper.top"
displacement.y = [["0 s", "0 mm"], ["0.5 s", "-0.1 mm"]]
displacement.x = [["0.5 s", "0 mm"], ["1 s", "0.02 mm"]]
"""
HEAT = """
[heat]
scheme = "cG(1)"
[interfaces.seam.heat]
law = "constant"
conductance = "100 W/m^2/K"
"""
SIZES = (0.1e-3, 0.104e-3)  # in turn, so that no node but the corners stays


@contextmanager
def remeshed(steps):
    """So many steps are taken first on the old meshes, and then on new ones."""
    count = [0]

    def judge_once(self, state, conditions, heat, t):
        if self._now.remeshes or count[0] == steps:
            return Advance(None, self._report({}, None))
        count[0] += 1
        size = SIZES[count[0] % 2]
        new = self._discretisation

        def sizes(bodies):
            return {body.name: np.full(body.mesh.n_points, size) for body in bodies}

        mechanical = sizes(new.bodies.values())
        heated = sizes(new.heat.bodies) if new.heat is not None else {}
        self._asked = {"mechanics": tuple(mechanical), "heat": tuple(heated)}
        self._reasons = {}
        return RemeshAndRepeat(NewSizes(mechanical, heated))

    with patch.object(Adaptation, "judge", judge_once):
        yield count


def run(folder, text, remeshes):
    """Run a case with new meshes for so many steps.

    Returns the result, and of every step: force, mean temperature, status, largest slip.
    """
    (folder / "case.toml").write_text(text)
    case, steps = read_case(folder / "case.toml"), []

    def see(report, state, discretisation):
        set_temperature = 0.0
        if discretisation.heat is not None:
            ones = [np.ones_like(theta) for theta in state.theta]
            product = discretisation.heat.product
            set_temperature = product(state.theta, ones) / product(ones, ones)
        status = [c.status for c in state.conditions]
        slip = [np.abs(s).max() for s in state.slip]
        steps.append((np.array(report.forces["seam"]), set_temperature, status[0], slip[0]))

    with remeshed(remeshes) as count:
        result = watch(case, see)
    assert result.converged
    assert count[0] == min(remeshes, len(steps)) > 0
    return result, steps


MINI = HEAD.replace("60 MPa", "600 MPa")
SADDLE = HEAD + '[solver]\nsystem = "saddle"\n'
SMALL = HEAD.replace('"finite"', '"small"')
PENALTY = HEAD.replace(
    "friction = { coefficient = 0.9 }",
    'friction = { coefficient = 0.9 }\nnormal = { law = "penalty" }',
)


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(HEAD + HEAT, id="heat"),
        pytest.param(MINI, id="MINI"),
        pytest.param(SADDLE, id="saddle"),
        pytest.param(SMALL, id="small strain"),
        pytest.param(PENALTY, id="penalty"),
    ],
)
def test_a_sticking_block(tmp_path, text):
    """Forces within 0.5 %, the mean temperature to 1e-6, and no slip."""
    _, kept = run(tmp_path, text, 1)
    _, steps = run(tmp_path, text, 99)
    assert abs(kept[-1][0][0]) > 100 and abs(kept[-1][0][1]) > 1e3
    for (force, set_temperature, status, slip), (force0, *_, slip0) in zip(
        steps, kept, strict=True
    ):
        assert np.hypot(*(force - force0)) < 0.005 * np.hypot(*force0)
        if "[heat]" in text:  # insulated: none of the heat gets lost
            assert set_temperature == pytest.approx(10.0, rel=1e-6)
        assert not np.any(status == Status.SLIP)
        assert slip < 1e-12 + 1.1 * slip0  # a penalty lets some through


def test_a_sliding_block(tmp_path):
    """The force of friction, the slip so far and what it dissipates go on as they were."""
    text = HEAD.replace("0.9", "0.1").replace('"0.02 mm"', '"0.2 mm"')
    first, kept = run(tmp_path, text, 1)
    second, steps = run(tmp_path, text, 99)
    assert not np.any(kept[-1][2] == Status.STICK)
    for (force, _, _, slip), (force0, _, _, slip0) in zip(steps, kept, strict=True):
        assert np.hypot(*(force - force0)) < 0.005 * np.hypot(*force0)
        assert slip == pytest.approx(slip0, rel=0.02, abs=1e-7)
    work = [sum(step.dissipation for step in result.steps) for result in (first, second)]
    assert work[0] > 0.1
    assert work[1] == pytest.approx(work[0], rel=0.01)
