"""Reference of all keys: JSON schema and Markdown page."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from contactfem.case.schema import Case
from contactfem.common.unit_parser import DIMENSIONS
from contactfem.common.units import EXAMPLES, allowed
from contactfem.results import heat_measures as heat_measure
from contactfem.results import measures as measure

Schema = Mapping[str, Any]

TOP = "Case"
UNITS = {example: symbol for symbol, example in EXAMPLES.items()}
START = """\
# Keys of a case file

This page is generated: `contactfem schema --markdown` prints it, and `contactfem schema` the JSON
schema that editors complete and check case files with.

A case file is [TOML](https://toml.io), with paths relative to its folder. A quantity is a text
with a number and a unit, such as `"35 N/mm^2"`; any unit of the right dimension will do. Where a
value may change over time, rows of time and value stand for it:
`[["0 s", "0 mm"], ["1 s", "-2 mm"]]` is linear between the rows and constant after the last.
Components are named, `displacement.x = "1 mm"`, or listed. Every key may be changed for one run:
`--set time.end='"2 s"'` or `--set conditions.0.pressure='"1 MPa"'`; conditions count from 0.
"""


def case_schema() -> dict[str, Any]:
    """JSON schema of case files, in which a quantity's description ends with an example."""
    schema = Case.model_json_schema()
    for _, table in _tables(schema):
        for key, value in table.get("properties", {}).items():
            table["properties"][key] = _described(value)
    return schema


def _described(schema: Schema) -> dict[str, Any]:
    """A key's schema; a reference becomes a member, as many editors ignore what is beside it."""
    if "$ref" in schema:
        rest = {key: value for key, value in schema.items() if key != "$ref"}
        return {"allOf": [{"$ref": schema["$ref"]}], **rest}
    symbol = UNITS.get(str(schema.get("examples", [""])[0]))
    if symbol is None or schema.get("type") != "string":
        return dict(schema)
    return {**schema, "description": f"{schema['description']}: {allowed(symbol)}"}


def _tables(schema: Schema) -> Iterator[tuple[str, Any]]:
    yield TOP, schema
    yield from schema["$defs"].items()


def reference_page() -> str:
    """The page: a section for every table, in the order in which a case file names them."""
    schema = Case.model_json_schema()
    places: dict[str, str] = {}
    _find(TOP, "", dict(_tables(schema)), places)
    tables = dict(_tables(schema))
    sections = [_section(name, place, tables[name]) for name, place in places.items()]
    return "\n".join([START, *sections, _measurable()])


def _find(name: str, place: str, tables: Mapping[str, Schema], places: dict[str, str]) -> None:
    """Note where a table stands, and all tables below it."""
    places.setdefault(name, place)
    for key, schema in tables[name].get("properties", {}).items():
        named = "NAME" if "patternProperties" in schema or "additionalProperties" in schema else ""
        item = "0" if schema.get("type") == "array" else named
        new = [n for n in re.findall(r'"#/\$defs/(\w+)"', json.dumps(schema)) if n not in places]
        places |= dict.fromkeys(new, ".".join(part for part in (place, key, item) if part))
        for below in new:
            _find(below, places[below], tables, places)


def _section(name: str, place: str, table: Schema) -> str:
    """Title, words and rows of one table."""
    lines = [f"## {name}", ""]
    lines += [f"At `{place}`.", ""] if place else []
    lines += [table["description"], ""]
    required = table.get("required", ())
    lines += ["| key | value | if not given | |", "|---|---|---|---|"]
    for key, schema in table["properties"].items():
        default = "**required**" if key in required else _default(schema)
        lines.append(f"| `{key}` | {_value(schema)} | {default} | {schema['description']} |")
    return "\n".join(lines) + "\n"


def _measurable() -> str:
    """Section about the names that `expect` may use."""
    lines = [
        "## What can be expected",
        "",
        "Names of numbers for the keys of `expect`, with their SI units. Forces, energies and",
        "powers are per metre of depth in plane strain; in other dimensions they are not. The",
        "summary of a run has the values of all of them.",
        "",
        "| name | unit |",
        "|---|---|",
    ]
    groups: tuple[tuple[str, Mapping[str, str], str], ...] = (
        ("", measure.RUN_UNITS, ""),
        ("INTERFACE.", measure.INTERFACE_UNITS, ""),
        ("INTERFACE.", measure.CLOSED_FORM_UNITS, ""),
        ("BODY.", measure.BODY_UNITS, ".min` or `.max"),
        ("probe.", {"NAME": ""}, ""),
        ("", heat_measure.RUN_UNITS, ""),
        ("INTERFACE.", heat_measure.INTERFACE_UNITS, ""),
        ("BODY.", heat_measure.BODY_UNITS, ""),
        ("heat.held.", {"BODY.SURFACE": "J/m"}, ""),
    )
    for before, units, after in groups:
        lines += [f"| `{before}{name}{after}` | {unit} |" for name, unit in units.items()]
    return "\n".join(lines)


def _value(schema: Schema) -> str:
    """What may stand for a key, in words and examples."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    for key, words in (("anyOf", _choice), ("oneOf", _choice), ("allOf", _choice)):
        if key in schema:
            return words(schema[key])
    if "const" in schema:
        return _code(schema["const"])
    if "enum" in schema:
        return ", ".join(_code(value) for value in schema["enum"])
    return {
        "string": _text,
        "number": _number,
        "integer": _number,
        "boolean": lambda _: "`true` or `false`",
        "array": _list,
        "object": _object,
    }[schema["type"]](schema)


def _choice(schemas: list[Schema]) -> str:
    """Several kinds of values; rows over time are said shortly."""
    rows = [s for s in schemas if s.get("type") == "array" and "prefixItems" in s.get("items", {})]
    plain = [s for s in schemas if s not in rows and s.get("type") != "null"]
    if [s.get("type") for s in plain] == ["number", "string"]:
        return "number, or text with a unit"
    components = [s for s in plain if "x" in s.get("properties", {})]
    if components:
        return f"by component: {_value(components[0]['properties']['x'])}"
    said = " or ".join(_value(s) for s in plain)
    return f"{said}, also over time" if rows else said


def _text(schema: Schema) -> str:
    if ".py:" in schema.get("pattern", "").replace("\\", ""):
        names = re.findall(r"(?<=[(|])[a-z-]+(?=\|)", schema["pattern"])
        return ", ".join([*(_code(name) for name in names), '`"file.py:function"`'])
    if "examples" in schema:
        example = schema["examples"][0]
        kind = DIMENSIONS.get(UNITS.get(example, " "), "function" if ":" in example else "such as")
        return f"{kind} {_code(example)}"
    if "pattern" in schema:
        return "name"
    return "path" if schema.get("format") == "path" else "text"


def _number(schema: Schema) -> str:
    kind = "whole number" if schema["type"] == "integer" else "number"
    limits = {
        "exclusiveMinimum": ">",
        "minimum": "≥",
        "exclusiveMaximum": "<",
        "maximum": "≤",
    }
    said = [f"{sign} {schema[key]:g}" for key, sign in limits.items() if key in schema]
    return " ".join([kind, ", ".join(said)]).strip()


def _list(schema: Schema) -> str:
    if "prefixItems" in schema:
        items = schema["prefixItems"]
        examples = [_toml(item["examples"][0]) for item in items if "examples" in item]
        return f"`[{', '.join(examples)}]`" if examples else f"{len(items)} numbers"
    if "items" in schema:
        return f"list: {_value(schema['items'])}"
    return f"such as {_code(schema['examples'][0])}"


def _object(schema: Schema) -> str:
    inner = [*schema.get("patternProperties", {}).values()]
    inner += [schema["additionalProperties"]] if schema.get("additionalProperties") else []
    held = "table" if not inner or inner[0] is True else _value(inner[0])
    return "table" if held == "table" else f"by name: {held}"


def _default(schema: Schema) -> str:
    """Default as it would stand in a case file."""
    value = schema.get("default")
    if value is None or value in ([], {}):
        return ""
    example = schema.get("examples", [""])[0]
    if isinstance(value, float) and example in UNITS:
        return f'`"{value:g} {UNITS[example]}"`'
    return _code(value)


def _code(value: object) -> str:
    return f"`{_toml(value)}`".replace("|", "\\|")


def _toml(value: object) -> str:
    """A value as TOML has it."""
    return f"{value:g}" if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
