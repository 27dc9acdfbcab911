"""Pressure, friction and heat between the two meshes of an interface."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.contact.pressure import contact_pressure, continuous_pressure
from contactfem.contact.state import ContactState
from contactfem.heat.interface import HeatExchange, HeatInterface
from contactfem.meshes.data import Surface
from contactfem.transfer.surface import SurfaceTransfer


@dataclass(frozen=True)
class InterfaceLink:
    """An interface of the heat problem and what mechanics gives it.

    Attributes:
        heat: The heat side.
        to_heat: From nodes of the mechanical nonmortar surface to the thermal one.
        to_mechanics: The way back.
        pressure: Pressure over time that stands in for that of mechanics [Pa].
        dissipation: Frictional heat per area that stands in for it [W/m²].
        rubs: Whether mechanics has friction there.
        surface: The mechanical nonmortar surface.
    """

    heat: HeatInterface
    to_heat: SurfaceTransfer
    to_mechanics: SurfaceTransfer
    pressure: Table | None
    dissipation: Table | None
    has_friction: bool
    surface: Surface

    def exchange(
        self, c: ContactState | None, t: float, dt: float, ramp_end: float
    ) -> HeatExchange:
        """What the interface exchanges at the end of a step; collective.

        Args:
            c: Contact conditions there; None without mechanics.
            t: Time at the start of the step [s].
            dt: Its length [s].
            ramp_end: Time at which constant motions are reached [s].
        """
        n = self.to_heat.matrix.shape[1]
        pressure: Floats | None = None
        density, power = np.zeros(n), None
        if c is not None:
            varies = self.heat.law.by_pressure
            comm = self.heat.nodes.comm
            pressure = continuous_pressure(c, comm) if varies else contact_pressure(c)
            if self.has_friction:
                density, power = friction_heat(c, dt)
        if self.pressure is not None:
            pressure = np.full(n, self.pressure(t + dt))
        if self.dissipation is not None:
            density = np.full(n, 0.5 * (self.dissipation(t) + self.dissipation(t + dt)))
            power = None
        x = self.heat.nodes.positions(t + dt, ramp_end)
        heat = self.to_heat(density)
        if power is not None and not heat.any():  # it fell between the thermal nodes
            heat = self.to_heat.spread(density)
        pressed = None if pressure is None else self.to_heat(pressure)
        return self.heat.exchange(x, pressed, heat, power, t + dt)


def friction_heat(c: ContactState, dt: float) -> tuple[Floats, float]:
    """Frictional heat per area d = t·ṡ (17) and frictional power of an interface.

    Args:
        c: Contact conditions at the end of a step.
        dt: Length of the step [s].

    Returns:
        d at the nonmortar nodes [W/m²], (n_nonmortar,), and Σ D_jj t_j·v_j / dt [W/m].
    """
    along = np.einsum("ji,ji->j", c.traction, c.rubbed)
    density = np.where(c.active, along / dt, 0.0)
    power = float(np.sum(c.dissipation)) / dt
    return np.maximum(density, 0.0), power
