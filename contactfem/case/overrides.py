"""Variants of a case file, and values changed by `--set`."""

import json
import tomllib
from typing import Any

from contactfem.common.text import nearest
from contactfem.errors import CaseError

Raw = dict[str, Any]


def override(raw: Raw, text: str) -> Raw:
    """Contents of a case file with one value changed.

    Args:
        raw: contents as TOML gives them; left as they are.
        text: "a.b.c=value"; the value is TOML, or else a string.

    Returns:
        The changed contents.

    Raises:
        CaseError: not of this form, or no such place.
    """
    key, sign, value = text.partition("=")
    if not sign or not key.strip():
        raise CaseError(f"--set {text}: must be of the form a.b.c=value")
    try:
        change = tomllib.loads(f"{key} = {value}")
    except ValueError:
        try:
            change = tomllib.loads(f"{key} = {json.dumps(value.strip())}")
        except ValueError:
            raise CaseError(f"--set {text}: '{key.strip()}' is not a dotted key") from None
    merged: Raw = _merged(raw, change, "")
    return merged


def with_variant(raw: Raw, name: str) -> Raw:
    """Contents of a case file with a variant's changes.

    Its `expect` is added to the base's, or replaces it if the variant says `base_expect = false`.

    Args:
        raw: contents as TOML gives them; left as they are.
        name: one of `raw["variants"]`.

    Returns:
        The changed contents.

    Raises:
        CaseError: no such variant, or it changes something that cannot be changed.
    """
    variants = raw.get("variants", {})
    if not isinstance(variants, dict) or not isinstance(variants.get(name), dict):
        names = list(variants) if isinstance(variants, dict) else []
        raise CaseError(f"variants: there is no '{name}'{nearest(name, names)}")
    changes = dict(variants[name])
    where = f"variants.{name}."
    expect = changes.pop("expect", {})
    keep = changes.pop("base_expect", True)
    if not isinstance(keep, bool) or not isinstance(expect, dict):
        raise CaseError(
            f"{where}{
                'expect: must be a table'
                if isinstance(keep, bool)
                else 'base_expect: must be true or false'
            }"
        )
    for key, value in changes.items():
        raw = _merged(raw, _nested(key, value, where), where)
    base = raw.get("expect", {}) if keep else {}
    return {**raw, "expect": {**base, **expect} if isinstance(base, dict) else base}


def _nested(key: str, value: Any, where: str) -> Raw:
    """Tables that a dotted key stands for, around its value."""
    try:
        change = tomllib.loads(f"{key} = 0")
    except ValueError:
        raise CaseError(f"{where}{key}: is not a dotted key") from None
    inner = change
    while isinstance(step := next(iter(inner.values())), dict):
        inner = step
    inner[next(iter(inner))] = value
    return change


def _merged(old: Any, new: Any, where: str) -> Any:
    """New values laid over old ones; another geometry's table replaces the old one."""
    if not isinstance(new, dict) or not isinstance(old, dict | list):
        return new
    if isinstance(old, list):
        return _list_merged(old, new, where)
    if _replaces(old, new):
        return new
    merged = _without_other_sides(old, new)
    for key, value in new.items():
        merged[key] = _merged(old[key], value, f"{where}{key}.") if key in old else value
    return merged


def _without_other_sides(old: Raw, new: Raw) -> Raw:
    """Table of an interface, without what the new one says in another way.

    `between` takes the place of `nonmortar` and `mortar`. One of these takes that of `between`, and
    leaves the other side as it is.
    """
    left = dict(old)
    if "between" in new:
        left.pop("nonmortar", None)
        left.pop("mortar", None)
    elif "between" in old and new.keys() & {"nonmortar", "mortar"}:
        pair = left.pop("between")
        for key, opposite in (("nonmortar", "mortar"), ("mortar", "nonmortar")):
            if isinstance(pair, list) and len(pair) == 2 and new.get(key) in pair:
                left[opposite] = pair[1 - pair.index(new[key])]
    return left


def _replaces(old: Raw, new: Raw) -> bool:
    """Whether a table is another geometry: one with a builder, or a file where none was.

    Another file has the other keys of the old one, unless its table says its unit as well: that is
    a whole one.
    """
    if not isinstance(old.get("builder", old.get("file")), str):
        return False
    if "file" in new and "builder" not in new and isinstance(old.get("file"), str):
        return "unit" in new
    return bool(new.keys() & {"builder", "file"})


def _list_merged(old: list[Any], new: Raw, where: str) -> list[Any]:
    """List with some items changed; the index after the last one appends.

    Items of short lists, which may be components, are also found by x, y and z.
    """
    merged = list(old)
    for name, value in new.items():
        key = str("xyz".index(name)) if name in ("x", "y", "z") else name
        if not key.isascii() or not key.isdigit() or int(key) > len(merged):
            raise CaseError(f"{where}{name}: must be an index from 0 to {len(merged)}")
        if int(key) == len(merged):
            merged.append(value)
        else:
            merged[int(key)] = _merged(merged[int(key)], value, f"{where}{key}.")
    return merged
