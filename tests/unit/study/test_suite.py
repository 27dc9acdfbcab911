"""A folder of case files in one table."""

import csv
import io
from pathlib import Path

import pytest
from rich.console import Console

from contactfem.cli.main import main
from contactfem.errors import CaseError
from contactfem.study.suite import report_folder

CASE = """
title = "A block pressed on a plane"
strain = "small"
time = { end = "1 s", step = "1 s" }
materials.soft = { youngs_modulus = "1000 N/mm^2", poisson_ratio = 0.0 }
bodies.block.material = "soft"
bodies.block.mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 2, ny = 1 }
obstacles.plane = { shape = "plane", point = ["0 mm", "0 mm"], normal = [0.0, 1.0] }
interfaces.sole = { nonmortar = "block.bottom", mortar = "plane" }
conditions = [
  { on = "block.top", displacement.y = "-5 um" },
  { on = "block.left", displacement.x = "0 mm" },
]
expect."sole.force_y" = { value = "-10 N/mm", rel = 1e-6 }
"""


def table(folder: Path, out: Path) -> tuple[int, str, list[list[str]]]:
    stream = io.StringIO()
    code = report_folder(folder, out, Console(file=stream, width=200))
    with (out / f"{out.name}.csv").open(newline="") as file:
        return code, stream.getvalue(), list(csv.reader(file))


def test_cases_and_variants_have_a_row_each(tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(CASE)
    stiff = CASE + '[variants.stiff]\n"materials.soft.youngs_modulus" = "2000 N/mm^2"\n'
    stiff += '[variants.stiff.expect]\n"sole.force_y" = { value = "-20 N/mm", rel = 1e-6 }\n'
    (tmp_path / "two.toml").write_text(stiff)
    code, text, found = table(tmp_path, tmp_path / "runs" / "small")
    assert code == 0
    assert [row[0] for row in found] == ["case", "one", "two", "two-stiff"]
    assert all(row[1] == "yes" and row[-1] == "passed" for row in found[1:])
    assert all(float(row[6]) < 1e-6 for row in found[1:])
    assert text.count("passed") == 3
    markdown = (tmp_path / "runs" / "small" / "small.md").read_text()
    assert markdown.count("passed") == 3
    assert {line.count("|") for line in markdown.splitlines()} == {11}


def test_a_miss_and_a_bad_case_do_not_end_the_table(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(CASE.replace("block.top", "block.roof"))
    (tmp_path / "good.toml").write_text(CASE)
    (tmp_path / "missed.toml").write_text(CASE.replace("-10 N/mm", "-10.1 N/mm"))
    code, text, found = table(tmp_path, tmp_path / "out")
    assert code == 1
    assert [row[-1] for row in found[1:]] == ["missed", "passed", "missed"]
    assert found[1][1] == "refused"
    assert "roof" in text
    assert float(found[3][6]) == pytest.approx(0.1 / 10.1, rel=0.1)
    assert "missed: sole.force_y = -10000" in text


def test_no_solution_is_a_miss_unless_it_is_expected(tmp_path: Path) -> None:
    moved = CASE.replace("-5 um", "-5 mm").replace('strain = "small"', 'strain = "finite"')
    moved += "[solver]\nmax_cutbacks = 1\n"
    (tmp_path / "a.toml").write_text(moved)
    (tmp_path / "b.toml").write_text(
        moved.replace('"sole.force_y"', '"converged"').replace(
            'value = "-10 N/mm", rel = 1e-6', "max = 0"
        )
    )
    code, text, found = table(tmp_path, tmp_path / "out")
    assert code == 1
    assert [row[-1] for row in found[1:]] == ["missed", "passed"]
    assert found[1][1].startswith("no (at")
    assert "no equilibrium found" in text


def test_a_folder_without_cases(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="neither the folder of a run nor one of case files"):
        table(tmp_path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_command_takes_a_folder(tmp_path: Path, monkeypatch, capsys) -> None:
    folder = tmp_path / "set"
    folder.mkdir()
    (folder / "one.toml").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    assert main(["report", "set"]) == 0
    assert "passed" in capsys.readouterr().out
    assert (tmp_path / "runs" / "set" / "set.md").is_file()
