"""What pydantic found wrong with a scene, said in one sentence at the right place of the file."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from typing import Annotated, Any

from pydantic import TypeAdapter, ValidationError

from porous_swim.core.errors import SceneError
from porous_swim.core.parts import UNITS_UNKNOWN, KeyedError, Part, SeveralKeyedError
from porous_swim.core.registry import models_in, tag_of
from porous_swim.scene.document import UNREAD, Document, KeyPath, Mark, key_path

_MOST_SAID = 1000  # faults that get a sentence; more than these are not counted either
_LONGEST_WORD = 60  # letters of a word for which a near one is sought


@dataclass(frozen=True)
class Fault:
    """What is wrong at one key; without a sentence where that is said elsewhere."""

    path: KeyPath
    kind: str  # pydantic's type of the error
    sentence: str
    on_key: bool = False  # the key itself is wrong, or its absence

    def order(self, document: Document) -> tuple[bool, Mark]:
        """First in the file first; last what is missing, which a typing error elsewhere often explains."""
        return self.kind == "missing", document.place(self.path, on_key=self.on_key) or (0, 0)


def faults_of(error: ValidationError, *, model: type[Part], document: Document) -> list[Fault]:
    """Return what pydantic found wrong with `document`, one fault for each key."""
    found: dict[KeyPath, list[Fault]] = {}
    items = error.errors(include_url=False)[:_MOST_SAID]  # a file may have 10^5, and each takes a sentence
    for item in items:
        for fault in _faults(item, model, document):
            found.setdefault(fault.path, []).append(fault)
    faults = [_merged(group, document) for group in found.values()]
    wrong_entries = {fault.path[:-1] for fault in faults}  # they make their list look too short as well
    return [fault for fault in faults if fault.kind != "too_short" or fault.path not in wrong_entries]


def keyed_fault(error: KeyedError, *, above: KeyPath = (), kind: str = "value_error") -> Fault:
    """Return what a `KeyedError` says of a key below `above`."""
    return Fault(above + key_path(error.key), kind, error.sentence)


def scene_error(faults: Sequence[Fault], document: Document) -> SceneError:
    """Return one error with a line for each fault, in the order of the file, what is missing last.

    What is wrong with the document as YAML comes with them.
    """
    lines = [
        (fault.order(document), document.line(fault.path, fault.sentence, on_key=fault.on_key))
        for fault in faults
        if fault.sentence
    ]
    lines += [((False, mark), line) for mark, line in document.faults]
    return document.together([line for _, line in sorted(lines, key=lambda each: each[0])])


def sound_part(
    model: type[Part], data: Mapping[str, Any], faults: Sequence[Fault], *, context: Any, path: KeyPath = ()
) -> Any:
    """Return a `model` of those keys of `data` in which nothing is wrong, and of defaults; it lacks the others."""
    found = {}
    for name, field in model.model_fields.items():
        here = (*path, name)
        inside = [fault for fault in faults if fault.path[: len(here)] == here]
        if name not in data and not field.is_required():
            found[name] = field.get_default()
        elif name in data and not inside:
            adapter: TypeAdapter[Any] = TypeAdapter(Annotated[field.annotation, field])  # type: ignore[arg-type]
            found[name] = adapter.validate_python(data[name], context=context)
        elif name in data and all(len(fault.path) > len(here) for fault in inside) and isinstance(data[name], Mapping):
            inner = _members(models_in(field.annotation), data[name])
            if len(inner) == 1:
                found[name] = sound_part(inner[0], data[name], faults, context=context, path=here)
    part = model.model_construct(**found)
    for name in set(model.model_fields) - set(found):  # a default that pydantic put in place of what is wrong
        part.__dict__.pop(name, None)
    return part


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
    text = repr(value[:50] if isinstance(value, (str, bytes)) else value)
    return text if len(text) <= 40 else text[:36] + "..." + text[-1]


def near_miss(word: Any, choices: Sequence[str]) -> str:
    """Return `; did you mean ...?` where a choice is near to `word`, else nothing."""
    if len(str(word)) > _LONGEST_WORD:
        return ""
    near = get_close_matches(str(word).lower(), choices, n=1, cutoff=0.67)  # two letters of three: another word
    return f"; did you mean `{near[0]}`?" if near else ""


def _faults(item: Any, model: type[Part], document: Document) -> list[Fault]:
    """Return what an item of pydantic's list says: several faults where a section found several itself."""
    kind = item["type"]
    path, value = _path(tuple(item["loc"]), kind, document.data)
    cause = item.get("ctx", {}).get("error")
    if value is UNREAD or kind == UNITS_UNKNOWN:  # is said already
        return [Fault(path, kind, "")]
    if isinstance(cause, SeveralKeyedError):
        return [keyed_fault(each, above=path, kind=kind) for each in cause.errors]
    if isinstance(cause, KeyedError):
        return [keyed_fault(cause, above=path, kind=kind)]
    return [_fault(item, path, value, model, document)]


def _fault(item: Any, path: KeyPath, value: Any, model: type[Part], document: Document) -> Fault:
    kind, context = item["type"], item.get("ctx", {})
    if kind == "value_error":
        return Fault(path, kind, str(context["error"]))
    if kind == "missing":
        return Fault(path, kind, _missing(path, _model_at(path[:-1], model, document.data)), on_key=True)
    if kind == "extra_forbidden":
        owner = _model_at(path[:-1], model, document.data)
        return Fault(path, kind, _unknown(str(path[-1]), owner), on_key=True)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _tag_fault(path, kind, context, value)
    return Fault(path, kind, _value_sentence(kind, context, value, item["msg"]))


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


def _model_at(path: KeyPath, model: type[Part], data: Any) -> type[Part]:
    node, members = data, [model]
    for part in path:
        node = node[part]
        if isinstance(part, str):
            members = models_in(model.model_fields[part].annotation)
        if not isinstance(node, list):  # else the part is one of its entries
            model = _members(members, node)[0]
    return model


def _members(members: list[type[Part]], node: Any) -> list[type[Part]]:
    """Return the one of a union's members that the tag in `node` names, if there is one; a single model as it is."""
    if len(members) < 2:
        return members
    tags = {member: tag_of(member) for member in members}
    return [member for member, tag in tags.items() if tag and node.get(tag[0], "uniform") == tag[1]]


def _missing(path: KeyPath, owner: type[Part]) -> str:
    description = owner.model_fields[str(path[-1])].description if str(path[-1]) in owner.model_fields else None
    what = f" ({description.split('. ')[0].rstrip('.')})" if description else ""
    return f"this key is required and missing{what}"


def _unknown(key: str, owner: type[Part]) -> str:
    allowed = list(owner.model_fields)
    tag = tag_of(owner)
    where = f" with {tag[0]}: {tag[1]}" if tag else ""
    return f"unknown key{near_miss(key, allowed) or ';'} allowed{where}: {', '.join(allowed)}"


def _tag_fault(path: KeyPath, kind: str, context: Any, value: Any) -> Fault:
    key = context["discriminator"].strip("'")
    if kind == "union_tag_not_found":
        return Fault(
            (*path, key),
            "missing",
            "this key is required and missing; it says which other keys there are",
            on_key=True,
        )
    found = value[key]
    return Fault((*path, key), kind, _choice_sentence(re.findall(r"'([^']*)'", context["expected_tags"]), found))


def _choice_sentence(choices: Sequence[str], found: Any) -> str:
    words = [f"`{choice}`" for choice in choices]
    allowed = " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
    return f"expected {allowed}, found {shown(found)}{near_miss(found, [str(choice) for choice in choices])}"


def _merged(group: list[Fault], document: Document) -> Fault:
    """Return one fault for a value that no member of a union accepts."""
    words = [fault for fault in group if fault.kind == "literal_error"]
    others = [fault for fault in group if fault.kind != "literal_error"]
    if not words or not others:
        return group[0]
    value = _path(group[0].path, "", document.data)[1]
    if isinstance(value, str) and not re.match(r"\s*[-+.0-9]", value):
        joint = ", " if " or " in words[0].sentence.partition(", found")[0] else " or "
        sentence = words[0].sentence.replace("expected ", f"expected a number{joint}", 1)
        return Fault(group[0].path, "literal_error", sentence)
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
    unit = " (in a, U and a/U)" if isinstance(value, str) and {"gt", "ge", "lt", "le"} & set(context) else ""
    return f"expected {_EXPECTED[kind].format(**bounds)}{unit}, found {found}"


def _choices(context: Any) -> list[str]:
    return [word or number for word, number in re.findall(r"'([^']*)'|\b(\d+)\b", context["expected"])]
