"""Verdicts: what passes, what misses, what cannot be expected at all."""

import math
from pathlib import Path

import pytest

from contactfem.case.read import read_case
from contactfem.errors import CaseError
from contactfem.results.expectations import check_names, judge, measure


def verdict_of(run, expectation, value):
    case = run(expect={"sole.pressure_max": expectation}).case
    return judge(case, {"sole.pressure_max": value})[0]


@pytest.mark.parametrize(
    ("given", "value", "passed"),
    [
        ({"value": 100.0, "rel": 0.01}, 100.9, True),
        ({"value": 100.0, "rel": 0.01}, 101.1, False),
        ({"value": -100.0, "rel": 0.01}, -99.1, True),
        ({"value": 0.0, "abs": 1e-9}, -2e-9, False),
        ({"value": 100.0, "abs": 1.0, "rel": 0.01}, 101.9, True),
        ({"max": 3.0}, -1e9, True),
        ({"max": 3.0}, 3.1, False),
        ({"min": 1.0, "max": 3.0}, 0.9, False),
        ({"min": 1.0}, math.inf, True),
        ({"min": 1.0}, math.nan, False),
    ],
)
def test_bounds(make_run, expecting, given, value, passed):
    assert verdict_of(make_run, expecting(**given), value).passed is passed


def test_verdicts_of_a_run(make_run):
    run = make_run()
    verdicts = {v.key: v for v in judge(run.case, measure(run))}
    assert [v.passed for v in verdicts.values()] == [True, True, True, True]
    peak = verdicts["sole.pressure_max"]
    assert (peak.unit, peak.low, peak.high) == ("Pa", 0.97 * 9.351351e6, 1.03 * 9.351351e6)


def test_a_number_that_is_not_there_misses(make_run):
    run = make_run()
    verdicts = judge(run.case, {})
    assert not any(v.passed for v in verdicts)
    assert math.isnan(verdicts[0].value)


def test_a_misspelt_name_is_an_error_with_the_nearest_one(make_run, expecting):
    case = make_run(expect={"sole.presure_max": expecting(max=1.0)}).case
    with pytest.raises(CaseError, match=r"did you mean 'sole.pressure_max'"):
        check_names(case)
    with pytest.raises(CaseError, match=r"nothing measures 'sole.presure_max'"):
        judge(case, {})


def test_errors_need_a_closed_form(make_run, expecting):
    case = make_run(expect={"sole.pressure_error_l2": expecting(max=1.0)}, closed_form={}).case
    with pytest.raises(CaseError):
        check_names(case)


CASES = sorted((Path(__file__).parents[3] / "cases").glob("**/*.toml"))


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_every_case_file_expects_numbers_that_are_measured(path):
    case = read_case(path)
    check_names(case)
    for variant in case.variants:
        check_names(read_case(path, variant=variant))
