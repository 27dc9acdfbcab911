"""Observed orders of convergence: how an error falls from run to run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def relative_distance(value: float, reference: float) -> float:
    """Distance |v - r| / |r|; |v - r| where the reference is zero."""
    return abs(value - reference) / (abs(reference) or 1.0)


def observed_orders(factors: Sequence[float], errors: Sequence[float]) -> list[float]:
    """Order between each run and the last one before it whose error is known.

    p = log(e_before / e) / log(f / f_before).

    Args:
        factors: how fine each run is, ascending (n,) [-].
        errors: their errors (n,); NaN if not known.

    Returns:
        The orders (n,) [-]; NaN where there is nothing before, or an error is zero or not known.
    """
    orders, before = [], (math.nan, math.nan)
    for factor, error in zip(factors, errors, strict=True):
        known = error > 0.0  # not so for NaN
        orders.append(
            math.log(before[1] / error) / math.log(factor / before[0])
            if known and before[1] > 0.0
            else math.nan
        )
        before = (factor, error) if known else before
    return orders


def slope(costs: Sequence[float], errors: Sequence[float]) -> float:
    """Exponent s of error ~ cost^s through all runs, by least squares of the logarithms.

    Args:
        costs: seconds or unknowns of each run (n,).
        errors: their errors (n,); runs without a positive one are left out.

    Returns:
        The exponent [-]; NaN where all costs are the same or fewer than two runs are left.
    """
    pairs = [(c, e) for c, e in zip(costs, errors, strict=True) if c > 0.0 and e > 0.0]
    x, y = np.log(np.array(pairs).reshape(-1, 2)).T
    if len(np.unique(x)) < 2:
        return math.nan
    x = x - x.mean()
    return float(x @ y / (x @ x))
