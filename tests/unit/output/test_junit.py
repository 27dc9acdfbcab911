"""Verdicts of runs as JUnit XML."""

import json
from xml.etree import ElementTree as ET

from contactfem.cli.main import main


def run(folder, passed, *verdicts, message=""):
    folder.mkdir()
    keys = ("key", "value", "low", "high", "unit", "passed")
    summary = {
        "title": "A run", "steps": [], "passed": passed, "message": message,
        "timings": {"total": 1.25}, "verdicts": [dict(zip(keys, v, strict=True)) for v in verdicts],
    }  # fmt: skip
    (folder / "summary.json").write_text(json.dumps(summary))
    return str(folder)


def test_a_suite_for_each_run(tmp_path, capsys):
    good = run(tmp_path / "good", True, ("sole.force_y", -2e3, -2.1e3, -1.9e3, "N/m", True))
    missed = ("tip <x> & y", 1e-3, None, 5e-4, "m", False)
    bad = run(tmp_path / "bad", False, missed, ("iterations.max", 4.0, None, 9.0, "", True))
    stuck = run(tmp_path / "stuck", False, message="no equilibrium found")
    path = tmp_path / "verdicts.xml"
    assert main(["report", "--junit", str(path), good, bad, stuck]) == 1
    assert capsys.readouterr().out == f"{path}\n"
    suites = ET.parse(path).getroot().findall("testsuite")
    counts = [(suite.get("tests"), suite.get("failures")) for suite in suites]
    assert counts == [("2", "0"), ("3", "1"), ("1", "1")]
    failures = [node.get("message") for node in ET.parse(path).iter("failure")]
    assert failures == ["tip <x> & y = 1 mm, allowed: <= 0.5 mm", "no equilibrium found"]
    assert suites[0].get("time") == "1.250"


def test_all_met_is_exit_code_0_and_a_full_disk_is_told(tmp_path, capsys):
    good = run(tmp_path / "good", True)
    assert main(["report", "--junit", str(tmp_path / "v.xml"), good]) == 0
    assert main(["report", "--junit", str(tmp_path / "none" / "v.xml"), good]) == 2
    assert "v.xml: cannot be written" in capsys.readouterr().err
