"""Keywords of Abaqus files, with options and data lines."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from contactfem.errors import MeshError

DEEPEST = 10  # files that include files
LARGEST = 2**53  # labels; what a float holds exactly


@dataclass(frozen=True)
class Keyword:
    """One keyword.

    Attributes:
        name: in capitals and without blanks, such as ENDPART.
        options: by name in capitals; those without a value are empty.
        line: its number, for messages, with the file's name if it is an included one.
        data: number and text of each of its data lines.
    """

    name: str
    options: dict[str, str]
    line: str
    data: list[tuple[str, str]] = field(default_factory=list)

    def wrong(self, what: str) -> MeshError:
        """The error about this keyword."""
        return MeshError(f"{self.line}: *{self.name} {what}")

    def needed(self, option: str) -> str:
        """An option's value.

        Raises:
            MeshError: it is not given.
        """
        if not (value := self.options.get(option, "")):
            raise self.wrong(f"has no {option}=")
        return value


def keywords(path: Path) -> list[Keyword]:
    """Keywords of a file and of the files that it includes.

    Args:
        path: the file.

    Raises:
        MeshError: an included file that is not there, or data before the first keyword.
    """
    found: list[Keyword] = []
    for line, text in _lines(path, path, 0):
        if text.startswith("*"):
            found.append(_keyword(line, text[1:]))
        elif found:
            found[-1].data.append((line, text))
        else:
            raise MeshError(f"{line}: no keyword (*NODE and the like) stands before '{text[:40]}'")
    return found


def _lines(path: Path, top: Path, depth: int) -> Iterator[tuple[str, str]]:
    """Lines without comments, keywords in one line each, included files in their places."""
    content = path.read_bytes()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    where = "line" if path == top else f"{path.name}, line"
    begun: tuple[str, str] | None = None  # a keyword that goes on in the next line
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        place, whole = f"{where} {number}", line
        if begun is not None:
            place, whole = begun[0], begun[1] + line
        begun = (place, whole) if whole.startswith("*") and whole.endswith(",") else None
        if begun is not None:
            continue
        if whole.startswith("*") and (keyword := _keyword(place, whole[1:])).name == "INCLUDE":
            yield from _included(keyword, path, top, depth)
        else:
            yield place, whole
    if begun is not None:
        yield begun


def _included(keyword: Keyword, path: Path, top: Path, depth: int) -> Iterator[tuple[str, str]]:
    """Lines of an included file.

    Raises:
        MeshError: it is not there, or files include each other.
    """
    file = path.parent / keyword.needed("INPUT")
    if depth == DEEPEST:
        raise keyword.wrong("is nested too deep: do files include each other?")
    if not file.is_file():
        raise keyword.wrong(f"names '{keyword.options['INPUT']}': there is no such file")
    yield from _lines(file, top, depth + 1)


def _keyword(line: str, text: str) -> Keyword:
    """A keyword from its line without the star."""
    name, *options = text.split(",")
    pairs = (option.partition("=") for option in options if option.strip())
    given = {"".join(key.split()).upper(): value.strip().strip("\"'") for key, _, value in pairs}
    return Keyword("".join(name.split()).upper(), given, line)


def numbers(line: str, text: str) -> list[float]:
    """Numbers of a line; an empty field is zero, Fortran's exponents are read.

    Raises:
        MeshError: something that is no number.
    """
    words = text.rstrip(",").split(",")
    try:
        return [float(word.upper().replace("D", "E")) if word.strip() else 0.0 for word in words]
    except ValueError:
        raise MeshError(f"{line}: '{text[:60]}' is not numbers with commas") from None


def whole_number(line: str, value: float) -> int:
    """A whole number.

    Raises:
        MeshError: it is none.
    """
    if not abs(value) < LARGEST or value != int(value):
        raise MeshError(f"{line}: {value:g} is not the number of a node or an element")
    return int(value)


def records(keyword: Keyword, size: int) -> Iterator[tuple[str, list[float]]]:
    """Lists of so many numbers, each with the line where it begins.

    Raises:
        MeshError: the last one is not whole, or a line goes on after the end of one.
    """
    begun: list[float] = []
    start = ""
    for line, text in keyword.data:
        start = start if begun else line
        begun += numbers(line, text)
        if len(begun) == size:
            yield start, begun
            begun = []
        elif len(begun) > size:
            break
    if begun:
        kind = keyword.options["TYPE"]
        raise MeshError(
            f"{start}: an element of type {kind} has {size - 1} nodes; found {len(begun) - 1}"
        )
