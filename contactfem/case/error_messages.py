"""Messages for mistakes in a case file."""

import json
import re
from collections.abc import Iterable, Sequence
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from contactfem.common.text import nearest, one_line, similar

# what people write, and what it is called here
SYNONYMS = {
    "slave": ("nonmortar",),
    "master": ("mortar",),
    "E": ("youngs_modulus",),
    "nu": ("poisson_ratio",),
    "K": ("bulk_modulus",),
    "G": ("shear_modulus",),
    "mu": ("coefficient", "shear_modulus"),
    "friction_coefficient": ("coefficient",),
    "dt": ("step",),
}
PLAIN = {
    "greater_than": "must be > {gt:g}",
    "greater_than_equal": "must be >= {ge:g}",
    "less_than": "must be < {lt:g}",
    "less_than_equal": "must be <= {le:g}",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "dict_type": "must be a table",
    "tuple_type": "must be a list",
    "too_short": "must have at least {min_length} entries, has {actual_length}",
    "too_long": "must have at most {max_length} entries, has {actual_length}",
    "string_type": "must be a text in quotes",
    "float_type": "must be a plain number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "finite_number": "must be a finite number",
}
# errors about the key that tells which of several tables is meant, and that key
TAGS = {
    "mesh_builder": "builder",
    "union_tag_not_found": "shape",
    "union_tag_invalid": "shape",
}
# errors that another one has led to: newer pydantic tells which defaults it could not work out
CONSEQUENCES = ("default_factory_not_called",)
NAME = "must be a name of letters, digits, '_' and '-'"


def error_lines(error: ValidationError, model: type[BaseModel], raw: object) -> list[str]:
    """One line for each mistake.

    Args:
        error: what pydantic found.
        model: the model that was to be made.
        raw: the data that it was to be made from.

    Returns:
        The lines, without the file's name.
    """
    found = [d for d in error.errors(include_url=False) if d["type"] not in CONSEQUENCES]
    return [one_line(_line(details, model, raw)) for details in found]


def allowed_keys(kind: Any, keys: Sequence[str | int], raw: object) -> list[str]:
    """Keys that a table may have.

    Args:
        kind: type of the outermost table.
        keys: way to the table.
        raw: data of the outermost table; tells which of several tables is meant.

    Returns:
        The keys; empty where any name is allowed.
    """
    origin = get_origin(kind)
    if origin is Annotated:
        return allowed_keys(get_args(kind)[0], keys, raw)
    if origin in (Union, UnionType):
        return [key for part in get_args(kind) for key in allowed_keys(part, keys, raw)]
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return _model_keys(kind, keys, raw)
    if origin in (dict, tuple, list) and keys:
        item = get_args(kind)[1 if origin is dict else 0]
        return allowed_keys(item, keys[1:], _item(raw, keys[0]))
    return []


def _model_keys(model: type[BaseModel], keys: Sequence[str | int], raw: object) -> list[str]:
    fields = model.model_fields
    for name, field in fields.items():
        if get_origin(field.annotation) is Literal and isinstance(raw, dict) and name in raw:
            if raw[name] not in get_args(field.annotation):
                return []  # another member of a union is meant
    if not keys:
        return [name for name in fields if name != "path"]
    if keys[0] not in fields:
        return []
    return allowed_keys(fields[str(keys[0])].annotation, keys[1:], _item(raw, keys[0]))


def _item(raw: object, key: str | int) -> object:
    """Item of a table or a list, None if there is none."""
    if isinstance(raw, dict):
        return raw.get(key)
    if isinstance(raw, list) and isinstance(key, int) and key < len(raw):
        return raw[key]
    return None


def _line(details: ErrorDetails, model: type[BaseModel], raw: object) -> str:
    kind, found = details["type"], details["input"]
    keys = _real_keys(details["loc"], raw, kind == "missing")
    if kind in TAGS:
        return _tag_line(keys, TAGS[kind], details)
    where = _dotted(keys)
    if kind == "extra_forbidden":
        return f"{where}: unknown key{_hint(str(keys[-1]), allowed_keys(model, keys[:-1], raw))}"
    if kind == "missing":
        return f"{where}: is missing"
    shown = _shown(_written(keys, raw, found)) if details["loc"][-1:] != ("[key]",) else ""
    return f"{where}{f' = {shown}' if shown else ''}: {_message(details)}"


def _tag_line(keys: list[str | int], tag: str, details: ErrorDetails) -> str:
    """Line about the key that tells which of several tables is meant."""
    if details["type"] == "union_tag_not_found":
        return f"{_dotted([*keys, tag])}: is missing"
    found = details["input"].get(tag)
    choices = details.get("ctx", {}).get("expected_tags", "").replace("'", "").split(", ")
    text = details["msg"] if choices == [""] else f"must be one of {', '.join(choices)}"
    known = choices if choices != [""] else text.rpartition("one of ")[2].split(", ")
    shown = "" if found is None else f" = {_shown(found)}"
    return f"{_dotted([*keys, tag])}{shown}: {text}{_near(found, known)}"


def _dotted(keys: Iterable[str | int]) -> str:
    """Key as it would stand in the file."""
    bare = re.compile(r"[A-Za-z0-9_-]+")
    texts = [str(key) for key in keys]
    return ".".join(t if bare.fullmatch(t) else json.dumps(t, ensure_ascii=False) for t in texts)


def _message(details: ErrorDetails) -> str:
    """What is allowed."""
    kind, context = details["type"], details.get("ctx", {})
    if kind in PLAIN:
        return PLAIN[kind].format(**context).replace("'", "")
    if kind == "string_pattern_mismatch":
        return NAME if details["loc"][-1] == "[key]" else _pattern(details)
    text = details["msg"]
    if kind == "literal_error":
        words = str(context["expected"]).replace(" or ", ", ").replace("'", "")
        choices = words.replace("False", "false").split(", ")
        if len(choices) == 1:
            return f"must be {choices[0]}"
        return f"must be one of {', '.join(choices)}{_near(details['input'], choices)}"
    if kind == "value_error":
        text = str(context["error"])
    text = text.replace("Input should be ", "must be ")
    return text.splitlines()[0]


def _pattern(details: ErrorDetails) -> str:
    """Names that are allowed beside a user's function, which is how all our patterns end."""
    names = re.findall(r"(?<=[(|])[a-z-]+(?=\|)", details["ctx"]["pattern"])
    listed = f"one of {', '.join(names)}" if len(names) > 1 else f"'{names[0]}'"
    return f"must be {listed} or 'file.py:function'{_near(details['input'], names)}"


def _real_keys(loc: Iterable[str | int], raw: object, missing: bool) -> list[str | int]:
    """Keys that stand in the file; pydantic's also name the members of unions."""
    keys: list[str | int] = []
    rest = [key for key in loc if key != "[key]"]
    for place, key in enumerate(rest):
        inside = isinstance(raw, dict) and key in raw
        if inside and place < len(rest) - 1 and not isinstance(raw[key], dict | list):  # type: ignore[index]
            continue  # a union's "file", not the key of that name
        if inside or (isinstance(raw, list) and isinstance(key, int) and key < len(raw)):
            keys.append(key)
            raw = raw[key]  # type: ignore[index]
        elif missing and place == len(rest) - 1:
            keys.append(key)
        elif isinstance(raw, list) and key in ("x", "y", "z"):
            keys.append("xyz".index(str(key)))
            raw = raw["xyz".index(str(key))]
    return keys


def _written(keys: Iterable[str | int], raw: object, found: object) -> object:
    """Quantity as it stands in the file, where what was found is its number in SI."""
    for key in keys:
        raw = raw[key]  # type: ignore[index]
    return raw if isinstance(raw, str) and isinstance(found, float) else found


def _hint(name: str, names: list[str]) -> str:
    for meant in SYNONYMS.get(name, ()):
        if meant in names:
            return f"; did you mean '{meant}'?"
    return nearest(name, names)


def _near(found: object, choices: list[str]) -> str:
    return similar(found, choices) if isinstance(found, str) else ""


def _shown(found: object) -> str:
    """A short value as it stands in the file; nothing for tables and long ones."""
    if isinstance(found, dict) or found is None:
        return ""
    text = found if isinstance(found, str) else json.dumps(found, default=str)
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:57]}..."
