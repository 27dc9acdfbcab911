"""Virtual work of one body (19) and its linearisation."""

from collections.abc import Callable, Mapping

import ufl
from ufl.core.expr import Expr

from contactfem.forms.kinematics import deformation_gradient

Energy = Callable[[Expr, Expr, Mapping[str, Expr]], Expr]
MixedEnergy = Callable[[Expr, Expr, Expr, Mapping[str, Expr]], Expr]


def internal_work(density: Expr, depth: Expr | float, unknowns: Expr, dx: ufl.Measure) -> ufl.Form:
    """Internal virtual work δ ∫ ψ dV = ∫ P : Grad δu dV with P = ∂ψ/∂F (19).

    Args:
        density: Free energy ψ of the unknowns [J/m³].
        depth: What one area of the mesh stands for [m³/m²]: 1 m, or the circumference.
        unknowns: Finite element function that is varied.
        dx: Volume measure of the reference configuration.

    Returns:
        Linear form in the test function of the unknowns' space [J].
    """
    test = ufl.TestFunction(unknowns.ufl_function_space())
    return ufl.derivative(density * depth * dx, unknowns, test)


def dead_load(load: Expr, v: Expr, measure: ufl.Measure) -> ufl.Form:
    """Virtual work of a load per reference volume or area, ∫ load · δu (19).

    Args:
        load: Body force [N/m³] or traction [N/m²], as many components as v.
        v: Virtual displacement [m].
        measure: Volume or surface measure of the reference configuration.

    Returns:
        Linear form in v [J].
    """
    return ufl.inner(load, v) * measure


def follower_pressure(
    pressure: Expr, u: Expr, v: Expr, ds: ufl.Measure, depth: Expr | float = 1.0
) -> ufl.Form:
    """Virtual work of a pressure on the current surface, ∫ -p J F⁻ᵀN · δu dA (Nanson).

    Written with the cofactors in the plane and the current depth, which hold on an axis too.

    Args:
        pressure: p [Pa], positive in compression.
        u: Displacement [m].
        v: Virtual displacement [m].
        ds: Surface measure of the reference configuration.
        depth: Current depth of a two-dimensional body [m]: 1 m, or the circumference.

    Returns:
        Linear form in v [J].
    """
    F = deformation_gradient(u)
    N = ufl.FacetNormal(ds.ufl_domain())
    dim = v.ufl_shape[0]
    area = ufl.cofac(F) * ufl.as_vector([N[i] if i < dim else 0.0 for i in range(3)])
    return -pressure * sum(area[i] * v[i] for i in range(dim)) * depth * ds


def cauchy_stress(F: Expr, theta: Expr, energy: Energy, parameters: Mapping[str, Expr]) -> Expr:
    """Cauchy stress, σ = (1/J) ∂ψ/∂F Fᵀ.

    Args:
        F: Deformation gradient [-], shape (3, 3).
        theta: Relative temperature [K].
        energy: Free energy ψ(F, ϑ, parameters) [J/m³].
        parameters: Material parameters by name [SI].

    Returns:
        σ [Pa], shape (3, 3).
    """
    F = ufl.variable(F)
    return ufl.diff(energy(F, theta, parameters), F) * F.T / ufl.det(F)


def small_strain_stress(
    F: Expr, theta: Expr, energy: Energy, parameters: Mapping[str, Expr]
) -> Expr:
    """Stress of a small-strain energy, σ = ∂ψ/∂ε.

    Args:
        F: Deformation gradient [-], shape (3, 3).
        theta: Relative temperature [K].
        energy: Free energy that depends on the symmetric part of F only [J/m³].
        parameters: Material parameters by name [SI].

    Returns:
        σ [Pa], shape (3, 3).
    """
    F = ufl.variable(F)
    return ufl.diff(energy(F, theta, parameters), F)
