"""Run the project's cases, changed where a test needs it, and compare what comes out."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[2] / "cases"


@pytest.fixture(scope="session")
def solved() -> Callable[..., RunResult]:
    """Run a case of the project: its name, overrides "a.b=c", and perhaps a variant."""

    def run(
        stem: str, *overrides: str, variant: str | None = None, comm: MPI.Comm = MPI.COMM_SELF
    ) -> RunResult:
        case = read_case(CASES / f"{stem}.toml", overrides, variant)
        result = run_case(case, comm, None)
        assert result.converged, result.message
        return result

    return run


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., RunResult]:
    """Run the text of a case, with overrides "a.b=c"."""

    def run(text: str, *overrides: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
        path = tmp_path / "case.toml"
        path.write_text(text)
        result = run_case(read_case(path, overrides), comm, None)
        assert result.converged, result.message
        return result

    return run


@pytest.fixture(scope="session")
def same() -> Callable[..., None]:
    """Assert that two runs agree along all interfaces to `rel` of the largest value."""

    def compare(first: RunResult, second: RunResult, rel: float = 1e-9) -> None:
        assert len(first.interfaces) == len(second.interfaces) > 0
        for a, b in zip(first.interfaces, second.interfaces, strict=True):
            assert np.array_equal(a.status, b.status)
            assert np.ptp(a.x) > 0
            moved = a.x - a.X
            scales = {"pressure": a.pressure, "traction": a.pressure, "x": moved, "slip": moved}
            for name, scale in scales.items():
                atol = rel * np.abs(scale).max()
                found, expected = getattr(b, name), getattr(a, name)
                np.testing.assert_allclose(found, expected, rtol=0, atol=atol, err_msg=name)
            forces = [np.array(r.steps[-1].forces[a.name]) for r in (first, second)]
            assert np.abs(forces[0] - forces[1]).max() < rel * np.linalg.norm(forces[0])

    return compare
