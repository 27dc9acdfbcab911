"""Read a case file and check it whole."""

import tomllib
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from contactfem.case.cross_checks import broken_links
from contactfem.case.error_messages import error_lines
from contactfem.case.material_library import with_library
from contactfem.case.overrides import override, with_variant
from contactfem.case.schema import Case, force_unit
from contactfem.case.side_choice import with_chosen_sides, with_provisional_sides
from contactfem.common.text import one_line
from contactfem.errors import CaseError, MeshError


def read_case(path: Path | str, overrides: Sequence[str] = (), variant: str | None = None) -> Case:
    """Read a case file.

    Args:
        path: the file.
        overrides: "a.b.c=value" each, applied last; items of lists by their index from 0.
        variant: name of one of the file's variants, or None for the base case.

    Returns:
        The case in SI.

    Raises:
        CaseError: what is wrong, one line for each mistake.
    """
    path = Path(path)
    raw = _toml(path)
    try:
        if variant is not None:
            raw = with_variant(raw, variant)
        for text in overrides:
            raw = override(raw, text)
    except CaseError as error:
        raise CaseError(f"{path}: {one_line(str(error))}") from None
    return case_of(raw, path)


def case_of(raw: dict[str, Any], path: Path) -> Case:
    """Case of the contents of a file.

    Args:
        raw: its contents as TOML gives them, with variants and changed values put in.
        path: the file, which others are named relative to.

    Returns:
        The case in SI.

    Raises:
        CaseError: what is wrong, one line for each mistake.
    """
    for key in ("path", "contents"):
        if key in raw:
            raise CaseError(f"{path}: {key}: unknown key")
    raw = with_library(raw)
    contents = {key: value for key, value in raw.items() if key != "variants"}
    axes = 3 if raw.get("dimension") == "3d" else 2
    units = {"N/m": force_unit(raw.get("dimension", "plane strain"))}
    context = {"strict_units": True, "folder": path.parent, "axes": axes, "units": units}
    try:
        case = Case.model_validate({**raw, "path": path, "contents": contents}, context=context)
        case = with_provisional_sides(case)
        lines = [f"{path}: {one_line(line)}" for line in broken_links(case)]
    except ValidationError as error:
        raise CaseError("\n".join(f"{path}: {s}" for s in error_lines(error, Case, raw))) from None
    except MeshError as error:
        raise CaseError(f"{path}: {one_line(str(error))}") from None
    if lines:
        raise CaseError("\n".join(lines))
    between = any(sides.between is not None for sides in case.interfaces.values())
    return with_chosen_sides(case) if between else case


def _toml(path: Path) -> dict[str, Any]:
    """Contents of a TOML file.

    Raises:
        CaseError: no such file, a folder, not readable, not UTF-8 or not TOML.
    """
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except FileNotFoundError:
        raise CaseError(f"{path}: there is no such file{_near(path)}") from None
    except IsADirectoryError:
        inside = sorted(path.glob("*.toml"))
        hint = f"; give one of its files, such as {inside[0]}" if inside else ""
        raise CaseError(f"{path}: is a folder, not a case file{hint}") from None
    except OSError as error:
        raise CaseError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise CaseError(f"{path}: is not UTF-8 text (byte {error.start})") from None
    except (ValueError, RecursionError) as error:
        why = str(error).splitlines()[0].replace("Cannot overwrite a value", "a key is there twice")
        raise CaseError(f"{path}: is not TOML: {why}") from None


def _near(path: Path) -> str:
    """Hint at a case file of nearly that name, in its folder or among the cases here."""
    there = {
        file.stem: file for file in (*Path("cases").glob("*.toml"), *path.parent.glob("*.toml"))
    }
    near = get_close_matches(path.stem, there, n=1)
    return f"; did you mean '{there[near[0]]}'?" if near else ""
