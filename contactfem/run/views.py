"""Bodies and interfaces of a run as Python programs look at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from dolfinx import fem
from dolfinx.mesh import Mesh

from contactfem.case.schema import Case
from contactfem.common.typing import Floats, Ints
from contactfem.common.unit_display import scale_for
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.errors import CaseError
from contactfem.fem.nodal_average import nodal_average
from contactfem.laws.active_set import Status
from contactfem.output.gather import interface_tables
from contactfem.results.data import InterfaceTable

if TYPE_CHECKING:
    from contactfem.heat.body import HeatBody
    from contactfem.mechanics.body import BodyProblem

STRESSES = 6
COLUMNS = {
    "arc": "m", "gap": "m", "pressure": "Pa", "traction": "Pa", "slip": "m", "status": "",
    "coverage": "",
}  # fmt: skip
HEAT_COLUMNS = {
    "temperature": "K", "mortar_temperature": "K", "flux": "W/m^2", "dissipation": "W/m^2",
}  # fmt: skip


class Body:
    """One body of a run, its fields as dolfinx functions on this rank's part of the mesh.

    Args:
        name: Name of the body.
        mechanics: Its mechanical side; None where mechanics is not solved for.
        heat: Its thermal side; None where heat is not solved for.
    """

    def __init__(self, name: str, mechanics: BodyProblem | None, heat: HeatBody | None) -> None:
        self.name, self._mechanics, self._heat = name, mechanics, heat

    @property
    def mesh(self) -> Mesh:
        """The mechanical mesh, or the thermal one where there is no other, as dolfinx has it."""
        body = self._mechanics or self._heat
        assert body is not None
        return body.mesh.mesh

    @property
    def u(self) -> fem.Function:
        """Displacement [m], a copy."""
        body = self._asked("displacement", self._mechanics)
        V = fem.functionspace(self.mesh, ("Lagrange", 1, (self.mesh.geometry.dim,)))
        found = fem.Function(V, name="displacement")
        found.interpolate(body.displacement)
        return found

    @property
    def stress(self) -> fem.Function:
        """Cauchy stress xx, yy, zz, xy, yz, xz [Pa], the mean of the cells around each vertex."""
        body = self._asked("stress", self._mechanics)
        V = fem.functionspace(self.mesh, ("Lagrange", 1, (STRESSES,)))
        return _named(nodal_average(V, body.cell_stress()), "stress")

    @property
    def temperature(self) -> fem.Function:
        """Temperature [K] on the thermal mesh, a copy."""
        return _named(self._asked("temperature", self._heat).theta.copy(), "temperature")

    @property
    def heat_flux(self) -> fem.Function:
        """Heat flux [W/m²] on the thermal mesh, the mean of the cells around each vertex."""
        body = self._asked("heat flux", self._heat)
        V = fem.functionspace(body.mesh.mesh, ("Lagrange", 1, (body.mesh.mesh.geometry.dim,)))
        return _named(nodal_average(V, body.cell_flux()), "heat_flux")

    def _asked(self, what: str, side: Any) -> Any:
        """A side of the body.

        Raises:
            CaseError: The case does not solve for it.
        """
        if side is None:
            raise CaseError(f"body '{self.name}' has no {what}: the case does not solve for it")
        return side


def _named(function: fem.Function, name: str) -> fem.Function:
    """The function under a name that ParaView shows."""
    function.name = name
    return function


@dataclass(frozen=True)
class ContactSurface:
    """An interface at one time, by the nodes of its nonmortar surface; the same on all ranks.

    Attributes:
        table: Its nodal values.
    """

    table: InterfaceTable

    def __getattr__(self, key: str) -> Any:
        """A nodal value such as `pressure`, `traction`, `gap`, `slip`, `status`, `x`, `X`."""
        if key.startswith("_") or not hasattr(self.table, key):
            raise AttributeError(f"an interface has no '{key}'; it has {', '.join(self.columns())}")
        return getattr(self.table, key)

    def columns(self) -> dict[str, Floats | Ints]:
        """Nodal values by name [SI], reference position first."""
        found: dict[str, Floats | Ints] = dict(zip(("X", "Y", "Z"), self.table.X.T, strict=False))
        for key in COLUMNS:
            values = np.asarray(getattr(self.table, key))
            parts = {key: values} if values.ndim == 1 else dict(zip("xyz", values.T, strict=False))
            found |= {k if k == key else f"{key}.{k}": column for k, column in parts.items()}
        if self.table.heat is not None:
            found |= {key: getattr(self.table.heat, key) for key in HEAT_COLUMNS}
        return found

    def to_pandas(self) -> Any:
        """The nodal values as a `pandas.DataFrame`, a row per node.

        Raises:
            CaseError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise CaseError("to_pandas needs pandas: pip install pandas") from None
        columns = self.columns()
        names = [Status(code).name.lower() for code in self.table.status]
        return pd.DataFrame({**columns, "status": names})

    def plot(self, key: str = "pressure", ax: Any = None) -> Any:
        """Draw a nodal value along the surface.

        Args:
            key: A name of `columns`.
            ax: Axes of matplotlib to draw into; new ones if None.

        Returns:
            The axes.

        Raises:
            CaseError: There is no such value.
        """
        columns = self.columns()
        if key not in columns:
            raise CaseError(f"an interface has no '{key}'; it has {', '.join(columns)}")
        if ax is None:
            import matplotlib.pyplot as plt

            ax = plt.subplots(figsize=(6.0, 3.0), layout="constrained")[1]
        unit = (COLUMNS | HEAT_COLUMNS).get(key.partition(".")[0], "m")
        scale = scale_for(float(np.nanmax(np.abs(columns[key]), initial=0.0)), unit)
        ax.plot(1e3 * self.table.arc, np.asarray(columns[key]) / scale.factor, ".-", markersize=4)
        ax.set_xlabel(f"along {self.table.name} [mm]")
        ax.set_ylabel(f"{key} [{scale.label}]" if scale.label else key)
        return ax

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        table = self.table
        counts = ", ".join(
            f"{int((table.status == code).sum())} {Status(code).name.lower()}"
            for code in np.unique(table.status)
        )
        largest = float(np.max(table.pressure, initial=0.0)) / 1e6
        return (
            f"<b>{table.name}</b>: {len(table.X)} nodes ({counts}), "
            f"largest pressure {largest:.4g} MPa"
        )


@dataclass(frozen=True)
class Moment:
    """Bodies and interfaces of a run at one time, after a step that was accepted.

    What `bodies` give on a rank is of its part of the meshes; ask on all ranks.

    Attributes:
        case: The case.
        discretisation: The bodies' equations on their present meshes.
        state: The state.
    """

    case: Case
    discretisation: Discretisation
    state: State

    @property
    def t(self) -> float:
        """Time [s]."""
        return float(self.state.t)

    @cached_property
    def bodies(self) -> dict[str, Body]:
        """The bodies, by name."""
        heat = self.discretisation.heat
        thermal = {body.name: body for body in (heat.bodies if heat is not None else ())}
        mechanics = self.discretisation.bodies if self.case.mechanics else {}
        names = [*self.discretisation.bodies, *thermal]
        return {n: Body(n, mechanics.get(n), thermal.get(n)) for n in dict.fromkeys(names)}

    @cached_property
    def interfaces(self) -> dict[str, ContactSurface]:
        """The interfaces, by name; collective when first asked for."""
        tables: Sequence[InterfaceTable] = interface_tables(self.discretisation, self.state)
        return {table.name: ContactSurface(table) for table in tables}
