"""The page of a run: complete, well formed, self-contained, and safe to open."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from contactfem.check.check import Account
from contactfem.cli.main import main
from contactfem.output.report.html_page import page as page_of
from contactfem.output.report.html_page import write_page
from contactfem.output.report.html_steps import curve, decisions
from contactfem.output.writer import OutputWriter
from contactfem.results.data import Failure

PICTURE = b"\x89PNG\r\n\x1a\nnot really"
VOID = {"meta", "img"}
EVIL = "<script>alert('x')</script> & \"quotes\""


class Page(HTMLParser):
    """Reads a page and complains about elements that are not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data.strip())

    def values(self, name: str) -> list[str]:
        return [value for key, value in self.attributes if key == name]


@pytest.fixture
def folder(make_run, tmp_path):
    """Finish a run in a folder of its own, changed as a summary or in its case."""

    def make(account: Account = Account(), change=lambda run: run, **case) -> Path:  # noqa: B008
        output = type("Output", (), {"fields": True, "figures": False, "times": ()})
        run = change(make_run(output=output, **case))
        writer = OutputWriter(tmp_path, run.case, "contactfem run cm.toml --set 'a.b=<3>'", account)
        writer.failure(Failure(0.75, "the status cycles", 0.25))
        writer.finish(run)
        (tmp_path / "figures" / "stress_yy.png").write_bytes(PICTURE)
        return tmp_path

    return make


def read(folder: Path) -> tuple[str, Page]:
    text = write_page(folder).read_text()
    return text, Page(text)


ACCOUNT = Account((("contact", "on: 1 interface"),), (("solver.tolerance", "1e-10", True),))


def test_the_page_has_everything(folder):
    text, page = read(folder(ACCOUNT))
    assert text.startswith("<!doctype html>")
    assert page.values("id") == [
        "scene", "verdicts", "figures", "steps", "reactions", "decisions", "cost", "numbers",
        "repeat",
    ]  # fmt: skip
    assert page.tags.count("svg") == 4  # a curve for each step
    for said in (
        "on: 1 interface", "K. L. Johnson, Contact Mechanics", "4 of 4 expectations met",
        "9.351351 MPa", "9.35135 ± 0.281 MPa", "1e-10  (default)", "= floor", "133 %",
        "Step to t = 0.75 s failed: the status cycles; tried again with 0.25 s.",
        "contactfem run cm.toml --set 'a.b=<3>'",
    ):  # fmt: skip
        assert any(said in text for text in page.texts), said
    assert any(text.startswith("With contactfem 0.") for text in page.texts)


def test_nothing_is_fetched_from_elsewhere(folder):
    text, page = read(folder(ACCOUNT))
    assert [src[:22] for src in page.values("src")] == ["data:image/png;base64,"]
    assert not re.search(r"https?:|//[a-z]|url\(|@import|<link|<script", text)
    assert page.values("href") == []


def test_text_cannot_become_markup(folder):
    account = Account(((EVIL, EVIL),), ((EVIL, EVIL, False),))
    text, page = read(folder(account, title=EVIL, references=(EVIL,)))
    assert "script" not in page.tags
    assert "<script" not in text
    assert page.texts.count(EVIL) == 7  # title twice, reference, scene and value


def test_a_run_that_gave_up(folder):
    def stop(run):
        return replace(run, converged=False, message="no equilibrium <here>", steps=run.steps[:2])

    _, page = read(folder(change=stop))
    assert "not passed" in page.texts
    assert "The run stopped: no equilibrium <here>" in page.texts
    assert any("stopped early" in text for text in page.texts)


def test_a_run_that_gave_up_at_once(folder):
    _, page = read(folder(change=lambda run: replace(run, converged=False, message="no", steps=())))
    assert "steps" not in page.values("id")
    assert "The run stopped: no" in page.texts


def test_heat_has_its_balance(folder):
    path = folder() / "summary.json"
    summary = json.loads(path.read_text())
    heat = {
        "passes": 2, "change": 0.0, "temperature_min": 1.0, "temperature_max": 21.5,
        "stored": 5.0, "held": {"slab.bottom": -2.0}, "loads": 0.0, "friction": 7.0,
        "obstacles": 0.0, "strained": 0.0, "defect": 0.0, "flow": {}, "friction_defect": 0.0,
        "rings": "",
    }  # fmt: skip
    summary["steps"] = [step | {"heat": heat} for step in summary["steps"]]
    summary["steps"][3]["heat"] = heat | {"rings": "cG(1) rings"}
    path.write_text(json.dumps(summary))
    _, page = read(path.parent)
    cells = page.texts
    assert cells[cells.index("through slab.bottom") + 1] == "-8 J/m"
    assert cells[cells.index("friction") + 1] == "28 J/m"
    assert cells.count("21.5") == 4
    assert "The time scheme rings in 1 step; dG(1) would not." in cells
    assert "Step 4, t = 1 s: cG(1) rings" in cells


def test_what_later_steps_tell_is_shown(folder):
    path = folder() / "summary.json"
    summary = json.loads(path.read_text())
    summary["steps"][0] |= {
        "error": 0.0123456,
        "remeshes": [{"body": "slab", "cells": 420}, {"body": "block", "cells": 77}],
        "warning": "friction is not known",
    }
    summary["steps"][1] |= {"error": None, "remeshes": [], "warning": ""}
    path.write_text(json.dumps(summary))
    _, page = read(path.parent)
    assert "error" in page.texts
    assert "0.012346" in page.texts
    assert decisions(summary) == [
        "Step 1, t = 0.25 s, remeshes: body slab, cells 420",
        "Step 1, t = 0.25 s, remeshes: body block, cells 77",
        "Step 1, t = 0.25 s, warning: friction is not known",
        "Step to t = 0.75 s failed: the status cycles; tried again with 0.25 s.",
    ]


def test_errors_meshes_and_warnings_are_shown(folder):
    path = folder() / "summary.json"
    summary = json.loads(path.read_text())
    remesh = {"t": 0.0, "problem": "heat", "body": "pad", "cells_before": 140, "cells_after": 456}
    summary["steps"][1]["errors"] = {
        "mechanics": 0.0321, "heat": None, "time": 0.4, "cells": {"pad": 140, "rail": 200},
        "thermal_cells": {}, "remeshes": [remesh], "decisions": ["heat: an error of 45 % > 30 %"],
    }  # fmt: skip
    summary["warnings"] = ["friction is <not> known"]
    path.write_text(json.dumps(summary))
    _, page = read(path.parent)
    for said in ("error of stress", "3.21 %", "of rate", "40 %", "cells", "340"):
        assert said in page.texts, said
    assert "of heat flux" not in page.texts
    assert "thermal cells" not in page.texts
    assert "Warning: friction is <not> known" in page.texts
    assert "Step 2, t = 0.5 s: heat: an error of 45 % > 30 %" in page.texts
    assert "Step 2, t = 0.5 s: new mesh of 'pad' for heat, 140 to 456 cells" in page.texts


def test_control_characters_are_shown_by_their_codes(folder):
    title = "[/] \x00\x1b[31m{{ 7 * 7 }}\u202e\xa0end\x7f"
    text, page = read(folder(title=title))
    assert page.texts.count("[/] \\x00\\x1b[31m{{ 7 * 7 }}\\u202e\\xa0end\\x7f") == 2
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", text)


def test_a_prediction_beyond_reason_is_cut_short(folder):
    path = folder() / "summary.json"
    summary = json.loads(path.read_text())
    cost = {"problem": "heat", "eta": 0.01, "cells": 5230, "first_eta": 0.9, "first_cells": 48}
    summary["uniform"] = [
        cost | {"uniform_cells": count} for count in (35816279880713.4, 12345.6, 7.0, None)
    ]
    path.write_text(json.dumps(summary))
    text, page = read(path.parent)
    assert "uniform" in page.values("id")
    assert [t for t in page.texts if t in ("> 1e9", "12000", "7")] == [
        "> 1e9", "12000", "7", "> 1e9"
    ]  # fmt: skip
    assert "35816279880713" not in text


def test_an_old_summary_without_what_came_later_has_a_page(folder):
    path = folder() / "summary.json"
    summary = json.loads(path.read_text())
    for key in ("scene", "resolved", "failures", "references", "reactions", "uniform", "warnings"):
        del summary[key]
    text = page_of(summary, {})
    assert Page(text).values("id") == ["verdicts", "steps", "cost", "numbers", "repeat"]


def test_a_curve_is_on_a_logarithmic_scale():
    drawn = curve([1e2, 1e-2, None, 1e-9], 1e-4, 1e2, 1e-1)
    heights = [float(height) for _, height in drawn.points]
    assert heights[0] == 3.0  # at the top, inside of a margin
    assert heights[2] == heights[3] == 25.0  # at the bottom: not finite, and below it
    assert heights[1] == pytest.approx(3.0 + 22.0 * 4 / 6, abs=0.05)
    assert drawn.level == "14.0"  # in the middle
    assert drawn.text == "1.0e+02, 1.0e-02, not finite, 1.0e-09"


def test_the_command(folder, capsys, tmp_path):
    run = folder()
    assert main(["report", "--html", str(run)]) == 0
    assert capsys.readouterr().out == f"{run / 'report.html'}\n"
    assert main(["report", "--html", str(tmp_path / "figures")]) == 2
    assert "the run has not finished" in capsys.readouterr().err
