"""What pydantic found wrong with a scene, said in one sentence at the right place of the file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from typing import Any

from pydantic import ValidationError

from porous_swim.document import Document, KeyPath, Mark
from porous_swim.errors import SceneError
from porous_swim.parts import KeyedError, Part, models_in, tag_of


@dataclass(frozen=True)
class _Fault:
    path: KeyPath
    kind: str  # pydantic's type of the error
    sentence: str
    on_key: bool = False  # the key itself is wrong, or its absence

    def order(self, document: Document) -> tuple[bool, Mark]:
        """First in the file first; last what is missing, which a typing error elsewhere often explains."""
        return self.kind == "missing", document.place(self.path, on_key=self.on_key) or (0, 0)


def scene_error(error: ValidationError, *, model: type[Part], document: Document, inside: KeyPath = ()) -> SceneError:
    """Return the first fault in the order of the file; `inside` is where `model` stands in the document."""
    found: dict[KeyPath, list[_Fault]] = {}
    for item in error.errors():
        fault = _fault(item, model, document, inside)
        found.setdefault(fault.path, []).append(fault)
    faults = [_merged(group, document) for group in found.values()]
    wrong_entries = {fault.path[:-1] for fault in faults}  # they make their list look too short as well
    faults = [fault for fault in faults if fault.kind != "too_short" or fault.path not in wrong_entries]
    first = min(faults, key=lambda fault: fault.order(document))
    more = f" ({len(faults) - 1} more to mend)" if len(faults) > 1 else ""
    return document.error(first.path, first.sentence + more, on_key=first.on_key)


def shown(value: Any) -> str:
    """Return a value as a message shows it: short, and in the words of YAML."""
    if isinstance(value, dict):
        return "a map"
    if isinstance(value, (list, tuple)):
        return "a list"
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not isfinite(value):
        return f".{value}" if value > 0 or value != value else "-.inf"
    text = repr(value)
    return text if len(text) <= 40 else text[:36] + "..." + text[-1]


def near_miss(word: Any, choices: Sequence[str]) -> str:
    """Return `; did you mean ...?` where a choice is near to `word`, else nothing."""
    near = get_close_matches(str(word).lower(), choices, n=1, cutoff=0.67)  # two letters of three: another word
    return f"; did you mean `{near[0]}`?" if near else ""


def _fault(item: Any, model: type[Part], document: Document, inside: KeyPath) -> _Fault:
    kind, context = item["type"], item.get("ctx", {})
    path, value = _path(inside + tuple(item["loc"]), kind, document.data)
    cause = context.get("error")
    if isinstance(cause, KeyedError):
        return _Fault(path + tuple(cause.key.split(".")), kind, cause.sentence)
    if kind == "value_error":
        return _Fault(path, kind, str(cause))
    if kind == "missing":
        return _Fault(path, kind, _missing(path, _model_at(path[:-1], model, document.data, inside)), on_key=True)
    if kind == "extra_forbidden":
        owner = _model_at(path[:-1], model, document.data, inside)
        return _Fault(path, kind, _unknown(str(path[-1]), owner), on_key=True)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _tag_fault(path, kind, context, value)
    return _Fault(path, kind, _value_sentence(kind, context, value, item["msg"]))


def _path(location: KeyPath, kind: str, data: Any) -> tuple[KeyPath, Any]:
    """Return the path without the names of union members that pydantic weaves in, and the value there."""
    path: KeyPath = ()
    node = data
    for part in location:
        if isinstance(node, dict) and part in node:
            path, node = (*path, part), node[str(part)]
        elif isinstance(node, list) and isinstance(part, int) and part < len(node):
            path, node = (*path, part), node[part]
    if kind == "missing":
        return (*path, location[-1]), None
    return path, node


def _model_at(path: KeyPath, model: type[Part], data: Any, inside: KeyPath) -> type[Part]:
    node = data
    for depth, part in enumerate(path):
        node = node[part]
        if depth < len(inside):
            continue
        members = models_in(model.model_fields[str(part)].annotation)
        if len(members) > 1:
            tags = {member: tag_of(member) for member in members}
            members = [member for member, tag in tags.items() if tag and node.get(tag[0], "uniform") == tag[1]]
        model = members[0]
    return model


def _missing(path: KeyPath, owner: type[Part]) -> str:
    description = owner.model_fields[str(path[-1])].description if str(path[-1]) in owner.model_fields else None
    what = f" ({description.split('. ')[0].rstrip('.')})" if description else ""
    return f"this key is required and missing{what}"


def _unknown(key: str, owner: type[Part]) -> str:
    allowed = list(owner.model_fields)
    tag = tag_of(owner)
    where = f" with {tag[0]}: {tag[1]}" if tag else ""
    return f"unknown key{near_miss(key, allowed) or ';'} allowed{where}: {', '.join(allowed)}"


def _tag_fault(path: KeyPath, kind: str, context: Any, value: Any) -> _Fault:
    key = context["discriminator"].strip("'")
    if kind == "union_tag_not_found":
        return _Fault(
            (*path, key),
            "missing",
            "this key is required and missing; it says which other keys there are",
            on_key=True,
        )
    found = value[key]
    return _Fault((*path, key), kind, _choice_sentence(re.findall(r"'([^']*)'", context["expected_tags"]), found))


def _choice_sentence(choices: Sequence[str], found: Any) -> str:
    words = [f"`{choice}`" for choice in choices]
    allowed = " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
    return f"expected {allowed}, found {shown(found)}{near_miss(found, [str(choice) for choice in choices])}"


def _merged(group: list[_Fault], document: Document) -> _Fault:
    """Return one fault for a value that no member of a union accepts."""
    words = [fault for fault in group if fault.kind == "literal_error"]
    others = [fault for fault in group if fault.kind != "literal_error"]
    if not words or not others:
        return group[0]
    value = _path(group[0].path, "", document.data)[1]
    if isinstance(value, str) and not re.match(r"\s*[-+.0-9]", value):
        joint = ", " if " or " in words[0].sentence.partition(", found")[0] else " or "
        sentence = words[0].sentence.replace("expected ", f"expected a number{joint}", 1)
        return _Fault(group[0].path, "literal_error", sentence)
    return others[0]


_EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "tuple_type": "a list",
    "model_type": "a map of keys",
    "model_attributes_type": "a map of keys",
    "finite_number": "a finite number",
    "string_pattern_mismatch": "letters, digits, `.`, `_` and `-`, beginning with a letter or digit",
    "string_too_long": "at most {max_length} characters",
    "string_too_short": "at least {min_length} character",
    "greater_than": "more than {gt}",
    "greater_than_equal": "at least {ge}",
    "less_than": "less than {lt}",
    "less_than_equal": "at most {le}",
    "too_short": "at least {min_length} entries",
    "too_long": "at most {max_length} entries",
}


def _value_sentence(kind: str, context: Any, value: Any, message: str) -> str:
    if kind == "literal_error":
        return _choice_sentence(_choices(context), value)
    if kind not in _EXPECTED:
        return f"{message}, found {shown(value)}"
    found = f"{context['actual_length']}" if kind in ("too_short", "too_long") else shown(value)
    bounds = {name: f"{bound:g}" if isinstance(bound, float) else bound for name, bound in context.items()}
    return f"expected {_EXPECTED[kind].format(**bounds)}, found {found}"


def _choices(context: Any) -> list[str]:
    return [word or number for word, number in re.findall(r"'([^']*)'|\b(\d+)\b", context["expected"])]
