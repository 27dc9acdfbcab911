"""Case files of others: the Python that they run is said, and what they print stays a text."""

import json
from pathlib import Path

import pytest

from contactfem.cli.main import main
from contactfem.errors import ExitCode

CASE = """
title = "TITLE"
strain = "small"
time = { end = "1 s", step = "1 s" }
output = { figures = false, fields = false }
materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.0, model = "MODEL" }
[bodies.b]
material = "m"
mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 2, ny = 2 }
[[conditions]]
on = "b.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "b.top"
displacement = ["0 mm", "-0.01 mm"]
"""


def write(folder: Path, title: str = "A block", model: str = "neo-hooke") -> Path:
    path = folder / "case.toml"
    path.write_text(CASE.replace("TITLE", title).replace("MODEL", model))
    return path


@pytest.mark.parametrize("title", ["[/]", "[bold", "[red]a[/red]", "a\\u001b[31mb\\u0007"])
def test_titles_are_texts_for_a_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], title: str
) -> None:
    """Brackets are no markup, and characters that steer a terminal do not reach it."""
    path, out = write(tmp_path, title), tmp_path / "[red]out"
    for words in (["check", path], ["run", path, "--out", out], ["report", out]):
        assert main([str(word) for word in words]) == ExitCode.DONE
        said = capsys.readouterr().out
        shown = title.replace("\\u001b", "\\x1b").replace("\\u0007", "\\x07")
        assert shown in said
        assert "\x1b" not in said and "\x07" not in said


def test_a_forged_summary(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["run", str(write(tmp_path)), "--out", str(out)]) == ExitCode.DONE
    summary = json.loads((out / "summary.json").read_text())
    summary |= {"command": "\x1b]0;x\x07", "warnings": ["[/]\x1b[2J"], "title": "[/\x1b"}
    (out / "summary.json").write_text(json.dumps(summary))
    capsys.readouterr()
    assert main(["report", str(out)]) == ExitCode.DONE
    said = capsys.readouterr().out
    assert "\x1b" not in said and "\x07" not in said
    assert "WARNING: [/]\\x1b[2J" in said


CODE = """
from pathlib import Path
from contactfem.forms.energies import linear_elastic
Path(__file__).with_name("ran").touch()
def energy(F, theta, parameters):
    return linear_elastic(F, theta, parameters)
"""


def test_python_of_a_case_is_said_and_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A check runs none of it, a run that refuses it neither."""
    (tmp_path / "mine.py").write_text(CODE)
    path, ran = write(tmp_path, model="mine.py:energy"), tmp_path / "ran"
    assert main(["check", str(path)]) == ExitCode.DONE
    assert "runs code: mine.py:energy (materials.m.model)" in capsys.readouterr().out
    for command in (["check"], ["run", "--out", str(tmp_path / "out")]):
        assert main([*command, "--no-code", str(path)]) == ExitCode.BAD_CASE
        assert capsys.readouterr().err == (
            f"{path}: materials.m.model = mine.py:energy: runs Python; --no-code refuses it\n"
        )
    assert not ran.exists()
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == ExitCode.DONE
    assert ran.exists()
    assert main(["run", "--no-code", str(write(tmp_path)), "--out", str(tmp_path / "o")]) == 0
