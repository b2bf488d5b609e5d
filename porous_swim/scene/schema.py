"""The scene's reference page and JSON Schema, from the models: `python -m porous_swim.scene.schema`."""

from __future__ import annotations

import json
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic.fields import FieldInfo

from porous_swim.core.parts import Part, Unit
from porous_swim.core.registry import models_in, skip_plugins, tag_of
from porous_swim.scene.scene import Scene

SCHEMA_FILE = Path(__file__).with_name("scene.schema.json")
PAGE_FILE = Path(__file__).parents[2] / "docs" / "scene.md"

_HEADER = """# The scene file

<!-- Written by `python -m porous_swim.scene.schema` from the models; do not edit. -->

A scene is a YAML 1.2 file: a map of the sections below. Numbers are dimensionless, in swimmer half-lengths a,
swimming speeds U and times a/U. With a `units` section a number that has a unit may also be a string such as
`10 um`, `0.5 s` or `0.19 rad^2/s`, and a diffusivity may be `thermal`, for a sphere kT/(6 pi mu a). Unknown and
duplicate keys are errors; so are anchors, aliases and tags.
"""


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a scene, for editors that check YAML while it is written."""
    schema = _bounded(Scene.model_json_schema())
    schema["required"].remove("name")  # it follows from the file's name
    # Exactly one of two: which, the models say.
    schema["$defs"]["Population"]["required"].remove("dipole_strength")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def scene_page() -> str:
    """Return the reference page: a table for each section and for each of its kinds."""
    lines = [_HEADER, "## Top level\n", *_table(Scene)]
    for name, field in Scene.model_fields.items():
        for model in models_in(field.annotation):
            lines += _section(name, model, alone=len(models_in(field.annotation)) == 1)
        lines += _inner_sections(name, models_in(field.annotation))
    return "\n".join(lines).rstrip() + "\n"


def write() -> None:
    """Write both files into the source tree."""
    SCHEMA_FILE.write_text(json.dumps(json_schema(), indent=1) + "\n", encoding="utf-8")
    PAGE_FILE.parent.mkdir(exist_ok=True)
    PAGE_FILE.write_text(scene_page(), encoding="utf-8")


def _bounded(node: Any) -> Any:
    """Return the schema with the bounds of quantities in its own words, at the number that they bound."""
    if isinstance(node, list):
        return [_bounded(item) for item in node]
    if not isinstance(node, dict):
        return node
    words = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
    bounds = {words[key]: node[key] for key in words if isinstance(node.get(key), (int, float))}
    rest = {key: _bounded(value) for key, value in node.items() if key not in words}
    for member in rest.get("anyOf", []):
        if member.get("type") in ("number", "integer"):
            member.update(bounds)
    return rest


def _inner_sections(name: str, models: list[type[Part]]) -> list[str]:
    return [
        line
        for model in models
        for key, field in model.model_fields.items()
        for inner in models_in(field.annotation)
        for line in _section(f"{name}.{key}", inner, alone=len(models_in(field.annotation)) == 1)
    ]


def _section(name: str, model: type[Part], *, alone: bool) -> list[str]:
    tag = tag_of(model)
    title = f"`{name}`" if alone or tag is None else f"`{name}` with `{tag[0]}: {tag[1]}`"
    sentence = (model.__doc__ or "").strip()
    return [f"\n## {title}\n", f"{sentence}\n", *_table(model)]


def _table(model: type[Part]) -> list[str]:
    fields = model.model_fields
    order = sorted(fields, key=lambda key: key not in ("kind", "layout"))
    rows = [f"| `{key}` | {_meaning(key, fields[key])} | {_unit(fields[key])} | {_allowed(fields[key])} | "
            f"{_default(fields[key])} |" for key in order]  # fmt: skip
    return ["| key | meaning | unit | allowed | default |", "|---|---|---|---|---|", *rows]


def _meaning(key: str, field: FieldInfo) -> str:
    text = field.description or ("Says which of the kinds this is." if key in ("kind", "layout") else "")
    return " ".join(text.split()).replace("|", "\\|")


def _unit(field: FieldInfo) -> str:
    units = [item.symbol for item in _metadata(field) if isinstance(item, Unit)]
    return units[0] if units else ""


def _metadata(field: FieldInfo) -> list[Any]:
    return [*field.metadata, *_flat(field.annotation)]


def _flat(annotation: Any) -> list[Any]:
    """Return what stands beside the types in an annotation, at any depth."""
    found: list[Any] = list(getattr(annotation, "__metadata__", ()))
    for item in list(found):
        if isinstance(item, FieldInfo):
            found += item.metadata
    for member in get_args(annotation):
        if get_origin(annotation) is not Literal:
            found += _flat(member)
    return found


def _allowed(field: FieldInfo) -> str:
    models = models_in(field.annotation)
    if models:
        tags = [tag for tag in map(tag_of, models) if tag is not None]
        return ", ".join(f"`{value}`" for _, value in tags) if tags else "a map"
    words = [f"`{value}`" for value in _literals(field.annotation)]
    text = _types(field.annotation)
    bounds = bounds_of(field)
    return ", ".join(part for part in (f"{text} {bounds}".strip(), *words) if part)


def _literals(annotation: Any) -> list[Any]:
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    return [value for member in get_args(annotation) for value in _literals(member)]


def _types(annotation: Any) -> str:
    names = {float: "number", int: "whole number", str: "text", bool: "true or false"}
    if annotation in names:
        return names[annotation]
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return "map"
    if get_origin(annotation) is tuple:
        return f"list of {_types(get_args(annotation)[0])}s"
    if annotation is NoneType or get_origin(annotation) is Literal:
        return ""
    members = [_types(member) for member in get_args(annotation) if member is not Ellipsis]
    return next((member for member in members if member), "")


def bounds_of(field: FieldInfo) -> str:
    """Return what a number may be, such as `>= 0 and <= 1`; empty where it has no bounds."""
    signs = {Gt: ("> {}", "gt"), Ge: (">= {}", "ge"), Lt: ("< {}", "lt"), Le: ("<= {}", "le")}
    found = []
    for item in _metadata(field):
        if type(item) in signs:
            sign, name = signs[type(item)]
            found.append(sign.format(_number(getattr(item, name))))
    return " and ".join(dict.fromkeys(found))


def _number(value: Any) -> str:
    if isinstance(value, int) and value >= 2**31 and value.bit_count() == 1:
        return f"2^{value.bit_length() - 1}"
    return f"{value:g}"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.default
    if isinstance(default, Part):
        tag = tag_of(type(default))
        return f"`{tag[1]}`" if tag else "as below"
    if default is None or default == "":
        return ""
    return f"`{list(default) if isinstance(default, tuple) else default}`"


if __name__ == "__main__":
    skip_plugins()
    write()
