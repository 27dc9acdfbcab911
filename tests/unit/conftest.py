"""A made-up but plausible finished run: two bodies in partial slip, as Cattaneo and Mindlin say."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from contactfem.case.interface_laws import Friction
from contactfem.results.data import BodyPicture, InterfaceTable, RunResult, StepReport
from contactfem.verification.contact import cattaneo_mindlin, effective_modulus

LOAD, SHEAR, FRICTION, RADIUS = 10e3, 0.93622e3, 0.2, 8e-3
MODULUS = effective_modulus(200e6, 0.3, 200e6, 0.3)
CYLINDERS = {"load": LOAD, "radius": RADIUS, "radius_2": RADIUS, "effective_modulus": MODULUS}
SOLUTION = cattaneo_mindlin(LOAD, SHEAR, FRICTION, RADIUS, MODULUS, RADIUS)


def expectation(**given: float) -> SimpleNamespace:
    empty = dict.fromkeys(("value", "rel", "abs", "min", "max"))
    return SimpleNamespace(**(empty | given))


def make_case(**changes: Any) -> SimpleNamespace:
    """Make what stands for a case: the names that results are measured and drawn by."""
    parameters = CYLINDERS | {"tangential_load": SHEAR, "friction_coefficient": FRICTION}
    usual = {
        "title": "Two half cylinders in partial slip",
        "references": ("K. L. Johnson, Contact Mechanics",),
        "path": Path("cattaneo_mindlin.toml"),
        "dimension": "plane strain",
        "axes": 2,
        "strain": "finite",
        "force_unit": "N/m",
        "bodies": {"lower": None, "upper": None},
        "interfaces": {
            "sole": SimpleNamespace(mortar="lower.top", friction=Friction(coefficient=FRICTION))
        },
        "probes": {"tip": SimpleNamespace(value="displacement.x")},
        "closed_form": {
            "sole": SimpleNamespace(solution="cattaneo_mindlin", parameters=parameters)
        },
        "obstacles": {},
        "heat": None,
        "study": None,
        "mechanics": True,
        "adaptivity": None,
        "conditions": (),
        "solver": SimpleNamespace(tolerance=1e-10),
        "output": SimpleNamespace(fields=True, figures=True, times=()),
        "expect": {
            "sole.pressure_max": expectation(value=9.351351e6, rel=0.03),
            "sole.traction_error_l2": expectation(max=0.045),
            "sole.force_x": expectation(value=SHEAR, rel=1e-8),
            "iterations.mean": expectation(max=5.0),
        },
    }
    return SimpleNamespace(**(usual | changes))


def make_table(nodes: int = 61, shift: float = 0.0) -> InterfaceTable:
    """Sample the closed form at nodes over 1.5 half-widths on either side, plus a shift."""
    a = SOLUTION.half_width
    x = np.linspace(-1.5 * a, 1.5 * a, nodes) + shift
    h = np.full(nodes, x[1] - x[0])
    h[[0, -1]] *= 0.5
    p, t = SOLUTION.pressure(x), SOLUTION.traction(x)
    status = np.where(p == 0.0, 0, np.where(np.abs(x) < SOLUTION.stick_half_width, 1, 2))
    X = np.stack([x, np.zeros(nodes)], axis=1)
    gap = np.where(p > 0.0, 0.0, (x**2 - a**2) / (2 * RADIUS))
    slip = np.where(status == 2, 1e-6 * (np.abs(x) - SOLUTION.stick_half_width) / a, 0.0)
    arc = x - x[0]
    cover = np.ones(nodes)
    return InterfaceTable(
        "sole",
        X,
        X + np.array([1e-5, -2e-5]),
        arc,
        gap,
        p,
        t,
        slip,
        status.astype(np.int8),
        cover,
        h,
        X,
        p,
    )


def half_plane_stress(points: np.ndarray, sign: float) -> np.ndarray:
    """Stress in a half plane under the closed form, as a sum of Flamant's line loads."""
    a = SOLUTION.half_width
    s = np.linspace(-a, a, 400)
    weight = s[1] - s[0]
    dx = points[:, :1] - s
    depth = np.abs(points[:, 1:]) + 0.03 * a
    common = 2.0 / np.pi * weight / (dx**2 + depth**2) ** 2
    radial = -common * (SOLUTION.pressure(s) * depth + sign * SOLUTION.traction(s) * dx)
    xx, yy = (radial * dx**2).sum(1), (radial * depth**2).sum(1)
    xy = -sign * (radial * dx * depth).sum(1)
    zero = np.zeros_like(xx)
    return np.stack([xx, yy, 0.3 * (xx + yy), xy, zero, zero], axis=1)


def make_body(name: str, sign: float, triangles: bool) -> BodyPicture:
    """Make a block of 4 by 2 half-widths above (sign 1) or below (sign -1) the interface."""
    a = SOLUTION.half_width
    nx, ny = 48, 24
    x, y = np.meshgrid(np.linspace(-2 * a, 2 * a, nx + 1), np.linspace(0.0, 2 * a, ny + 1))
    points = np.stack([x.ravel(), sign * y.ravel()], axis=1)
    corner = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    cells = np.stack([corner, corner + 1, corner + nx + 1, corner + nx + 2], axis=1)
    if triangles:
        cells = np.concatenate([cells[:, [0, 1, 3]], cells[:, [0, 3, 2]]])
    stress = half_plane_stress(points, sign)
    depth = np.abs(points[:, 1])
    sink = -sign * 0.02 * depth
    displacement = np.stack([0.02 * sign * depth, sink], axis=1)
    return BodyPicture(name, points, cells.astype(np.int64), displacement, {"stress": stress})


def make_step(step: int, residuals: tuple[float, ...]) -> StepReport:
    load = {"sole": (SHEAR * max(0, step - 2) / 2, -LOAD * min(step, 2) / 2)}
    return StepReport(
        step, 0.25 * step, 0.25, len(residuals) - 1, int(step == 3), residuals,
        20, 30, 11, load, 1e-6 * step, 0.3, {"sole": 1e-4 * step},
    )  # fmt: skip


@pytest.fixture
def make_run() -> Callable[..., RunResult]:
    """Make the run, with the case changed by keywords."""

    def make(table: InterfaceTable | None = None, **changes: Any) -> RunResult:
        histories = (
            (1.0, 0.3, 2e-2, 1e-4, 3e-9, 1e-14),
            (1.0, 5e-2, 1e-3, 1e-6, 1e-12),
            (1.0, 0.6, 0.2, 5e-2, 2e-3, 4e-6, 1e-11),
            (1.0, 2e-2, 3e-4, 1e-7, 5e-14),
        )
        timings = {"import": 1.1, "setup": 0.3, "jit": 0.0, "newton": 2.0, "assembly": 0.5}
        timings |= {"factorisation": 0.8, "solve": 0.2, "output": 0.1, "total": 3.6}
        timings |= {"contact": 0.2, "contact.search": 0.05, "contact.kernels": 0.15}
        return RunResult(
            case=make_case(**changes),
            steps=tuple(make_step(k + 1, history) for k, history in enumerate(histories)),
            interfaces=(table or make_table(),),
            bodies=(make_body("lower", -1.0, True), make_body("upper", 1.0, False)),
            reactions={"conditions.0": (0.0, 1.0e4)},
            probes={"tip": 2e-5},
            timings=timings,
            sizes={"ranks": 1, "unknowns": 5000, "cells": 3456},
            converged=True,
            message="",
        )

    return make


@pytest.fixture
def table() -> InterfaceTable:
    """Nodal values of the closed form itself."""
    return make_table()


@pytest.fixture
def solution() -> Any:
    """Closed form that the table samples."""
    return SOLUTION


@pytest.fixture
def expecting() -> Callable[..., SimpleNamespace]:
    """Make an expectation."""
    return expectation


@pytest.fixture
def changed() -> Callable[..., Any]:
    """Change fields of a frozen dataclass."""
    return replace
