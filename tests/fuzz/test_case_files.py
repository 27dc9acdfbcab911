"""Broken and odd case files give clear lines, never a traceback, a hang or a wrong exit code."""

from pathlib import Path

from fuzz.examining import check
from fuzz.mutations import texts
from hypothesis import given

ROOT = Path(__file__).resolve().parents[2]
CASES = (*sorted((ROOT / "cases").rglob("*.toml")), *sorted((ROOT / "tests/data").glob("*.toml")))


@given(data=texts(CASES))
def test_any_case_file_is_read_or_refused(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(data)
    check(path)
