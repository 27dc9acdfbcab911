"""Quantities against pint, round trips, and what is refused."""

import math

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from contactfem.common.time_table import Table, constant
from contactfem.common.unit_parser import (
    DIMENSIONS,
    PLAIN,
    PREFIXABLE,
    PREFIXES,
    UnitError,
    dimension,
    unit,
)
from contactfem.common.units import (
    EXAMPLES,
    STRICT,
    Length,
    LengthTable,
    Number,
    Pressure,
    si,
)

REGISTRY = pint.UnitRegistry()
SYMBOLS = sorted({*PREFIXABLE, *PLAIN, *(p + s for p in PREFIXES for s in PREFIXABLE)})


class Sample(BaseModel):
    length: Length = 0.0
    pressure: Pressure = 0.0
    number: Number = 0.0
    table: LengthTable = constant(0.0)


def read(**values):
    return Sample.model_validate(values, context=STRICT)


def why(**values):
    with pytest.raises(ValidationError) as caught:
        read(**values)
    return caught.value.errors()[0]["msg"]


@pytest.mark.parametrize("symbol", SYMBOLS)
def test_every_symbol_agrees_with_pint(symbol):
    base = REGISTRY.Quantity(1.0, symbol).to_base_units()
    powers = [base.dimensionality[f"[{d}]"] for d in ("length", "mass", "time", "temperature")]
    assert unit(symbol).exponents == tuple(powers)
    # pint's base unit of mass is the kilogram here: to_base_units is SI
    assert unit(symbol).factor == pytest.approx(base.magnitude, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "N/mm^2",
        "N/mm**2",
        "W/m^2/K",
        "J/(kg K)",
        "J/kg/K",
        "1/K",
        "kg*m/s^2",
        "N/mm s",
        "kN/(mm (s K))",
        "mm^2/s^2/K",
        "N^2/m^3",
        "m^-1",
        "m^0.5",
    ],
)
def test_products_agree_with_pint(text):
    base = REGISTRY.Quantity(1.0, REGISTRY.Unit(text)).to_base_units()
    powers = [base.dimensionality[f"[{d}]"] for d in ("length", "mass", "time", "temperature")]
    assert unit(text).exponents == pytest.approx(powers)
    assert unit(text).factor == pytest.approx(base.magnitude, rel=1e-14)


def test_pint_reads_what_the_table_does_not_know():
    assert si("1 inch", "m") == pytest.approx(0.0254, rel=1e-15)
    assert si("30 psi", "Pa") == pytest.approx(206842.718795, rel=1e-10)
    assert si("2 lbf/inch", "N/m") == pytest.approx(350.2536704929528, rel=1e-12)


@given(
    value=st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6),
    symbol=st.sampled_from(["m", "mm", "um", "km", "inch"]),
)
def test_lengths_make_the_round_trip(value, symbol):
    found = si(f"{value!r} {symbol}", "m")
    assert REGISTRY.Quantity(found, "m").to(symbol).magnitude == pytest.approx(value, rel=1e-14)


@given(st.decimals(-10000, 10000, places=4))
def test_decimal_prefixes_are_exact(number):
    assert si(f"{number} mm", "m") == float(number.scaleb(-3))
    assert si(f"{number} GPa", "Pa") == float(number.scaleb(9))


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text):
    try:
        assert math.isfinite(si(text, "m"))
    except UnitError as error:
        assert "\n" not in str(error)


@given(st.floats(-1e3, 1e3), st.sampled_from(["*", "/", " ", "·"]), st.sampled_from(["m", "s"]))
def test_blank_and_signs(power, sign, symbol):
    product = unit(f"N{sign}{symbol}^{power:.3f}")
    direction = -1 if sign == "/" else 1
    expected = unit("N") * unit(symbol) ** (direction * float(f"{power:.3f}"))
    assert product.exponents == pytest.approx(expected.exponents)


@pytest.mark.parametrize("symbol", [s for s in DIMENSIONS if s])
def test_dimensions_have_names_and_examples_fit(symbol):
    assert dimension(unit(symbol).exponents).split(maxsplit=1)[1] == DIMENSIONS[symbol]
    if symbol in EXAMPLES:
        assert math.isfinite(si(EXAMPLES[symbol], symbol))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("10 MPa", "is a stress, not a length"),
        ("10", "has no unit"),
        ("10 mmm", "'mmm' is not a known unit; did you mean 'mm'?"),
        ("nan m", "is not a finite number followed by a unit"),
        ("inf m", "is not a finite number followed by a unit"),
        ("1e999 m", "is too large a number"),
        ("1e58 km", "is too large a number"),
        ("-1e-58 mm", "is too small a number"),
        ("m", "is not a finite number followed by a unit"),
        ("", "is not a finite number followed by a unit"),
        ("1.2.3 m", "is not a finite number followed by a unit"),
        ("1,5 m", "',5 m' is not a unit: unexpected ',5 m'"),
        ("1 m)", "'m)' is not a unit: unexpected ')'"),
        ("1 (m", "has a bracket that is not closed"),
        ("1 m^", "has a power that is not a number"),
        ("1 m/", "has nothing where a unit should be"),
        ("1 m/2", "has '2' where a unit should be"),
        ("20 degC", "is a temperature, not a length"),
        ("20 degRe", "'degRe' has a zero of its own; give kelvin"),
        ("1 A", "'A' is not a unit of mechanics or heat"),
        ("1 km^300", "'km^300' is out of all bounds"),
        ("1 m^2", "is an area, not a length"),
    ],
)
def test_what_is_not_a_length(text, reason):
    assert why(length=text).startswith(reason)


def test_case_files_give_units_and_python_gives_si():
    assert why(length=3).startswith("has no unit")
    assert why(length=True).startswith("is not a quantity")
    assert why(length=10**400).startswith("has no unit")
    assert Sample(length=3).length == 3.0
    with pytest.raises(ValidationError, match="is not finite"):
        Sample(length=math.nan)
    assert read(number=3).number == 3.0
    assert read(number="3 mm").number == 0.003
    assert why(number=math.inf).startswith("is not finite")
    assert why(number=10**400).startswith("is not finite")


def test_a_table_is_linear_between_its_times_and_held_outside():
    table = read(table=[["1 s", "1 mm"], ["3 s", "5 mm"], ["4 s", "5 mm"]]).table
    times = np.array([-1.0, 1.0, 1.5, 2.0, 3.0, 3.5, 4.0, 9.0])
    values = [table(t) for t in times]
    assert values == pytest.approx(np.interp(times, table.times, table.values), rel=1e-15)
    assert table.at(2.0, ramp_end=100.0) == table(2.0)


def test_a_constant_is_reached_over_the_first_step():
    table = read(table="2 mm").table
    assert table == Table((), (0.002,))
    assert table(-5.0) == table(7.0) == 0.002
    assert [table.at(t, 0.5) for t in (0.0, 0.25, 0.5, 3.0)] == [0.0, 0.001, 0.002, 0.002]


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ([["1 s", "1 mm"]], "is not a table"),
        ([["1 s"], ["2 s"]], "is not a table"),
        ([1, 2], "is not a table"),
        ([], "is not a table"),
        ([["1 s", "1 mm"], ["1 s", "1 mm"]], "times are out of order: 1 s follows 1 s"),
        ([["1 s", "1 mm"], ["500 ms", "1 mm"]], "times are out of order: 0.5 s follows 1 s"),
        ([["1 s", "1 mm"], ["2 s", "1 Pa"]], "is a stress, not a length"),
        ([["1 m", "1 mm"], ["2 s", "1 m"]], "is a length, not a time"),
        ([["0 s", 0], ["2 s", "1 m"]], "has no unit"),
        ({"a": 1}, "is not a quantity"),
    ],
)
def test_what_is_not_a_table(rows, reason):
    assert why(table=rows).startswith(reason)
