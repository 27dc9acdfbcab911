"""How many examples the fuzz tests try: 50 of each, with --slow 500 or CONTACTFEM_FUZZ."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

FEW, MANY = 50, int(os.environ.get("CONTACTFEM_FUZZ", "500"))
HERE = Path(__file__).parent
ALLOWED = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    number = MANY if config.getoption("--slow") else FEW
    ours = [item for item in items if item.path.is_relative_to(HERE)]
    tests = {getattr(item, "obj", None) for item in ours}
    for test in tests:
        if hasattr(test, "hypothesis"):
            settings(max_examples=number, print_blob=True, suppress_health_check=ALLOWED)(test)
    for item in ours:
        item.add_marker(pytest.mark.timeout(600 if number == FEW else 0))
