"""One version number everywhere."""

from pathlib import Path

import contactfem


def test_the_citation_names_this_version() -> None:
    citation = (Path(__file__).parents[2] / "CITATION.cff").read_text().splitlines()
    assert f"version: {contactfem.__version__}" in citation
