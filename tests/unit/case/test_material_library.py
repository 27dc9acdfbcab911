"""Materials that a case names without giving their numbers."""

import copy
import tomllib
from pathlib import Path

import pytest

from contactfem.case.material_library import LIBRARY
from contactfem.case.read import case_of
from contactfem.errors import CaseError

RAW = tomllib.loads((Path(__file__).parents[3] / "tests/data/two_blocks.toml").read_text())


def case_with(**changes):
    raw = copy.deepcopy(RAW)
    raw["bodies"]["lower"] |= changes
    return raw


@pytest.mark.parametrize("name", LIBRARY)
def test_every_material_is_complete_and_plausible(name):
    raw = case_with(material=name) | {"materials": {}}
    raw["bodies"]["upper"]["material"] = name
    found = case_of(raw, Path("case.toml")).materials[name]
    assert 0.28 < found.nu < 0.5
    assert 1e-6 < found.expansion < 1e-3
    diffusivity = found.conductivity / (found.density * found.heat_capacity)
    assert 5e-8 < diffusivity < 2e-4  # [m²/s], from rubber to copper
    speed = (found.E / found.density) ** 0.5  # of waves in a rod [m/s]
    assert 20 < speed < 6000
    assert LIBRARY[name].source and LIBRARY[name].validity


def test_what_the_file_gives_counts():
    raw = case_with(material="steel")
    raw["materials"]["steel"] = {"youngs_modulus": "200 GPa", "poisson_ratio": 0.25}
    assert case_of(raw, Path("case.toml")).materials["steel"].E == 200e9


def test_only_what_is_named_is_added():
    assert set(case_of(case_with(material="copper"), Path("case.toml")).materials) == {
        "rubber", "steel", "copper",
    }  # fmt: skip


def test_a_case_may_give_no_materials_at_all():
    raw = case_with(material="steel")
    del raw["materials"]
    raw["bodies"]["upper"]["material"] = "aluminium"
    assert set(case_of(raw, Path("case.toml")).materials) == {"steel", "aluminium"}


def test_a_slip_of_the_pen_is_told_with_what_was_meant():
    with pytest.raises(CaseError, match="no material 'alumnium'; did you mean 'aluminium'"):
        case_of(case_with(material="alumnium"), Path("case.toml"))
