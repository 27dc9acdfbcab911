"""Verdicts of runs as a JUnit file, which CI servers read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from contactfem.common.files import write_whole
from contactfem.output.report.report import verdict_rows
from contactfem.output.tables import read_summary


def write_junit(path: Path, folders: Sequence[Path]) -> bool:
    """Write the file: a suite for each run, a test for each number that it expects.

    Args:
        path: the file.
        folders: folders of finished runs.

    Returns:
        Whether all runs came to their end and met what was expected of them.

    Raises:
        CaseError: one of them is not a finished run.
        OSError: the file cannot be written.
    """
    summaries = [(folder, read_summary(folder)) for folder in folders]
    root = ET.Element("testsuites", name="contactfem")
    for folder, summary in summaries:
        root.append(_suite(folder, summary))
    ET.indent(root)
    write_whole(path, ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n")
    return all(summary["passed"] for _, summary in summaries)


def _suite(folder: Path, summary: dict[str, Any]) -> ET.Element:
    """One run: whether it ended as expected, then its numbers."""
    suite = ET.Element("testsuite", name=str(folder))
    seconds = float(summary.get("timings", {}).get("total") or 0.0)
    ended = _case(suite, folder, "ended", seconds)
    rows = verdict_rows(summary)
    failures = 0
    if not summary["passed"] and all(met for *_, met in rows):
        failures += 1
        ET.SubElement(ended, "failure", message=summary.get("message") or "did not end as expected")
    for key, found, allowed, met in rows:
        test = _case(suite, folder, key, 0.0)
        if not met:
            failures += 1
            ET.SubElement(test, "failure", message=f"{key} = {found}, allowed: {allowed}")
    suite.set("tests", str(1 + len(rows)))
    suite.set("failures", str(failures))
    suite.set("time", f"{seconds:.3f}")
    return suite


def _case(suite: ET.Element, folder: Path, name: str, seconds: float) -> ET.Element:
    """A test of a suite."""
    return ET.SubElement(suite, "testcase", classname=folder.name, name=name, time=f"{seconds:.3f}")
