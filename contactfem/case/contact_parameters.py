"""Parameters of an interface that follow from facets and moduli."""

from dataclasses import dataclass

import numpy as np

from contactfem.case.scene import Interface
from contactfem.common.typing import Floats
from contactfem.geometry.facets import facet_sizes
from contactfem.laws.complementarity import contact_scale
from contactfem.meshes.data import Surface

PENALTY = 10.0  # default penalty over the stiffness of the facets that touch


@dataclass(frozen=True)
class ContactParameters:
    """Resolved constants of an interface with n nonmortar nodes.

    Attributes:
        c: Stiffness of the facets that touch, of the active set [Pa/m], (n,).
        c_n: Factor on c in the trial pressure [-].
        c_t: Factor on c in the trial traction [-].
        normal_compliance: 1/ε_N [m/Pa], (n,); zero for exact contact.
        tangential_compliance: 1/c_T [m/Pa], (n,); zero for exact friction.
    """

    c: Floats
    c_n: float
    c_t: float
    normal_compliance: Floats
    tangential_compliance: Floats


def constants(
    interface: Interface, nonmortar: Surface, moduli: tuple[float, float], mortar: Surface | None
) -> ContactParameters:
    """Constants of an interface of the case.

    Args:
        interface: The interface.
        nonmortar: Its nonmortar surface.
        moduli: Young's moduli of the nonmortar and the mortar body [Pa].
        mortar: Its mortar surface; None for a rigid obstacle, whose modulus is infinite.

    Returns:
        The constants.
    """
    sizes = facet_sizes(nonmortar.X, nonmortar.facets)
    nodes = nonmortar.facets.ravel()
    h = np.bincount(nodes, np.repeat(sizes, nonmortar.facets.shape[1])) / np.bincount(nodes)
    h_mortar = 0.0 if mortar is None else float(facet_sizes(mortar.X, mortar.facets).mean())
    c = contact_scale(h, moduli[0], h_mortar, np.inf if mortar is None else moduli[1])
    normal, tangential = compliances(interface, c)
    friction, factor = interface.friction, interface.normal.c_factor
    c_t = factor * (friction.c_factor if friction else 1.0)
    return ContactParameters(c, factor, c_t, normal, tangential)


def compliances(interface: Interface, c: Floats) -> tuple[Floats, Floats]:
    """Compliances 1/ε_N and 1/c_T of an interface, zero where its law is exact.

    Args:
        interface: The interface of the case.
        c: Stiffness of the facets that touch [Pa/m], (n_nonmortar,).

    Returns:
        Normal and tangential compliance [m/Pa], (n_nonmortar,) each.
    """
    normal, friction = interface.normal, interface.friction
    if normal.law in ("multiplier", "tied"):
        return np.zeros_like(c), np.zeros_like(c)
    epsilon = PENALTY * normal.penalty_factor * c
    if normal.penalty is not None:
        epsilon = np.full_like(c, normal.penalty)
    c_T = epsilon * (friction.penalty_factor if friction else 1.0)
    if friction and friction.penalty is not None:
        c_T = np.full_like(c, friction.penalty)
    return np.asarray(1.0 / epsilon), np.asarray(1.0 / c_T)
