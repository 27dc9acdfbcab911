"""All values of a case in SI, defaults included."""

from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel

from contactfem.common.place_time import Profile
from contactfem.common.time_table import Table
from contactfem.common.units import Quantity, TableOf
from contactfem.common.user_function import FunctionRef


def listing(model: BaseModel, prefix: str = "") -> Iterator[tuple[str, str, bool]]:
    """Dotted keys with their values in SI.

    Args:
        model: a case or one of its tables.
        prefix: where it stands.

    Yields:
        Key, value with unit, and whether the value is a default.
    """
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        unit = next(filter(None, map(_mark, field.metadata)), "") or _unit(field.annotation)
        default = name not in model.model_fields_set
        for key, text, inner in _lines(f"{prefix}{name}", value, unit):
            yield key, text, default or inner


def _unit(kind: Any) -> str:
    """SI unit of a type, "" if it has none."""
    if get_origin(kind) is Annotated:
        inner, *marks = get_args(kind)
        return next(filter(None, map(_mark, marks)), "") or _unit(inner)
    if get_origin(kind) in (Union, UnionType, dict, tuple):
        return next(filter(None, map(_unit, get_args(kind))), "")
    return ""


def _mark(mark: object) -> str:
    return mark.symbol if isinstance(mark, Quantity | TableOf) else ""


def _lines(key: str, value: object, unit: str) -> Iterator[tuple[str, str, bool]]:
    if isinstance(value, BaseModel):
        yield from listing(value, f"{key}.")
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from _lines(f"{key}.{name}", item, unit)
    elif isinstance(value, tuple) and value and isinstance(value[0], BaseModel):
        for number, item in enumerate(value):
            yield from listing(item, f"{key}.{number}.")
    elif value is not None and value != ():
        yield key, _text(value, unit), False


def _text(value: object, unit: str) -> str:
    """One value with its unit."""
    if isinstance(value, Table):
        if not value.times:
            return _text(value.values[0], unit)
        rows = zip(value.times, value.values, strict=True)
        return ", ".join(f"{_text(v, unit)} at {t:g} s" for t, v in rows)
    if isinstance(value, Profile):
        rows = zip(value.values, value.places, strict=True)
        over = ", ".join(f"{_text(v, unit)} at {'xyz'[value.axis]} = {x:g} m" for v, x in rows)
        return f"{over}; times {_text(value.factor, '')}"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.8g} {unit}".rstrip()
    if isinstance(value, tuple):
        return f"({', '.join(_text(item, '') for item in value)}) {unit}".rstrip()
    return str(value) if isinstance(value, int | str | Path | FunctionRef) else repr(value)
