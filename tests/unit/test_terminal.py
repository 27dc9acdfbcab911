"""What a run prints while it runs."""

import io
from types import SimpleNamespace

from contactfem.terminal import Reporter, step_line


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
    case = SimpleNamespace(title="t", time=SimpleNamespace(end=1.0))
    with Reporter(case, stream) as reporter:
        reporter.step(make_run().steps[0])
        reporter.retry(0.25, 0.125, "no convergence")
        reporter.closing(["done"])
    lines = stream.getvalue().splitlines()
    assert len(lines) == 3
    assert lines[1].strip() == "t = 0.25 s: no convergence; again with a step of 0.125 s"
    assert "\x1b" not in stream.getvalue()


def test_a_bar_on_a_terminal_between_whole_lines(make_run):
    stream = Screen()
    case = SimpleNamespace(title="t", time=SimpleNamespace(end=1.0))
    with Reporter(case, stream) as reporter:
        for step in make_run().steps:
            reporter.step(step)
    text = stream.getvalue()
    assert "\x1b" in text
    for number in (1, 2, 3, 4):
        assert f"step    {number}" in text
