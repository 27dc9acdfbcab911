"""Broken and odd case files: what people, editors and scripts do to files that were right."""

import copy
import datetime
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from fuzz.toml_text import dumps

Raw = dict[str, Any]
Draw = Callable[[st.SearchStrategy[Any]], Any]
Place = tuple[Any, str | int]  # a table or list, and a key or index in it

ODD_TEXTS = (
    "", " ", "x", "é", "\u2028", "\x1b[31m", "\x00", "a\nb", "a.b", "..", "upper.", ".top", "ϑ" * 300,
    "\ud7ff", "🙂", "%s {0} {x}", "../../x.py:f", "energies.py:no", "conftest.py:x", "3d", "axisymmetric",
    "small", "saddle", "standard", "penalty", "augmented", "tresca", "gas", "steady", "dG(0)", "cG(4)",
    "P1", "MINI", "plane", "circle", "polyline", "neo-hooke", "temperature", "stress.xy",
)  # fmt: skip
ODD_QUANTITIES = (
    "0 m", "-0 m", "1e-320 m", "1e308 m", "1e400 m", "nan m", "inf m", "-1 mm", "1 m^2", "1", "1 ", "mm",
    "1 mm mm", "1 N/mm^2", "1e300 GPa", "1e-300 Pa", "1 furlong", "20 degC", "1 %", "1 m/", "1 (m", "1 m^x",
    "1 m^1e9", "１ m", "1,5 m", "0x10 m", "1e5 s", "1e-9 s", "5 K", "1 W/m/K", "1 kg/m^3", "1 J/kg/K",
    "1 W/m^2/K", "1 N/m^3", "1 N/m", "1 N", "1 1/K", "10 mm", "0.5 s",
)  # fmt: skip
ODD_NUMBERS = (
    0, 1, -1, 2, 3, 10, 10**5, 10**6, 10**30, -(10**18), 0.0, -0.0, 0.5, 1e-320, 1e-12, 1e300,
    float("nan"), float("inf"), float("-inf"), True, False,
)  # fmt: skip
ODD_OTHERS = (
    [], {}, [[]], [{}], {"": 1}, [1, 2, 3], ["1 m"], ["0 m", "0 m"], ["0 m", "0 m", "0 m"],
    [["0 s", "0 m"], ["1 s", "1 m"]], [["1 s", "0 m"], ["0 s", "1 m"]], [["0 s", "0 Pa"], ["1 s", "-1 MPa"]],
    {"x": "0 m"}, {"y": "1 mm", "z": "1 mm"}, {"builder": "block"}, {"file": "."}, {"file": 3},
    {"file": "case.toml", "unit": "mm"}, {"file": "mesh.msh", "unit": "mm"}, {"shape": "circle"},
    datetime.date(1979, 5, 27), datetime.time(7, 32), datetime.datetime(1979, 5, 27, 7, 32),
)  # fmt: skip
SNIPPETS: tuple[tuple[str, Any], ...] = (
    ("heat", {}), ("heat", {"scheme": "steady"}), ("heat", {"scheme": "dG(1)", "max_passes": 3}),
    ("heat", {"thermoelastic": True}), ("heat", {"relaxation": 0.5, "tolerance": 1e-300}),
    ("heat", False), ("adaptivity", False), ("adaptivity", {}), ("adaptivity", {"tolerance": "5 %"}),
    ("adaptivity", {"mechanics": 0.1, "max_remeshes": 0}), ("adaptivity", {"time": "1 %"}),
    ("adaptivity", {"tolerance": 0.05, "bodies": ["upper", "no", "upper"]}),
    ("adaptivity", {"heat": "10 %", "size_min": "1 m", "size_max": "1 mm"}),
    ("adaptivity", {"tolerance": 1e-300, "max_cells": 10, "growth": 1e-300}),
    ("checkpoint", {"every": "1 s"}), ("mechanics", False), ("dimension", "axisymmetric"),
    ("dimension", "3d"), ("strain", "small"), ("strain", "finite"),
    ("solver", {"system": "saddle"}), ("solver", {"petsc": {"ksp_type": "no", "": "", "-x": "\x00"}}),
    ("solver", {"petsc": {"pc_type": "lu", "mat_mumps_icntl_14": "x"}}), ("output", {"times": ["0.1 s"]}),
    ("output", {"times": ["1e-300 s"]}), ("time", {"end": "1e-300 s", "step": "1e-300 s"}),
    ("time", {"end": "1 s", "step": "1 s", "step_min": "1e-300 s"}),
    ("expect", {"steps": {"min": 0}, "iterations.max": {"max": 3}, "no": {"min": 0}}),
    ("obstacles", {"wall": {"shape": "circle", "center": ["0 m", "0 m"], "radius": "1e300 m"}}),
    ("obstacles", {"wall": {"shape": "polyline", "points": [["0 m", "0 m"], ["0 m", "1 m"]], "closed": True}}),
    ("obstacles", {"wall": {"shape": "plane", "point": ["0 m", "0 m"], "normal": [1e-200, 1e-200]}}),
    ("interfaces", {"a": {"nonmortar": "upper.left", "mortar": "upper.right"}}),
    ("interfaces", {"a": {"nonmortar": "upper.bottom", "mortar": "wall"}}),
    ("interfaces", {"a": {"nonmortar": "upper.bottom", "mortar": "lower.top", "search_radius": "1e-300 m"}}),
    ("conditions", []), ("probes", {}), ("probes", {"p": {"on": "upper", "at": ["0 m", "0 m"], "value": "temperature"}}),
    ("materials", {"m": {"youngs_modulus": "1e-300 Pa", "poisson_ratio": 0.4999999999999999}}),
    ("variants", {"v": {"time.end": "2 s"}, "w": {"": 1}, "u": {"conditions.7": 3}}), ("variants", {"v": 3}),
)  # fmt: skip

odd_values = st.one_of(
    st.sampled_from(ODD_TEXTS),
    st.sampled_from(ODD_QUANTITIES),
    st.sampled_from(ODD_NUMBERS),
    st.sampled_from(ODD_OTHERS).map(copy.deepcopy),
)


def places(value: Any) -> Iterator[Place]:
    """Every value in a nest of tables and lists, by what holds it and its key."""
    items: Any = ()
    if isinstance(value, dict):
        items = list(value.items())
    elif isinstance(value, list):
        items = list(enumerate(value))
    for key, item in items:
        yield value, key
        yield from places(item)


def _delete(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    del holder[key]


def _replace(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    holder[key] = draw(odd_values)


def _rename(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    if isinstance(holder, dict):
        name = draw(st.sampled_from((f"{key}s", key[:-1], key.upper(), f" {key}", *ODD_TEXTS)))
        holder[name] = holder.pop(key)


def _duplicate(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    again = copy.deepcopy(holder[key])
    if isinstance(holder, dict):
        holder[f"{key}2"] = again
    else:
        holder.insert(draw(st.integers(0, len(holder))), again)


def _swap(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    other, place = draw(st.sampled_from(list(places(raw))))
    holder[key] = copy.deepcopy(other[place])


def _nest(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    depth, table = draw(st.sampled_from((1, 2, 100))), draw(st.booleans())
    for _ in range(depth):
        holder[key] = {"x": holder[key]} if table else [holder[key]]


def _stretch(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    """Another size of a number, with its unit if it has one."""
    factor = draw(st.sampled_from((0, -1, 1e-200, 1e-12, 1e-3, 0.5, 3, 1e3, 1e12, 1e200)))
    value = holder[key]
    if isinstance(value, str):
        number, _, unit = value.partition(" ")
        try:
            holder[key] = f"{float(number) * factor:g} {unit}"
        except ValueError:
            holder[key] = value[::-1]
    elif isinstance(value, int | float):
        holder[key] = value * factor


def _type_over(draw: Draw, raw: Raw, holder: Any, key: Any) -> None:
    """A slip of the keyboard inside a text."""
    value = holder[key]
    if isinstance(value, str):
        at = draw(st.integers(0, len(value)))
        holder[key] = value[:at] + draw(st.characters(exclude_categories=("Cs",))) + value[at + 1 :]


WAYS = (_delete, _replace, _rename, _duplicate, _swap, _nest, _stretch, _type_over)


@st.composite
def mutated(draw: Draw, bases: tuple[Path, ...]) -> Raw:
    """Contents of a case file with one to four changes."""
    raw = tomllib.loads(draw(st.sampled_from(bases)).read_text())
    for _ in range(draw(st.integers(1, 4))):
        if draw(st.integers(0, 4)) == 0:
            key, value = draw(st.sampled_from(SNIPPETS))
            old = raw.get(key)
            mixed = isinstance(old, dict) and isinstance(value, dict) and draw(st.booleans())
            raw[key] = copy.deepcopy(old | value if mixed else value)
        elif found := list(places(raw)):
            draw(st.sampled_from(WAYS))(draw, raw, *draw(st.sampled_from(found)))
    return raw


def texts(bases: tuple[Path, ...]) -> st.SearchStrategy[bytes]:
    """Bytes of odd case files."""
    return st.one_of(
        mutated(bases).map(lambda raw: dumps(raw).encode()),
        damaged(st.sampled_from(bases).map(Path.read_bytes)),
        mutated(bases).flatmap(lambda raw: damaged(st.just(dumps(raw).encode()))),
        st.binary(max_size=60),
    )


@st.composite
def damaged(draw: Draw, whole: st.SearchStrategy[bytes]) -> bytes:
    """A file that is cut off, has lines twice, lost or exchanged, or foreign bytes inside."""
    data: bytes = draw(whole)
    for _ in range(draw(st.integers(1, 3))):
        lines = data.splitlines(keepends=True)
        way = draw(st.integers(0, 4))
        if way == 0 or not lines:
            at = draw(st.integers(0, len(data)))
            data = data[:at] + draw(st.binary(max_size=4)) + data[at + draw(st.integers(0, 3)) :]
        elif way == 1:
            data = data[: draw(st.integers(0, len(data)))]
        else:
            at, to = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
            line = lines[at] if way == 2 else lines.pop(at)
            if way != 3:
                lines.insert(to, line)
            data = b"".join(lines)
    return data
