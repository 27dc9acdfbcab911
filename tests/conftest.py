"""What all tests share: slow ones run when they are asked for; two surfaces on each other."""

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

# The same examples in every run of CI, and no verdict that depends on how busy the machine is.
settings.register_profile("default", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "default")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the tests marked slow as well")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--slow"):
        return
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="slow: run with --slow"))


@pytest.fixture
def chains() -> Callable[..., Any]:
    """Make a wavy surface under another one of other facets: the interface and its moved nodes.

    The nonmortar body lies below and the walk runs from x = 1 to 0; the mortar one covers `span`.
    `held` names components (node, axis) that contact cannot move.
    """
    from contactfem.mortar.interface_mesh import InterfaceMesh

    def make(
        nonmortar: int = 7,
        mortar: int = 9,
        seed: int = 0,
        span: tuple[float, float] = (-0.05, 0.93),
        wave: float = 0.03,
        noise: float = 0.004,
        held: tuple[tuple[int, int], ...] = (),
    ) -> tuple[InterfaceMesh, np.ndarray]:
        rng = np.random.default_rng(seed)
        x = np.linspace(1, 0, nonmortar + 1)
        x[1:-1] += rng.uniform(-0.2, 0.2, nonmortar - 1) / nonmortar
        lower = np.column_stack((x, wave * np.sin(4 * x)))
        x = np.linspace(*span, mortar + 1)
        upper = np.column_stack((x, 0.02 + wave * np.sin(4 * x) + 1.5 * wave * x**2))
        X = np.vstack((lower, upper))
        first, second = np.arange(nonmortar), nonmortar + 1 + np.arange(mortar)
        free = np.ones(X.shape, bool)
        for node, axis in held:
            free[node, axis] = False
        facets = [np.column_stack((start, start + 1)) for start in (first, second)]
        mesh = InterfaceMesh(nonmortar + 1, *facets, X, free)
        return mesh, X + noise * rng.normal(size=X.shape)

    return make
