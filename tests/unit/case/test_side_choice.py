"""Which side of `between` is nonmortar, why, and what is said about mistakes."""

import pickle

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.overrides import override
from contactfem.case.schema import Case
from contactfem.check.check import check_case
from contactfem.errors import CaseError
from contactfem.run.driver import run_case


def block(nx, width="1 m", x="0 m", y="0 m", material="steel"):
    mesh = {
        "builder": "block", "width": width, "height": "1 m", "corner": [x, y], "nx": nx, "ny": 2,
    }  # fmt: skip
    return {"material": material, "mesh": mesh}


def contents(pad, slab, between=("pad.bottom", "slab.top"), **others):
    """A pad above a slab, whose bottom is held."""
    return {
        "title": "Pad on a slab",
        "strain": "small",
        "time": {"end": "1 s", "step": "1 s"},
        "materials": {
            "steel": {"youngs_modulus": "200 MPa", "poisson_ratio": 0.3},
            "rubber": {"youngs_modulus": "2 MPa", "poisson_ratio": 0.3},
        },
        "bodies": {"pad": pad, "slab": slab},
        "interfaces": {"foot": {"between": list(between)}},
        "conditions": [
            {"on": "slab.bottom", "displacement": {"x": "0 m", "y": "0 m"}},
            {"on": "pad.top", "displacement": {"x": "0 m", "y": "-1 mm"}},
        ],
        **others,
    }


def foot(raw):
    sides = Case.from_dict(raw).interfaces["foot"]
    return sides.nonmortar, sides.mortar, sides.why


CHOICES = {
    "overhang": (
        block(8, width="1 m", x="0.5 m", y="1 m"), block(4, width="2 m"), "pad.bottom",
        "slab.top extends beyond its ends",
    ),
    "overhang at one end": (
        block(4, x="0.13 m", y="1 m", width="2 m"), block(4, width="2.13 m"), "pad.bottom",
        "slab.top extends beyond its ends",
    ),
    "overhang over a gap": (
        block(8, x="0.5 m", y="1.3 m"), block(4, width="2 m"), "pad.bottom",
        "slab.top extends beyond its ends",
    ),
    "coarser than softer": (
        block(2, y="1 m"), block(4, material="rubber"), "pad.bottom",
        "its facets are 2 times as large",
    ),
    "softer than little coarser": (
        block(3, y="1 m"), block(4, material="rubber"), "slab.top",
        "its material is 100 times as soft",
    ),
    "little coarser": (
        block(4, y="1 m"), block(3), "slab.top", "its facets are 1.33 times as large",
    ),
    "alike": (
        block(3, y="1 m"), block(3), "pad.bottom", "both sides are alike; it is the first by name",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHOICES)
@pytest.mark.parametrize("order", [1, -1])
def test_one_side_is_chosen_in_either_order(name, order):
    pad, slab, nonmortar, why = CHOICES[name]
    found = foot(contents(pad, slab, ("pad.bottom", "slab.top")[::order]))
    assert found[0] == nonmortar
    assert set(found[:2]) == {"pad.bottom", "slab.top"}
    assert found[2] == why


@pytest.mark.parametrize("order", [1, -1])
def test_sides_in_space(order):
    def cube(n, size, corner, material="steel"):
        mesh = {
            "builder": "box", "width": size, "height": size, "depth": "1 m", "corner": corner,
            "nx": n, "ny": n, "nz": 1,
        }  # fmt: skip
        return {"material": material, "mesh": mesh}

    def sides(pad, slab):
        raw = contents(pad, slab, ("pad.back", "slab.front")[::order], dimension="3d")
        raw["conditions"] = [
            {"on": "slab.back", "displacement": ["0 m", "0 m", "0 m"]},
            {"on": "pad.front", "displacement": ["0 m", "0 m", "-1 mm"]},
        ]
        return foot(raw)

    low, high = ["0 m", "0 m", "0 m"], ["0 m", "0 m", "1 m"]
    inside = ["0.5 m", "0.5 m", "1 m"]
    over = sides(cube(6, "1 m", inside), cube(3, "2 m", low))
    assert over == ("pad.back", "slab.front", "slab.front extends beyond its ends")
    coarse = sides(cube(6, "1 m", high), cube(3, "1 m", low))
    assert coarse == ("slab.front", "pad.back", "its facets are 2 times as large")
    soft = sides(cube(4, "1 m", high, "rubber"), cube(3, "1 m", low))
    assert soft == ("pad.back", "slab.front", "its material is 100 times as soft")


def test_an_obstacle_is_mortar():
    floor = {"floor": {"shape": "plane", "point": ["0 m", "0 m"], "normal": [0.0, 1.0]}}
    for between in (["floor", "slab.bottom"], ["slab.bottom", "floor"]):
        raw = contents(block(3, y="1 m"), block(3), obstacles=floor)
        raw["conditions"] = raw["conditions"][1:]
        raw["interfaces"]["under"] = {"between": between}
        under = Case.from_dict(raw).interfaces["under"]
        assert (under.nonmortar, under.mortar) == ("slab.bottom", "floor")
        assert under.why == "an obstacle is always the mortar side"


def test_a_surface_is_nonmortar_once():
    raw = contents(block(2, y="1 m"), block(4))
    raw["bodies"]["post"] = block(4, x="3 m")
    raw["interfaces"]["side"] = {"nonmortar": "pad.bottom", "mortar": "post.top"}
    assert foot(raw) == (
        "slab.top", "pad.bottom", "pad.bottom is the nonmortar side of 'side' already"
    )  # fmt: skip
    raw["interfaces"]["other"] = {"nonmortar": "slab.top", "mortar": "post.left"}
    with pytest.raises(CaseError, match=r"interfaces\.foot\.between: pad\.bottom is the nonmortar"):
        Case.from_dict(raw)


def test_a_side_whose_motion_is_prescribed_is_mortar():
    raw = contents(block(2, y="1 m"), block(4))
    raw["conditions"][1]["on"] = "pad.bottom"
    assert foot(raw) == ("slab.top", "pad.bottom", "the motion of pad.bottom is prescribed")


MISTAKES = [
    ({"between": ["pad.bottom", "slab.top"], "mortar": "slab.top"},
     "interfaces.foot: give either between, or nonmortar and mortar; found mortar too"),
    ({}, "interfaces.foot: nonmortar and mortar: missing; give nonmortar and mortar, or the two "),
    ({"nonmortar": "pad.bottom"}, "interfaces.foot: mortar: missing; give nonmortar and mortar, "),
    ({"between": ["pad.botom", "slab.top"]}, "interfaces.foot.between.0 = pad.botom: 'pad' has no "
     "surface 'botom'; did you mean 'bottom'?"),
    ({"between": ["pad.bottom", "slap.top"]}, "interfaces.foot.between.1 = slap.top: there is no "
     "body 'slap'; did you mean 'slab'?"),
    ({"between": ["pad.bottom", "flor"]}, "interfaces.foot.between.1 = flor: there is no obstacle "
     "'flor'; did you mean 'floor'?"),
    ({"between": ["pad.bottom", "slab"]}, "interfaces.foot.between.1 = slab: must be "
     "'body.surface'"),
    ({"between": ["pad.bottom", "pad.bottom"]}, "interfaces.foot.between.1 = pad.bottom: is the "
     "first side too; give another surface"),
    ({"between": ["floor", "wall"]}, "interfaces.foot.between: both sides are obstacles; one "),
    ({"between": ["pad.bottom"]}, "interfaces.foot.between.1: is missing"),
    ({"between": ["pad.bottom", "slab.top"], "heat": {"partition": 0.2}}, "interfaces.foot.heat."
     "partition = 0.2: is the share of the nonmortar side; give nonmortar and mortar in place"),
]  # fmt: skip


@pytest.mark.parametrize(("interface", "line"), MISTAKES)
def test_a_mistake_gives_one_line(interface, line):
    plane = {"shape": "plane", "point": ["0 m", "-1 m"], "normal": [0.0, 1.0]}
    raw = contents(block(2, y="1 m"), block(4), obstacles={"floor": plane, "wall": plane})
    raw["interfaces"]["foot"] = interface
    with pytest.raises(CaseError) as caught:
        Case.from_dict(raw)
    lines = str(caught.value).splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(f"case.toml: {line}")


def test_changed_values_say_sides_in_another_way():
    raw = contents(block(2, y="1 m"), block(4))
    mortar = override(raw, 'interfaces.foot.mortar="pad.bottom"')
    assert mortar["interfaces"]["foot"] == {"mortar": "pad.bottom", "nonmortar": "slab.top"}
    assert foot(mortar) == ("slab.top", "pad.bottom", "")
    back = override(mortar, 'interfaces.foot.between=["slab.top", "pad.bottom"]')
    assert back["interfaces"]["foot"] == {"between": ["slab.top", "pad.bottom"]}
    assert foot(back)[0] == "pad.bottom"
    other = override(raw, 'interfaces.foot.nonmortar="pad.left"')
    assert other["interfaces"]["foot"] == {"nonmortar": "pad.left"}


def test_the_choice_is_said():
    case = Case.from_dict(contents(block(2, y="1 m"), block(4)))
    lines = [line.split() for line in check_case(case).splitlines()]
    said = "sides foot: pad.bottom is nonmortar, since its facets are 2 times as large"
    assert said.split() in lines
    assert ["interfaces.foot.nonmortar", "pad.bottom", "*"] in lines
    assert ["interfaces.foot.mortar", "slab.top", "*"] in lines
    assert pickle.loads(pickle.dumps(case)).interfaces["foot"].why == case.interfaces["foot"].why


@pytest.mark.mpi
def test_both_orders_give_one_answer():
    """A pad drawn with friction over a wider slab, with sides in both orders and said."""
    pad, slab = block(5, x="0.5 m", y="1 m", material="rubber"), block(6, width="2 m")
    pressures = []
    for order in (1, -1, 0):
        raw = contents(pad, slab, ("pad.bottom", "slab.top")[:: order or 1])
        raw["conditions"][1]["displacement"]["x"] = "0.3 mm"
        if not order:
            raw["interfaces"]["foot"] = {"nonmortar": "pad.bottom", "mortar": "slab.top"}
        raw["interfaces"]["foot"]["friction"] = {"law": "coulomb", "coefficient": 0.4}
        result = run_case(Case.from_dict(raw), MPI.COMM_WORLD, None)
        pressures.append(result.interfaces[0].pressure)
    assert pressures[0].max() > 1e3
    for found in pressures[1:]:
        assert np.allclose(found, pressures[0], rtol=1e-12, atol=1e-12 * pressures[0].max())


@pytest.mark.mpi
def test_a_run_warns_of_a_stiff_and_fine_nonmortar_side():
    """Not of one that is stiff alone, fine alone, or chosen; `check` says the same."""
    soft, said = "rubber", {}
    for name, n, material in (("both", 8, soft), ("stiff", 4, soft), ("fine", 8, "steel")):
        raw = contents(block(n, y="1 m"), block(4, material=material))
        raw["interfaces"]["foot"] = {"nonmortar": "pad.bottom", "mortar": "slab.top"}
        case = Case.from_dict(raw)
        said[name] = run_case(case, MPI.COMM_WORLD, None).warnings
        assert all(f"WARNING: {text.partition(': ')[2]}" in check_case(case) for text in said[name])
    assert said == {
        "both": (
            "interfaces.foot: pad.bottom is 100 times as stiff as slab.top, whose facets are 2 "
            "times as large: pressures will be too high; better with slab.top as nonmortar",
        ),
        "stiff": (),
        "fine": (),
    }
