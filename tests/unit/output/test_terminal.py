"""What a run prints while it runs."""

import io
from types import SimpleNamespace

import pytest

from contactfem.output.terminal import Remaining, Reporter, duration, step_line


class Screen(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_a_step_is_one_line(make_run, changed):
    run = make_run()
    line = step_line(run.steps[-1])
    assert "\n" not in line
    for part in ("step    4", "t = 1 s", "iterations  4", "stick 30", "0.9362 N/mm", "-10 N/mm"):
        assert part in line
    assert "cut-backs" not in line
    assert step_line(run.steps[2]).endswith("cut-backs 1")
    assert step_line(changed(run.steps[0], forces={})).endswith("slip 11")


def test_plain_lines_without_a_terminal(make_run):
    stream = io.StringIO()
    case = SimpleNamespace(force_unit="N/m", time=SimpleNamespace(end=1.0))
    with Reporter(case, stream) as reporter:
        reporter.step(make_run().steps[0])
        reporter.say("done [not markup]")
    lines = stream.getvalue().splitlines()
    assert len(lines) == 2
    assert lines[1] == "done [not markup]"
    assert "\x1b" not in stream.getvalue()


def test_a_bar_on_a_terminal_between_whole_lines(make_run):
    stream = Screen()
    case = SimpleNamespace(force_unit="N/m", time=SimpleNamespace(end=1.0))
    with Reporter(case, stream) as reporter:
        for step in make_run().steps:
            reporter.step(step)
        reporter.say("[not markup]")
    text = stream.getvalue()
    assert "\x1b" in text
    assert "[not markup]" in text
    for number in (1, 2, 3, 4):
        assert f"step    {number}" in text


def test_what_is_left_is_said_now_and_then(make_run):
    seconds = iter([100.0, 110.0, 130.0, 149.0, 190.0])  # at the start and after each step
    stream = io.StringIO()
    case = SimpleNamespace(force_unit="N/m", time=SimpleNamespace(end=1.0))
    with Reporter(case, stream, clock=lambda: next(seconds)) as reporter:
        for step in make_run().steps:
            reporter.step(step)
    lines = stream.getvalue().splitlines()
    # half of the run took 30 s; 19 s later it is not said again, and at the end nothing is left
    assert [line.endswith(" left") for line in lines] == [False, True, False, False]
    assert lines[1].endswith("  about 30 s left")


def test_a_run_that_goes_on_counts_from_where_it_goes_on(make_run):
    seconds = iter([0.0, 60.0])
    third = make_run().steps[2]  # from 0.5 s to 0.75 s
    assert Remaining(1.0, lambda: next(seconds)).words(third) == "  about 60 s left"


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.4, "0 s"), (89.0, "89 s"), (100.0, "2 min"), (5300.0, "88 min"), (12600.0, "3.5 h")],
)
def test_durations_read_well(seconds, words):
    assert duration(seconds) == words
