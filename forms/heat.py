"""Weak form of heat in one body (12), (20)."""

import ufl
from ufl.core.expr import Expr

from contactfem.forms.kinematics import deformation_gradient


def storage(rate: Expr, v: Expr, capacity: Expr, depth: Expr | float, dx: ufl.Measure) -> ufl.Form:
    """Heat that is stored, ∫ ρ₀ c ϑ̇ δϑ dV (20), (22).

    Args:
        rate: ϑ̇ [K/s].
        v: Test function δϑ [-].
        capacity: ρ₀ c, per reference volume [J/m³/K].
        depth: What one area of the mesh stands for [m³/m²]: 1 m, or the circumference.
        dx: Volume measure of the reference configuration.

    Returns:
        Linear form in v [W].
    """
    return capacity * rate * v * depth * dx


def conduction(
    theta: Expr,
    v: Expr,
    conductivity: Expr,
    F: Expr | None,
    depth: Expr | float,
    dx: ufl.Measure,
) -> ufl.Form:
    """Fourier's law on the deformed body, ∫ k J (C⁻¹ Grad ϑ) · Grad δϑ dV (20).

    Args:
        theta: Temperature [K].
        v: Test function [-].
        conductivity: k [W/m/K].
        F: Deformation gradient [-], shape (3, 3); None where strain is small.
        depth: What one area of the mesh stands for [m³/m²].
        dx: Volume measure of the reference configuration.

    Returns:
        Bilinear form in ϑ and v [W].
    """
    if F is None:
        return conductivity * ufl.inner(ufl.grad(theta), ufl.grad(v)) * depth * dx
    spread = ufl.det(F) * ufl.inner(_current(theta, F), _current(v, F))
    return conductivity * spread * depth * dx


def heat_flux(theta: Expr, conductivity: Expr, F: Expr | None) -> Expr:
    """Heat flux in the current configuration, q = -k grad ϑ = -k F⁻ᵀ Grad ϑ.

    Args:
        theta: Temperature [K].
        conductivity: k [W/m/K].
        F: Deformation gradient [-], shape (3, 3); None where strain is small.

    Returns:
        q [W/m²], as many components as the mesh has dimensions.
    """
    if F is None:
        return -conductivity * ufl.grad(theta)
    dim = ufl.grad(theta).ufl_shape[0]
    flux = -conductivity * _current(theta, F)
    return ufl.as_vector([flux[i] for i in range(dim)])


def surface_ratio(u: Expr, N: Expr) -> Expr:
    """Current over reference area of a surface, |J F⁻ᵀ N| (Nanson), depth of a plane body left out.

    Args:
        u: Displacement [m].
        N: Outward normal of the reference configuration [-].

    Returns:
        da/dA [-].
    """
    dim = N.ufl_shape[0]
    area = ufl.cofac(deformation_gradient(u)) * ufl.as_vector(
        [N[i] if i < dim else 0.0 for i in range(3)]
    )
    return ufl.sqrt(ufl.inner(area, area))


def elastic_cooling(theta: Expr, modulus: Expr, growth: Expr, dt: Expr) -> Expr:
    """Heat that straining takes, 3 α K θ (ln J)˙, the term that the paper neglects below (12).

    Args:
        theta: Absolute temperature θ [K].
        modulus: 3 α K [Pa/K].
        growth: Change of ln J, or of tr ε where strain is small, over the step [-].
        dt: Length of the step [s].

    Returns:
        Power per reference volume [W/m³].
    """
    return modulus * theta * growth / dt


def _current(scalar: Expr, F: Expr) -> Expr:
    """Gradient in the current configuration, F⁻ᵀ Grad, with three components."""
    g = ufl.grad(scalar)
    dim = g.ufl_shape[0]
    return ufl.inv(F).T * ufl.as_vector([g[i] if i < dim else 0.0 for i in range(3)])
