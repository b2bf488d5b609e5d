"""Which parts of each role there are: our own, those that a program registers, those of installed plug-ins.

A role (`Layout`, `Release`, `Flow` ...) is a class directly below `OpenPart`. A field of a scene whose
type is a role takes any part registered for it; the part's tag in the file says which.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, reduce
from operator import or_
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_args, get_origin

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from porous_swim.core.console import tell
from porous_swim.core.parts import Part
from porous_swim.core.plugins import Plugin, load_installed, name_of


class OpenPart(Part):
    """A part that a scene chooses by a tag, and of which users may register kinds of their own."""

    TAG: ClassVar[str] = "kind"  # the key whose word chooses

    @classmethod
    def is_role(cls) -> bool:
        """Whether this class is a role, such as `Layout`, and no part itself."""
        return cls.__mro__[2] is Part  # itself, OpenPart, Part

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of a part as it is, and of a role one that looks among those registered by then."""
        if not cls.is_role():
            return handler(source)

        def choose(value: Any, info: ValidationInfo) -> Any:
            if not parts_of(cls):
                raise ValueError(f"no {cls.__name__} is registered, by a package that is installed or by a program")
            return _chooser(cls).validate_python(value, context=info.context)

        return core_schema.with_info_plain_validator_function(choose)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON Schema of a part, or of all that a role has by now."""
        if cls.is_role() and not parts_of(cls):
            return {"not": {}}  # nothing is one
        return handler(_chooser(cls).core_schema if cls.is_role() else schema)


AnyPart = TypeVar("AnyPart", bound=type[OpenPart])
Role = TypeVar("Role", bound=OpenPart)

_PARTS: dict[type[OpenPart], dict[str, type[OpenPart]]] = {}  # by role and tag, ours first
_PLUGINS: dict[type[OpenPart], Plugin] = {}
_ROLES = "Layout, Release, Flow, Motility or ObserverPart"
_still_to_load = {"plug-ins"}  # empty once they have been looked for


def role_of(part: type) -> type[OpenPart] | None:
    """Return the role that a part plays; None for what plays none."""
    return next((base for base in part.__mro__ if issubclass(base, OpenPart) and base.is_role()), None)


def add(*parts: type[OpenPart]) -> None:
    """Add parts of our own to their roles; a plug-in that was loaded before and has the word of one gives way."""
    for part in parts:
        role, (key, tag) = _checked(part)
        taken = _PARTS.get(role, {}).get(tag)
        if taken is not None and taken in _PLUGINS:
            tell(f"warning: {name_of(taken)} is left out: {key}: {tag} is a word of porous_swim's own", sys.stderr)
            forget(taken)
        _add(part)


def register(part: AnyPart) -> AnyPart:
    """Let scene files name `part`, a model derived from a role such as `Layout`; return it, as a decorator does.

    TypeError where `part` is no such model or lacks a method of its role; ValueError where its tag is taken.
    """
    _add(part)
    _PLUGINS[part] = Plugin.of(part)
    return part


def forget(part: type[OpenPart]) -> None:
    """Undo `register`."""
    role, (_, tag) = _checked(part)
    if _PARTS[role].get(tag) is part and part in _PLUGINS:
        del _PARTS[role][tag], _PLUGINS[part]


def parts_of(role: type[Role]) -> dict[str, type[Role]]:
    """Return all parts of a role by their tags: our own first, then those registered, and those of plug-ins."""
    _load_plugins()
    return dict(_PARTS.get(role, {}))  # type: ignore[arg-type]


def plugin_of(part: type) -> Plugin | None:
    """Return where a registered part comes from; None for our own."""
    return _PLUGINS.get(part)


def skip_plugins() -> None:
    """Leave installed plug-ins out of this process: for files that describe our own parts."""
    _still_to_load.clear()


def models_in(annotation: Any) -> list[type[Part]]:
    """Return the models that a field's annotation admits: one, all members of a union, or all parts of a role."""
    if isinstance(annotation, type) and issubclass(annotation, OpenPart) and annotation.is_role():
        return list(parts_of(annotation).values())
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return [annotation]
    if get_origin(annotation) is None:
        return []
    return [model for member in get_args(annotation) for model in models_in(member)]


def tag_of(model: type[Part]) -> tuple[str, str] | None:
    """Return the discriminator of a member of a union, as ("kind", "brownian"), or None."""
    for key in ("kind", "layout"):
        if key in model.model_fields:
            words = get_args(model.model_fields[key].annotation)
            return (key, words[0]) if words else None
    return None


def parts_in(part: Part) -> Iterator[Part]:
    """Yield a part and all parts that it holds, at any depth."""
    yield part
    for name in type(part).model_fields:
        value = getattr(part, name)
        for inner in value if isinstance(value, tuple) else (value,):
            if isinstance(inner, Part):
                yield from parts_in(inner)


def _add(part: type[OpenPart]) -> None:
    role, (key, tag) = _checked(part)
    taken = _PARTS.setdefault(role, {}).get(tag)
    if taken is not None and name_of(taken) != name_of(part):  # the same again: a notebook's cell was run twice
        raise ValueError(f"{name_of(part)}: {key}: {tag} is taken by {name_of(taken)}; choose another word")
    if taken is not None:
        _PLUGINS.pop(taken, None)
    _PARTS[role][tag] = part


def _checked(part: type[OpenPart]) -> tuple[type[OpenPart], tuple[str, str]]:
    role = role_of(part) if isinstance(part, type) else None
    if role is None or role is part:
        raise TypeError(f"register: expected a class derived from {_ROLES}, found {part!r}")
    tag = tag_of(part)
    field = part.model_fields.get(role.TAG)
    if tag is None or field is None or get_origin(field.annotation) is not Literal or tag[0] != role.TAG:
        raise TypeError(f'{name_of(part)}: expected the field `{role.TAG}: Literal["a_word"]`, which scene files name')
    missing = sorted(getattr(part, "__abstractmethods__", ()))
    if missing:
        needs = " and ".join(missing)
        raise TypeError(f"{name_of(part)}: a {role.__name__} needs {needs}; see porous_swim.{role.__name__}")
    return role, tag


def _chooser(role: type[OpenPart]) -> TypeAdapter[Any]:
    return _union(role.TAG, tuple(parts_of(role).values()))


@dataclass(frozen=True)
class _Lone:
    """A union of one part, which needs its tag like any other."""

    key: str
    part: type[OpenPart]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        _, tag = _checked(self.part)[1]
        return core_schema.tagged_union_schema({tag: handler.generate_schema(self.part)}, discriminator=self.key)


@cache
def _union(key: str, parts: tuple[type[OpenPart], ...]) -> TypeAdapter[Any]:
    if len(parts) > 1:
        union: Any = Annotated[reduce(or_, parts), Field(discriminator=key)]
        return TypeAdapter(union, config=Part.model_config)
    return TypeAdapter(Annotated[Any, _Lone(key, parts[0])], config=Part.model_config)  # pydantic unites two or more


def _load_plugins() -> None:
    if _still_to_load:
        _still_to_load.clear()  # before: a plug-in may itself ask for parts
        load_installed(_take)


def _take(part: type[OpenPart], plugin: Plugin) -> None:
    if part not in _PLUGINS:  # else its module has registered it
        _add(part)
    _PLUGINS[part] = plugin
