"""Broken and odd case files: what people, editors and scripts do to files that were right."""

import copy
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from fuzz.toml_text import dumps
from hypothesis import strategies as st

Raw = dict[str, Any]
Draw = Callable[[st.SearchStrategy[Any]], Any]
Place = tuple[Any, str | int]  # a table or list, and a key or index in it

ODD = tomllib.loads(Path(__file__).with_name("oddities.toml").read_text())
KINDS = ("texts", "quantities", "numbers", "others")
odd_values = st.one_of([st.sampled_from(ODD[kind]).map(copy.deepcopy) for kind in KINDS])


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
        name = draw(st.sampled_from((f"{key}s", key[:-1], key.upper(), f" {key}", *ODD["texts"])))
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
def mutated(draw: Draw, bases: tuple[Path, ...], most: int = 4) -> Raw:
    """Contents of a case file with one or more changes."""
    raw = tomllib.loads(draw(st.sampled_from(bases)).read_text())
    for _ in range(draw(st.integers(1, most))):
        if draw(st.integers(0, 4)) == 0:
            [(key, value)] = draw(st.sampled_from(ODD["snippets"])).items()
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
