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
