"""Temperature and motion between the two meshes of a body (28)."""

from functools import cached_property

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.fem.body_mesh import dofs_at_vertices
from contactfem.fem.vertex_values import VertexValues
from contactfem.heat.body import HeatBody
from contactfem.mechanics.body import BodyProblem
from contactfem.transfer.lumped_projection import LumpedProjection
from contactfem.transfer.volume import VolumeTransfer


class BodyLink:
    """Displacement to a body's thermal mesh, and temperature back to its mechanical one (28).

    Args:
        comm: All ranks.
        mechanics: The body's mechanical problem.
        heat: Its heat problem; on the same mesh nothing is interpolated.
    """

    def __init__(self, comm: MPI.Comm, mechanics: BodyProblem, heat: HeatBody) -> None:
        self._comm, self._mechanics, self._heat = comm, mechanics, heat
        self._same = mechanics.mesh is heat.mesh
        domain = heat.mesh.mesh
        self._u_dofs = dofs_at_vertices(domain, heat.displacement_space)[0]
        temperature = mechanics.temperature
        assert temperature is not None
        self._temperature = temperature
        self._theta_dofs = dofs_at_vertices(mechanics.mesh.mesh, temperature.function_space)[0]
        if self._same:
            return
        self._u_source = VertexValues(comm, mechanics.mesh, mechanics.vertex_space)
        self._u_target = VertexValues(comm, heat.mesh, heat.displacement_space)
        self._theta_source = VertexValues(comm, heat.mesh, heat.V)
        self._theta_target = VertexValues(comm, mechanics.mesh, temperature.function_space)

    @property
    def expansion(self) -> float:
        """Coefficient of expansion [1/K]; 0 for a user's energy that calls it otherwise."""
        return float(self._mechanics.law.parameters.get("expansion", 0.0))

    @cached_property
    def extent(self) -> float:
        """Largest extent of the body [m]; collective."""
        x = self._heat.mesh.mesh.geometry.x
        found = np.concatenate((x.max(axis=0, initial=-np.inf), (-x).max(axis=0, initial=-np.inf)))
        self._comm.Allreduce(MPI.IN_PLACE, found, MPI.MAX)
        return float((found[:3] + found[3:]).max())

    def prepare(self) -> None:
        """Make both transfers, for a run that needs them in every step; collective."""
        if not self._same:
            _ = self._to_heat, self._to_mechanics

    @cached_property
    def _to_heat(self) -> VolumeTransfer:
        return VolumeTransfer(self._comm, self._mechanics.mesh, self._heat.mesh, self._heat.name)

    @cached_property
    def _to_mechanics(self) -> LumpedProjection:
        return LumpedProjection(self._comm, self._heat.mesh, self._mechanics.mesh, self._heat.name)

    def set_displacement(self) -> None:
        """Give the heat problem the present displacement; collective."""
        mechanics, u = self._mechanics, self._heat.u.x.array
        if self._same:
            u[self._u_dofs] = mechanics.u.x.array[mechanics.vertex_dofs]
        else:
            values = self._u_source.replicate(mechanics.u.x.array)
            self._u_target.insert(self._to_heat(values), u)

    def set_temperature(self, theta: Floats) -> None:
        """Give the mechanical problem temperatures of the heat problem, flat local; collective."""
        array = self._temperature.x.array
        if self._same:
            array[self._theta_dofs] = theta[self._heat.vertex_dofs]
        else:
            values = self._theta_source.replicate(theta)
            self._theta_target.insert(self._to_mechanics(values), array)

    @property
    def mechanical_temperature(self) -> Floats:
        """Temperatures that mechanics has, flat local; to be written to [K]."""
        array: Floats = self._temperature.x.array
        return array
