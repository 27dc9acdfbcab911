"""Kinematics of finite deformation as UFL expressions."""

import ufl
from ufl.core.expr import Expr


def displacement_gradient(u: Expr, hoop: Expr | float = 0.0) -> Expr:
    """Displacement gradient H = Grad u, completed to three dimensions.

    Args:
        u: Displacement [m], 2 or 3 components.
        hoop: H_33 where u has 2 components [-]: 0 in plane strain, `hoop_strain` with an axis.

    Returns:
        H [-], shape (3, 3).
    """
    h = ufl.grad(u)
    if h.ufl_shape == (3, 3):
        return h
    return ufl.as_tensor(((h[0, 0], h[0, 1], 0.0), (h[1, 0], h[1, 1], 0.0), (0.0, 0.0, hoop)))


def deformation_gradient(u: Expr, hoop: Expr | float = 0.0) -> Expr:
    """Deformation gradient F = 1 + Grad u.

    Args:
        u: Displacement [m], 2 or 3 components.
        hoop: H_33 where u has 2 components [-]: 0 in plane strain, `hoop_strain` with an axis.

    Returns:
        F [-], shape (3, 3).
    """
    return ufl.Identity(3) + displacement_gradient(u, hoop)


def hoop_strain(u: Expr, x: Expr) -> Expr:
    """Extension of the circles around the axis x_0 = 0, u_r / r; not a number on the axis.

    Args:
        u: Displacement, radial and axial [m].
        x: Reference position, radius and height [m].

    Returns:
        u_r / r [-].
    """
    return u[0] / x[0]


def circumference(x: Expr) -> Expr:
    """Length of the circle around the axis x_0 = 0 through a point, 2 π r.

    Args:
        x: Position, radius and height [m].

    Returns:
        2 π r [m].
    """
    return 2 * ufl.pi * x[0]


def thermal_volume_ratio(theta: Expr, alpha: Expr) -> Expr:
    """Thermal part of the volume ratio, J_θ = exp(3 α ϑ) (text below (14)).

    Args:
        theta: Relative temperature [K].
        alpha: Coefficient of thermal expansion [1/K].

    Returns:
        J_θ [-].
    """
    return ufl.exp(3 * alpha * theta)
