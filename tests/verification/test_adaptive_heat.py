"""A hot spot that goes round, and a temperature that changes at once: true errors of runs."""

from functools import cache

import numpy as np
import pytest
from verification.conftest import CASES
from verification.efficiency import Efficiency
from verification.watched import vertex_temperatures, watch

from contactfem.case.read import read_case
from contactfem.geometry.cells import cell_sizes
from contactfem.verification.manufactured import MovingGaussian, SuddenSwitch

SPOT = MovingGaussian(0.2, 2.0)
END = 0.3  # s, more than a quarter of a turn


class Spot(Efficiency):
    """Also where the smallest cells are, and how large those that the spot has left."""

    def __call__(self, report, state, discretisation):
        super().__call__(report, state, discretisation)
        data = vertex_temperatures(discretisation, state)[0][0]
        h = cell_sizes(data.points, data.cells)
        middle = data.points[data.cells].mean(axis=1)
        away = np.hypot(*(middle - SPOT.spot(report.t)).T)
        smallest = np.argsort(h)[: len(h) // 4]
        self.near = [*getattr(self, "near", []), np.mean(away[smallest] < 3 * SPOT.width)]
        start = np.hypot(*(middle - SPOT.spot(0.0)).T) < SPOT.width
        self.behind = [*getattr(self, "behind", []), np.median(h[start]) / np.median(h[smallest])]


@cache
def spot(tolerance=0.1, *overrides):
    seen = Spot(SPOT, 2.0)
    given = [f'time.end="{END} s"', f"adaptivity.tolerance={tolerance}", "expect={}"]
    result = watch(read_case(CASES / "efficiency.toml", [*given, *overrides]), seen)
    assert result.converged
    return seen


@cache
def even(n, step):
    """The same on an even mesh, with even steps."""
    seen = Efficiency(SPOT, 2.0)
    given = [f'time.{key}="{step} s"' for key in ("step", "step_min", "step_max")]
    given += [f"bodies.plate.mesh.n{axis}={n}" for axis in "xy"]
    given += ['bodies.plate.mesh.cell="triangle"', 'bodies.plate.mesh.pattern="alternating"']
    given += [f'time.end="{END} s"', "adaptivity=false", "expect={}"]
    watch(read_case(CASES / "efficiency.toml", given), seen)
    return seen


def ratios(pairs):
    indicated, true = np.array(pairs).T
    known = np.isfinite(indicated)
    return indicated[known] / true[known]


def test_indicated_errors_are_true():
    """Every step within 10 % in space and, but for cut ends of steps, within 15 % in time."""
    seen = spot()
    assert np.all(np.abs(ratios(seen.space) - 1.0) < 0.1)
    rates = ratios(seen.time)
    assert np.mean(np.abs(rates - 1.0) < 0.15) > 0.9
    indicated, true = np.array(seen.time[1:]).T
    assert np.sqrt(np.sum(indicated**2) / np.sum(true**2)) == pytest.approx(1.0, abs=0.05)


def test_the_tolerance_is_kept():
    """By the true errors, with a twentieth of room for the indicator."""
    seen = spot()
    assert max(true for _, true in seen.space) < 1.05 * 0.1
    assert max(true for _, true in seen.time) < 1.05 * 0.1
    assert max(true for _, true in seen.space) > 0.07  # and no better than it has to be


def test_small_cells_follow_the_spot():
    seen = spot()
    assert min(seen.near) > 0.8
    assert seen.behind[0] < 1.5  # small where it starts,
    assert seen.behind[-1] > 2.5  # large when it has gone on
    assert max(seen.cells) < 1.3 * min(seen.cells)


def test_a_third_of_the_unknowns_of_an_even_mesh():
    """That has the same largest true errors."""
    seen, trial = spot(), even(64, 0.0075)
    n = round(64 * max(true for _, true in trial.space) / max(true for _, true in seen.space))
    step = 0.0075 * max(t for _, t in seen.time) / max(t for _, t in trial.time)
    other = even(n, END / np.ceil(END / step))
    for name in ("space", "time"):
        wanted, found = (max(true for _, true in getattr(e, name)) for e in (seen, other))
        assert found == pytest.approx(wanted, rel=0.05)
    assert sum(seen.vertices) < sum(other.vertices) / 3.0


def test_steps_follow_a_switch():
    """Five times shorter at 0.5 s at least, and then longer again; true errors within reach."""
    seen = Efficiency(SuddenSwitch(0.2, 2.0), 2.0)
    result = watch(read_case(CASES / "efficiency.toml", variant="switch"), seen)
    t, dt = np.array(seen.t), np.array(seen.dt)
    assert result.converged
    switching = np.abs(t - 0.5) < 0.04
    assert 5.0 * dt[switching].max() < dt[t < 0.3].max()
    assert 5.0 * dt[switching].max() < dt[t > 0.7].max()
    steep = np.abs(t - 0.5) < 0.035  # where rates are above their mean, that errors are related to
    assert np.array(seen.time)[steep, 1].max() < 0.11
