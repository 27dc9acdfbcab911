"""The command line: one function for each of its commands."""

import argparse
import glob
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from contactfem import __version__
from contactfem.cli.study import add_study_options, study_command
from contactfem.common.text import printable
from contactfem.errors import CaseError, ContactfemError, ExitCode

INTERRUPTED = 130  # as shells have it
EXIT_CODES = (
    "exit codes: 0 done, 1 an expectation missed, 2 bad case, 3 the solver gave up, "
    "4 stopped by a signal and can be resumed, 5 a state that cannot be (solver.verify)"
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: words after the program's name; None takes the program's own.

    Returns:
        Exit code.
    """
    options = parser().parse_args(arguments)
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except ContactfemError as error:
        print(printable(error), file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:  # the reader of a pipe, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return ExitCode.DONE
    except KeyboardInterrupt:
        return INTERRUPTED


def parser() -> argparse.ArgumentParser:
    """The grammar of the command line."""
    top = argparse.ArgumentParser(
        prog="contactfem",
        description="Mortar contact with friction on FEniCSx, run from case files with units.",
        epilog=EXIT_CODES,
    )
    top.add_argument("--version", action="version", version=f"contactfem {__version__}")
    verbs = top.add_subparsers(required=True, metavar="COMMAND")
    check = _verb(verbs, "check", _check, "read a case file, say what it models; runs nothing")
    mesh = _verb(verbs, "mesh", _mesh, "write the meshes of a case with their named groups")
    run = _verb(verbs, "run", _run, "solve a case; under mpirun on many ranks")
    resume = _verb(verbs, "resume", _resume, "go on with a run that was stopped or gave up")
    verify = _verb(verbs, "verify", _verify, "look at the results of a run: can they be?")
    study = _verb(verbs, "study", study_command, "run a family of cases: error against cost")
    report = _verb(verbs, "report", _report, "show results and whether they meet expectations")
    view = _verb(verbs, "view", _view, "show the fields of a run: a window, or a page that turns")
    film = _verb(verbs, "film", _film, "make an animated picture of a run that kept snapshots")
    schema = _verb(verbs, "schema", _schema, "print the JSON schema of case files, for editors")
    schema.add_argument(
        "--markdown", action="store_true", help="all keys as a page to read instead"
    )
    for verb in (check, mesh, run, study):
        verb.add_argument("case", type=Path, metavar="CASE", help="case file (TOML)")
        verb.add_argument("--variant", metavar="NAME", help="a variant that the case file defines")
        _add_set(verb, "change a value, such as time.end='2 s' or conditions.0.pressure='1 MPa'")
    for verb in (check, run, resume):
        verb.add_argument(
            "--no-code", action="store_true", help="refuse a case that runs Python of its own"
        )
    resume.add_argument("folder", type=Path, metavar="DIR", help="folder of the run")
    verify.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    _add_set(resume, "change how it is solved or written, such as time.step_min='1 us'")
    mesh.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write to")
    run.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder to write to; runs/CASE[-VARIANT] if not given. "
        "--variant all runs the case and all its variants, into folders of DIR if given",
    )
    add_study_options(study)
    _add_what_shows(view, film, report)
    return top


def _add_what_shows(
    view: argparse.ArgumentParser, film: argparse.ArgumentParser, report: argparse.ArgumentParser
) -> None:
    """Options of the commands that show a finished run."""
    view.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    view.add_argument(
        "--out", type=Path, metavar="FILE", help="page to write, also where there is a display"
    )
    view.add_argument(
        "--pictures", action="store_true", help="write pictures into DIR/figures (with pyvista)"
    )
    film.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    film.add_argument(
        "--out", type=Path, metavar="FILE", help="GIF file to write; DIR/film.gif if not given"
    )
    report.add_argument(
        "--html",
        action="store_true",
        help="write one page about each run into its folder, report.html, which needs nothing else",
    )
    report.add_argument(
        "--junit",
        type=Path,
        metavar="FILE",
        help="write the verdicts for a CI server, as JUnit XML",
    )
    report.add_argument(
        "paths",
        type=Path,
        nargs="+",
        metavar="DIR|CASE",
        help="folder of a run, or its case file; "
        "or a folder of case files, which are all run and judged in one table",
    )


def _add_set(verb: argparse.ArgumentParser, text: str) -> None:
    """An option that changes values of the case."""
    verb.add_argument(
        "--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE", help=text
    )


def _verb(
    verbs: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    command: Callable[[argparse.Namespace], int],
    summary: str,
) -> argparse.ArgumentParser:
    """A command with its help."""
    text = f"{summary[0].upper()}{summary[1:]}."
    verb = verbs.add_parser(name, help=summary, description=text, epilog=EXIT_CODES)
    verb.set_defaults(command=command)
    return verb


def _check(options: argparse.Namespace) -> int:
    from contactfem.case.python_code import refuse_code
    from contactfem.case.read import read_case
    from contactfem.check.check import check_case
    from contactfem.results.expectations import check_names

    case = read_case(options.case, options.overrides, options.variant)
    if options.no_code:
        refuse_code(case)
    check_names(case)
    for variant in case.variants if options.variant is None else ():
        try:
            check_names(read_case(options.case, options.overrides, variant))
        except CaseError as error:
            lines = str(error).splitlines()
            raise CaseError("\n".join(f"{line} (variant {variant})" for line in lines)) from None
    print(check_case(case))
    return ExitCode.DONE


def _mesh(options: argparse.Namespace) -> int:
    from contactfem.case.read import read_case
    from contactfem.output.mesh_files import write_meshes

    case = read_case(options.case, options.overrides, options.variant)
    for line in write_meshes(case, options.out):
        print(printable(line))
    return ExitCode.DONE


def _run(options: argparse.Namespace) -> int:
    from contactfem.cli.run import run_command

    return run_command(
        options.case, options.overrides, options.variant, options.out, no_code=options.no_code
    )


def _resume(options: argparse.Namespace) -> int:
    from contactfem.cli.run import resume_command

    return resume_command(options.folder, options.overrides, no_code=options.no_code)


@contextmanager
def _files_of_runs(paths: Sequence[Path]) -> Iterator[None]:
    """Say in one line that a file of a run is not what this program wrote.

    Raises:
        CaseError: What is done inside finds parts missing, or of another kind.
    """
    try:
        yield
    except (KeyError, IndexError, ValueError, TypeError, AttributeError, OverflowError) as error:
        where = ", ".join(str(path) for path in paths)
        why = " ".join(f"{type(error).__name__}: {error}".split())
        raise CaseError(
            f"{where}: a file there is damaged, or of another program ({why})"
        ) from None


def _verify(options: argparse.Namespace) -> int:
    from contactfem.audit.files import verify
    from contactfem.output.tables import read_summary

    with _files_of_runs([options.folder]):
        found = verify(options.folder, read_summary(options.folder))
    for finding in found:
        print(finding)
    if not found:
        print(f"{options.folder}: nothing is wrong with its last state and its steps")
    return ExitCode.WRONG if found else ExitCode.DONE


def _report(options: argparse.Namespace) -> int:
    if options.html:
        for path in filter(_holds_cases, options.paths):
            raise CaseError(f"{path}: holds case files; --html takes folders of runs")
        return _pages([folder for path in options.paths for folder in _folders(path)])
    if options.junit is not None:
        return _junit(
            options.junit, [folder for path in options.paths for folder in _folders(path)]
        )
    from contactfem.output.report.report import report

    if len(options.paths) == 1 and _holds_cases(options.paths[0]):
        from contactfem.study.suite import report_folder

        return report_folder(options.paths[0], Path("runs") / options.paths[0].resolve().name)
    folders = [folder for path in options.paths for folder in _folders(path)]
    with _files_of_runs(folders):
        return report(folders)


def _junit(path: Path, folders: Sequence[Path]) -> int:
    """Write the verdicts on runs for a CI server."""
    from contactfem.output.report.junit import write_junit

    try:
        passed = write_junit(path, folders)
    except OSError as error:
        raise CaseError(f"{path}: cannot be written: {error.strerror}") from None
    print(path)
    return ExitCode.DONE if passed else ExitCode.MISSED


def _pages(folders: Sequence[Path]) -> int:
    """Write a page about each run."""
    from contactfem.output.report.html_page import write_page

    for folder in folders:
        try:
            with _files_of_runs([folder]):
                print(write_page(folder))
        except OSError as error:
            raise CaseError(f"{folder}: cannot be written to: {error.strerror}") from None
    return ExitCode.DONE


def _holds_cases(folder: Path) -> bool:
    """Whether a folder is one of case files."""
    return folder.is_dir() and any(folder.glob("*.toml"))


def _folders(path: Path) -> list[Path]:
    """Folders of runs: the path itself, or those of a case file and its variants.

    Raises:
        CaseError: there is neither.
    """
    from contactfem.common.text import nearest

    if path.is_dir():
        return [path]
    runs = Path("runs")
    folders = [runs / path.stem, *sorted(runs.glob(f"{glob.escape(path.stem)}-*"))]
    found = [folder for folder in folders if folder.is_dir()]
    if not found and path.suffix != ".toml":
        there = [str(folder) for folder in runs.glob("*")]
        raise CaseError(f"{path}: there is no such folder of a run{nearest(str(path), there)}")
    if not found:
        raise CaseError(f"{path}: has no results in {runs}; 'contactfem run {path}' makes them")
    return found


def _film(options: argparse.Namespace) -> int:
    from contactfem.output.figures.animation import film

    print(film(options.folder, options.out or options.folder / "film.gif"))
    return ExitCode.DONE


def _view(options: argparse.Namespace) -> int:
    from contactfem.output.view.pictures import draw, has_display, has_pyvista

    if options.pictures:
        print(*draw(options.folder, window=False), sep="\n")
    elif options.out is None and has_display() and has_pyvista():
        draw(options.folder, window=True)
    else:
        from contactfem.output.view.page import write_view

        try:
            print(write_view(options.folder, options.out))
        except OSError as error:
            raise CaseError(f"{options.folder}: cannot be written to: {error.strerror}") from None
    return ExitCode.DONE


def _schema(options: argparse.Namespace) -> int:
    from contactfem.cli.key_reference import case_schema, reference_page

    print(reference_page() if options.markdown else json.dumps(case_schema(), indent=2))
    return ExitCode.DONE
