"""`contactfem study`."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from contactfem.errors import CaseError

if TYPE_CHECKING:
    from contactfem.study.refinement import What

WHAT: dict[str, tuple[What, ...]] = {
    "space": ("space",),
    "time": ("time",),
    "both": ("space", "time"),
}
RANKS_OF_LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK")


def add_study_options(verb: argparse.ArgumentParser) -> None:
    """Give a command the options of a study, besides those that it shares with `run`."""
    verb.add_argument(
        "--levels",
        type=_positive,
        required=True,
        metavar="N",
        help="runs of each curve, each twice as fine as the one before; the first is the case",
    )
    verb.add_argument(
        "--refine",
        choices=WHAT,
        default="space",
        help="what becomes finer: cells (default), steps, or both; "
        "where they adapt, the error asked for is halved instead",
    )
    verb.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=V1,V2",
        help="a curve for each value, such as solver.system=condensed,saddle "
        "or variant=base,standard; may be given several times, for all combinations",
    )
    verb.add_argument(
        "--ranks",
        type=_ranks,
        default=(1,),
        metavar="N1,N2",
        help="a curve for each number of processes",
    )
    target = verb.add_mutually_exclusive_group()
    target.add_argument("--error", metavar="NAME", help="a measured number that is an error")
    target.add_argument(
        "--quantity", metavar="NAME", help="a measured number, to compare with the finest run's"
    )
    verb.add_argument(
        "--patience",
        type=float,
        default=3600.0,
        metavar="SECONDS",
        help="stop a run that takes longer (default 3600)",
    )
    verb.add_argument(
        "--out", type=Path, metavar="DIR", help="folder to write to; studies/CASE if not given"
    )


def study_command(options: argparse.Namespace) -> int:
    """Run the study that the command line asks for.

    Args:
        options: with `case`, `variant`, `overrides` and what `add_study_options` added.

    Returns:
        Exit code.

    Raises:
        CaseError: the case cannot be read, or the program was started by mpirun.
    """
    from contactfem.case.read import read_case
    from contactfem.case.settings import Study as Table
    from contactfem.study.runs import Curve
    from contactfem.study.study import Study, run_study, target_of

    if any(name in os.environ for name in RANKS_OF_LAUNCHERS):
        raise CaseError("study starts its runs by itself; without mpirun, but with --ranks")
    case = read_case(options.case, options.overrides, options.variant)
    asked = None
    if options.error or options.quantity:
        asked = Table(error=options.error, quantity=options.quantity)
        said = case.study
        if said is not None and said.quantity is not None and said.quantity == asked.quantity:
            asked = said
    study = Study(
        path=options.case,
        out=options.out or Path("studies") / options.case.stem,
        base=Curve("", options.variant, tuple(options.overrides)),
        variations=tuple(options.vary),
        ranks=options.ranks,
        levels=options.levels,
        what=WHAT[options.refine],
        patience=options.patience,
        command=shlex.join(["contactfem", *sys.argv[1:]]),
    )
    return run_study(study, target_of(case, asked))


def _positive(text: str) -> int:
    """A whole number from 1.

    Raises:
        ValueError: something else.
    """
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def _ranks(text: str) -> tuple[int, ...]:
    """Whole numbers from 1, between commas.

    Raises:
        ValueError: something else.
    """
    return tuple(_positive(part) for part in text.split(","))
