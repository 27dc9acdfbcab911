"""Runs of cases that are watched step by step, and true errors of their fields."""

from collections.abc import Callable, Sequence
from unittest.mock import patch

import numpy as np

from mpi4py import MPI

from contactfem.adaptivity.recovery.norms import (
    elastic_compliance,
    quadrature,
    sample_points,
    squared_norms,
)
from contactfem.case.schema import Case
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.fem.gathered_mesh import MeshView
from contactfem.fem.vertex_values import VertexValues
from contactfem.output.recorder import Recorder
from contactfem.results.data import MeshErrors, RunResult, StepReport
from contactfem.run import driver as run

Watcher = Callable[[StepReport, State, Discretisation], None]


def watch(case: Case, watcher: Watcher, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
    """Run a case; the watcher sees every accepted step, with the bodies in its state."""

    class Watching(Recorder):
        def step(self, report: StepReport, state: State, errors: Sequence[MeshErrors] = ()) -> None:
            super().step(report, state, errors)
            watcher(report, state, self._discretisation)

    with patch.object(run, "Recorder", Watching):
        return run.run_case(case, comm, None)


def subdivided(points, cells, times):
    """A mesh with every triangle cut into four, `times` over, and the cells' ancestors."""
    origin = np.arange(len(cells))
    for _ in range(times):
        corners = points[cells]
        middle = 0.5 * (corners + np.roll(corners, -1, axis=1))
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = middle.transpose(1, 0, 2)
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3, 2)
        points, cells = corners.reshape(-1, 2), np.arange(3 * len(corners)).reshape(-1, 3)
        origin = np.repeat(origin, 4)
    return points, cells, origin


def stress_error(case, discretisation, exact, times=2):
    """True squares of the error and norm of the stress in the energy norm, per body.

    `exact(name, x)` is the stress (xx, yy, zz, xy) at points (..., 2). Triangles are cut finer for
    the quadrature; quadrilaterals, whose stress is linear in each direction, are not.
    """
    result = {}
    for name, body in discretisation.bodies.items():
        material = case.materials[case.bodies[name].main_material]
        view = MeshView.of(discretisation.system.comm, body.mesh)
        points, cells = view.data.points, view.data.cells
        samples = sample_points(cells.shape[1])
        values = view.cells(body.stress_at(samples).values()[:, :, :4])
        values = values[:, 1:] if len(samples) > 1 else values
        if cells.shape[1] == 3:
            points, cells, origin = subdivided(points, cells, times)
            values = values[origin]
        rule = quadrature(points, cells)
        metric = elastic_compliance(material.E, material.nu)
        wanted = exact(name, rule.x)
        error = squared_norms(rule, wanted - values, metric).sum()
        result[name] = error, squared_norms(rule, wanted, metric).sum()
    return result


def vertex_temperatures(discretisation, state):
    """Temperatures at the vertices of every thermal mesh, with the mesh, on all ranks."""
    comm = discretisation.system.comm
    return [
        (MeshView.of(comm, body.mesh).data, VertexValues(comm, body.mesh, body.V).replicate(theta))
        for body, theta in zip(discretisation.heat.bodies, state.theta, strict=True)
    ]
