"""YAML 1.2 in its core schema, read into nodes with marks and written back, with PyYAML's own machinery.

PyYAML's resolver is YAML 1.1: there `1e-3` is a word, `no` is false, `010` is eight and `2:30` is 150.
"""

from __future__ import annotations

import re
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.emitter import Emitter
from yaml.nodes import Node
from yaml.parser import Parser
from yaml.reader import Reader
from yaml.representer import SafeRepresenter
from yaml.resolver import BaseResolver
from yaml.scanner import Scanner
from yaml.serializer import Serializer

TAG = "tag:yaml.org,2002:"


def compose(text: str) -> Node | None:
    """Return the nodes of the one document in `text`, None where it is empty; raises `yaml.YAMLError`."""
    return _Loader(text).get_single_node()


def write_yaml(data: dict[str, Any]) -> str:
    """Return plain data as YAML text in the order of its keys; lists of scalars on one line."""
    return str(yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True))


class _CoreResolver(BaseResolver):
    """The core schema of YAML 1.2 in place of PyYAML's YAML 1.1."""


for _name, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", list("-+0123456789")),
    (
        "float",
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        list("-+.0123456789"),
    ),
):
    _CoreResolver.add_implicit_resolver(TAG + _name, re.compile(rf"^(?:{_pattern})$"), _first)


class _Loader(Reader, Scanner, Parser, Composer, _CoreResolver):
    """PyYAML's own reader up to nodes, with marks; nothing is constructed."""

    def __init__(self, text: str):
        Reader.__init__(self, text)
        Scanner.__init__(self)
        Parser.__init__(self)
        Composer.__init__(self)
        _CoreResolver.__init__(self)

    def compose_node(self, parent: Node | None, index: int) -> Node | None:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
            raise yaml.MarkedYAMLError(
                problem="anchors (&) and aliases (*) are not supported; write the value out",
                problem_mark=event.start_mark,
            )
        return super().compose_node(parent, index)


class _Dumper(Emitter, Serializer, SafeRepresenter, _CoreResolver):
    """PyYAML's safe dumper, which quotes the words that the core schema would take for something else."""

    def __init__(
        self,
        stream: Any,
        *,
        default_flow_style: Any,
        sort_keys: bool,
        width: int,
        allow_unicode: bool,
        **_: Any,
    ):
        Emitter.__init__(self, stream, width=width, allow_unicode=allow_unicode)
        Serializer.__init__(self)
        SafeRepresenter.__init__(self, default_flow_style=default_flow_style, sort_keys=sort_keys)
        _CoreResolver.__init__(self)


def _read_int(text: str) -> int:
    if len(text) > 400:  # digits: no float is as large
        raise ValueError("too many digits")
    return int(text, 0) if text[:2] in ("0o", "0x") else int(text)


def _read_float(text: str) -> float:
    return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))


SCALARS: dict[str, Any] = {
    "null": lambda text: None,
    "bool": lambda text: {"true": True, "false": False}[text.lower()],
    "int": _read_int,
    "float": _read_float,
    "str": str,
}
