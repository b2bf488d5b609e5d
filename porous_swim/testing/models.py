"""What holds for the model of every part: it is described, frozen, and its mistakes are told at their keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import nan
from typing import Any

from pydantic import ValidationError

from porous_swim.core.errors import SceneError
from porous_swim.core.parts import Part
from porous_swim.core.registry import tag_of
from porous_swim.scene.scene import Scene
from porous_swim.scene.schema import bounds_of


def check_described(part: type[Part]) -> None:
    """Require a docstring of the class and of each field, as sentences, and bounds of each number."""
    _require_sentence(part.__dict__.get("__doc__"), part.__name__)
    tag, schema = tag_of(part), part.model_json_schema()
    for name, field in part.model_fields.items():
        if tag is None or name != tag[0]:
            _require_sentence(field.description, f"{part.__name__}.{name}")
        words = set(_words(schema["properties"][name]))
        if words & {"number", "integer"} and not words & {"boolean"}:
            assert bounds_of(field), f"{part.__name__}.{name}: a number without bounds, such as Field(gt=0.0, le=1e6)"


def check_keys(part: Part, given: Mapping[str, Any], load: Callable[[dict[str, Any]], Scene], *, key: str) -> None:
    """Require that mistakes in each key of `part` are told with its name; `load` makes a scene of `given`.

    `key` is where the part stands in a scene.
    """
    tag = tag_of(type(part))
    assert tag is not None, f"{type(part).__name__}: no field says which kind it is"
    for name in type(part).model_fields:
        if name == tag[0]:
            continue
        _expect(f"{key}.{name}x: unknown key; did you mean `{name}`?", load, {**given, f"{name}x": 1})
        for wrong in ({"a": 1}, nan):  # neither is a number, a word or a list
            _expect(f"{key}.{name}", load, {**given, name: wrong})
    word = f"{tag[1]}x"
    _expect(f"found '{word}'; did you mean `{tag[1]}`?", load, {**given, tag[0]: word})
    try:
        setattr(part, tag[0], tag[1])
    except ValidationError:
        return
    raise AssertionError(f"{type(part).__name__}: it can be changed; a part is frozen")


def _expect(sentence: str, load: Callable[[dict[str, Any]], Scene], data: dict[str, Any]) -> None:
    found = "none"
    try:
        load(data)
    except SceneError as error:
        found = str(error)
    assert sentence in found, f"expected an error with {sentence!r} for {data}, found {found}"


def _require_sentence(text: str | None, of: str) -> None:
    assert text, f"{of}: it has no docstring, which is its row in the reference"
    assert text.rstrip().endswith((".", "`")), f"{of}: its docstring ends without a full stop"


def _words(node: Any) -> list[str]:
    """Return all keys and words of a JSON Schema."""
    if isinstance(node, dict):
        return [word for key, value in node.items() for word in (key, *_words(value)) if key != "description"]
    if isinstance(node, list):
        return [word for item in node for word in _words(item)]
    return [node] if isinstance(node, str) else []
