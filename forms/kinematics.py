"""Kinematics of finite deformation as UFL expressions."""

import ufl
from ufl.core.expr import Expr


def displacement_gradient(u: Expr) -> Expr:
    """Displacement gradient H = Grad u, completed to three dimensions in plane strain.

    Args:
        u: Displacement [m], 2 or 3 components.

    Returns:
        H [-], shape (3, 3).
    """
    h = ufl.grad(u)
    if h.ufl_shape == (3, 3):
        return h
    return ufl.as_tensor(((h[0, 0], h[0, 1], 0.0), (h[1, 0], h[1, 1], 0.0), (0.0, 0.0, 0.0)))


def deformation_gradient(u: Expr) -> Expr:
    """Deformation gradient F = 1 + Grad u.

    Args:
        u: Displacement [m], 2 or 3 components.

    Returns:
        F [-], shape (3, 3).
    """
    return ufl.Identity(3) + displacement_gradient(u)


def thermal_volume_ratio(theta: Expr, alpha: Expr) -> Expr:
    """Thermal part of the volume ratio, J_θ = exp(3 α ϑ) (text below (14)).

    Args:
        theta: Relative temperature [K].
        alpha: Coefficient of thermal expansion [1/K].

    Returns:
        J_θ [-].
    """
    return ufl.exp(3 * alpha * theta)
