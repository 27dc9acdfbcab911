"""Galerkin schemes in time (22)-(27) as tables of weights.

A step from t_n to t_n + dt has the coordinate α in (0, 1). Its unknowns are the stages θ_J, the
values of θ at the nodes α_J; the last node is the end of the step. A scheme knows nothing of θ, M
or H: who solves the equations puts their sums together from the weights.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from contactfem.common.typing import Floats


@dataclass(frozen=True, eq=False)
class TimeScheme:
    """Weights of one scheme.

    Equation I of a step, one for every stage, is

        M (Σ_J rate_IJ θ_J + rate_start_I θ_n)
          + dt Σ_g test_Ig H(t_n + α_g dt, trial_start_g θ_n + Σ_J trial_gJ θ_J) = 0.

    The test functions of (26) are combined such that equation I is M (θ_I - θ_n) + dt Σ_g ... = 0.
    That of the last stage has the test function 1, so it is the balance of heat over the step, and
    test[-1] are the weights with which a power at the points α_g becomes energy over dt.

    Attributes:
        name: as a case file gives it.
        order: of the error at the ends of steps; 0 without storage, where time makes no error.
        l_stable: what is infinitely fast is gone after one step, instead of alternating for ever.
        steady: without storage, H = 0 at the end of the step.
        nodes: α_J (s,) in (0, 1]; where θ is prescribed, θ_J is its value at t_n + α_J dt.
        points: α_g (q,) in (0, 1], at which H is evaluated.
        rate: (s, s).
        rate_start: (s,).
        trial: (q, s).
        trial_start: (q,).
        test: (s, q), weight of the quadrature times test function I at α_g.
        end: (s,), weights that give θ at the end of the step.
    """

    name: str
    order: int
    l_stable: bool
    steady: bool
    nodes: Floats
    points: Floats
    rate: Floats
    rate_start: Floats
    trial: Floats
    trial_start: Floats
    test: Floats
    end: Floats

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def values(self, alpha: ArrayLike) -> tuple[Floats, Floats]:
        """Weights of θ inside the step, on the polynomial through θ_n and all stages.

        It is the trial function of cG; for dG it is continuous and one degree higher than that.

        Args:
            alpha: α (m,) in [0, 1].

        Returns:
            Weights of θ_n (m,) and of the stages (m, s).
        """
        weights = _lagrange(np.insert(self.nodes, 0, 0.0), np.atleast_1d(alpha))
        return weights[:, 0], weights[:, 1:]

    def slopes(self, alpha: ArrayLike) -> tuple[Floats, Floats]:
        """Weights of dt dθ/dt inside the step, on the polynomial of `values`.

        Args:
            alpha: α (m,) in [0, 1].

        Returns:
            Weights of θ_n (m,) and of the stages (m, s).
        """
        weights = _lagrange(np.insert(self.nodes, 0, 0.0), np.atleast_1d(alpha), derivative=1)
        return weights[:, 0], weights[:, 1:]


def _lagrange(nodes: Floats, alpha: Floats, derivative: int = 0) -> Floats:
    """Return the Lagrange polynomials of some nodes, or a derivative of them, at α (m, nodes)."""
    coefficients = np.linalg.inv(legendre.legvander(2.0 * nodes - 1.0, len(nodes) - 1))
    columns = legendre.legder(coefficients, derivative, scl=2.0) if derivative else coefficients
    found: Floats = legendre.legval(2.0 * np.asarray(alpha, float) - 1.0, columns).T
    return found


def _solved(matrix: NDArray[np.floating[Any]], right: Floats) -> Floats:
    """Return the solution of a linear system, whose type numpy does not tell."""
    return np.asarray(np.linalg.solve(matrix, right), np.float64)


def _gauss(count: int) -> tuple[Floats, Floats]:
    """Return the points and weights of Gauss' rule on (0, 1), exact to degree 2 count - 1."""
    points, weights = legendre.leggauss(count)
    return 0.5 * (points + 1.0), 0.5 * weights


def _radau(count: int) -> tuple[Floats, Floats]:
    """Return the points and weights of Radau's rule on (0, 1], exact to degree 2 count - 2."""
    # real, whatever type this numpy gives to eigenvalues
    points = np.sort(np.real(legendre.legroots([*[0.0] * (count - 1), -1.0, 1.0])))
    points[-1] = 1.0
    moments = np.eye(count)[0]  # ∫ of the Legendre polynomials over (0, 1)
    return 0.5 * (points + 1.0), _solved(legendre.legvander(points, count - 1).T, moments)


def _continuous(k: int) -> TimeScheme:
    """Return cG(k): trial functions of degree k, continuous, tests of degree k - 1."""
    points, weights = _gauss(k + 1)
    nodes = np.linspace(0.0, 1.0, k + 1, dtype=np.float64)
    tests = weights * legendre.legvander(2.0 * points - 1.0, k - 1).T
    storage = tests @ _lagrange(nodes, points, derivative=1)
    trial = _lagrange(nodes, points)
    return TimeScheme(
        name=f"cG({k})",
        order=2 * k,
        l_stable=False,
        steady=False,
        nodes=nodes[1:],
        points=points,
        rate=np.eye(k),
        rate_start=-np.ones(k),
        trial=trial[:, 1:],
        trial_start=trial[:, 0],
        test=_solved(storage[:, 1:], tests),
        end=np.eye(k)[-1],
    )


def _discontinuous(k: int) -> TimeScheme:
    """Return dG(k): trial and test functions of degree k, with a jump at the start of the step.

    With Radau's k + 1 points, which are also the nodes: dG(0) is the backward Euler method, with
    its source at the end of the step. With Gauss' points the order would be the same, but a load
    that jumps within a step would be extrapolated to the end.
    """
    points, weights = _radau(k + 1)
    tests = weights * legendre.legvander(2.0 * points - 1.0, k).T
    start = legendre.legvander(np.array([-1.0]), k).T
    jump = start * _lagrange(points, np.zeros(1))
    storage = tests @ _lagrange(points, points, derivative=1) + jump
    return TimeScheme(
        name=f"dG({k})",
        order=2 * k + 1,
        l_stable=True,
        steady=False,
        nodes=points,
        points=points,
        rate=np.eye(k + 1),
        rate_start=-np.ones(k + 1),
        trial=np.eye(k + 1),
        trial_start=np.zeros(k + 1),
        test=_solved(storage, tests),
        end=np.eye(k + 1)[-1],
    )


def _steady() -> TimeScheme:
    """Return the scheme without storage: H(t_n + dt, θ) = 0."""
    one = np.ones(1)
    return TimeScheme(
        name="steady",
        order=0,
        l_stable=True,
        steady=True,
        nodes=one.copy(),
        points=one.copy(),
        rate=np.zeros((1, 1)),
        rate_start=np.zeros(1),
        trial=np.eye(1),
        trial_start=np.zeros(1),
        test=np.eye(1),
        end=one.copy(),
    )


_BUILDERS: Mapping[str, Callable[[], TimeScheme]] = {
    **{f"cG({k})": partial(_continuous, k) for k in range(1, 5)},
    **{f"dG({k})": partial(_discontinuous, k) for k in range(4)},
    "steady": _steady,
}
NAMES = tuple(_BUILDERS)


@cache
def scheme(name: str) -> TimeScheme:
    """Scheme of a name: cG(k), Gauss' k + 1 points; dG(k), Radau's k + 1 points; or steady.

    cG(1) is equation (27). What is much faster than a step cG only turns round (k odd) or leaves
    as it is (k even), while dG damps it to nothing.

    Args:
        name: one of `NAMES`.

    Returns:
        The scheme.

    Raises:
        ValueError: if there is no such scheme.
    """
    if name not in _BUILDERS:
        raise ValueError(f"no scheme {name!r}; there are {', '.join(NAMES)}")
    return _BUILDERS[name]()
