"""A YAML file as plain data that remembers where each key and value stands.

Scalars follow the core schema of YAML 1.2: `1e-3` is a number, `no` is a word, `010` is ten.
Anchors, aliases, merge keys and tags are refused: a scene says everything where it stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import BaseModel
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from yaml.reader import ReaderError

from porous_swim.core.errors import SceneError
from porous_swim.scene.yaml_core import SCALARS, TAG, compose

KeyPath = tuple[str | int, ...]
Mark = tuple[int, int]  # line and column, from 1
UNREAD: Any = object()  # in place of a value that could not be read
_MOST_LINES = 10  # of one error
_MOST_SHOWN = 60  # letters of a value in a message
_LOOKED_AT = 20  # lines, by which a table is known
_MOST_BYTES = 1_000_000  # of a scene: lists of ten thousand radii take a tenth of it


@dataclass(frozen=True)
class Document:
    """Plain data (dict, list, str, int, float, bool, None) and where it stands in its file."""

    data: dict[str, Any]
    file: str | None = None  # as the user wrote it; None for data that came from Python
    keys: dict[KeyPath, Mark] = field(default_factory=dict)
    values: dict[KeyPath, Mark] = field(default_factory=dict)
    replaced: frozenset[KeyPath] = frozenset()  # given from outside the file: no place in it
    faults: list[tuple[Mark, str]] = field(default_factory=list)  # lines on what is wrong as YAML, by place

    def error(self, path: KeyPath, sentence: str, *, on_key: bool = False) -> SceneError:
        """Return the `SceneError` for `path`, placed at its value (or its key), else at what encloses it."""
        return SceneError(self.line(path, sentence, on_key=on_key))

    def line(self, path: KeyPath, sentence: str, *, on_key: bool = False) -> str:
        """Return the message of that error: `file:line:column: key: sentence`."""
        place = self.place(path, on_key=on_key)
        key = dotted(path)
        where = f"{self.file}:{place[0]}:{place[1]}: " if place else ""
        return one_line(f"{where}{key}: {sentence}" if key else f"{where}{sentence}")

    def together(self, lines: Sequence[str]) -> SceneError:
        """Return one error of several lines, at most ten, the first ones, and the number of the others."""
        more = [f"and {len(lines) - _MOST_LINES:,} more mistakes"] if len(lines) > _MOST_LINES else []
        return SceneError("\n".join([*lines[:_MOST_LINES], *more]))

    def place(self, path: KeyPath, *, on_key: bool = False) -> Mark | None:
        """Return line and column of `path`, or None where it came from outside the file."""
        if self.file is None or any(path[: len(key)] == key for key in self.replaced):
            return None
        if path not in self.keys and any(key[: len(path)] == path for key in self.replaced if path):
            return None  # a map that exists only to hold a key given from outside
        if not on_key and path in self.values:
            return self.values[path]
        while path and path not in self.keys:
            path = path[:-1]
        return self.keys.get(path, (1, 1))

    def with_values(self, changes: dict[KeyPath, Any]) -> Document:
        """Return a document in which each path holds its new value, whole; what stood there is gone."""
        data: dict[str, Any] = dict(self.data)
        for path, value in changes.items():
            node = data
            for depth, key in enumerate(path[:-1], start=1):
                inner = node.get(str(key), {})
                if not isinstance(inner, dict):
                    raise SceneError(f"{dotted(path)}: {dotted(path[:depth])} is not a map of keys")
                node[str(key)] = dict(inner)
                node = node[str(key)]
            node[str(path[-1])] = value
        mended = {self.values.get(path) for path in changes}
        faults = [fault for fault in self.faults if fault[0] not in mended]
        return replace(self, data=data, replaced=self.replaced | set(changes), faults=faults)


def read_document(path: Path | str) -> Document:
    """Read a YAML file whose top is a map of keys; a file that is none is a `SceneError` of one line.

    What is wrong at single keys is left in `faults`, to be told together with what else is wrong.
    """
    return _parsed(_read_text(Path(path)), file=str(path))


def parse_document(text: str, *, file: str) -> Document:
    """Parse YAML text; `file` is what errors call it. Every fault is a `SceneError`."""
    document = _parsed(text, file=file)
    if document.faults:
        raise document.together([line for _, line in document.faults])
    return document


def _parsed(text: str, *, file: str) -> Document:
    try:
        node = compose(text)
    except ReaderError as error:
        line, column = _position(text, error.position)
        raise SceneError(f"{file}:{line}:{column}: the character {error.character!r} is not allowed") from None
    except yaml.MarkedYAMLError as error:
        table = _table_sentence(text)
        raise SceneError(f"{file}: {table}" if table else _syntax_error(error, text, file)) from None
    except RecursionError:
        raise SceneError(f"{file}:1:1: the nesting is too deep to read") from None
    document = Document({}, file)
    if node is None or (isinstance(node, ScalarNode) and node.value == ""):
        raise document.error((), "the file is empty; a scene is a map of keys")
    if not isinstance(node, MappingNode):
        raise document.error((), _table_sentence(text) or f"a scene is a map of keys, found {_kind(node)}")
    document.data.update(_convert(node, (), document))
    return document


def read_value(text: str) -> Any:
    """Return what `text` means as a YAML value, for a key given on the command line."""
    return parse_document(f"value: {text}", file="value").data["value"]


def dotted(path: KeyPath) -> str:
    """Return ("obstacles", "cells", 0) as `obstacles.cells[0]`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def key_path(key: str) -> KeyPath:
    """Return `obstacles.cells[0]` as ("obstacles", "cells", 0)."""
    parts = key.replace("[", ".").replace("]", "").split(".")
    return tuple(int(part) if part.isdigit() else part for part in parts)


def one_line(text: str) -> str:
    """Return `text` with every run of white space made one blank."""
    return " ".join(text.split())


def plain(value: Any) -> Any:
    """Return data from Python as a YAML file would give it: arrays, tuples, models, paths unpacked."""
    if isinstance(value, BaseModel):
        return plain(value.model_dump())
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise SceneError(f"a key must be a word, found {key!r}")
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return str(value) if isinstance(value, Path) else value


def frozen(value: Any) -> Any:
    """Return plain data with tuples for lists: strict models take no list for a tuple."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(frozen(item) for item in value) if isinstance(value, list) else value


def _read_text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        text = content.decode("utf-8-sig") if len(content) <= _MOST_BYTES else None
    except FileNotFoundError:
        raise SceneError(f"{path}: there is no such file") from None
    except IsADirectoryError:
        raise SceneError(f"{path}: this is a folder, expected a YAML file") from None
    except UnicodeDecodeError as error:
        before = error.object[: error.start].decode("utf-8", errors="replace")
        line, column = _position(before, len(before))
        found = f"found byte 0x{error.object[error.start]:02x}"
        raise SceneError(f"{path}:{line}:{column}: the file is not UTF-8 text, {found}") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        raise SceneError(one_line(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}")) from None
    if text is None:
        most = f"expected at most {_MOST_BYTES / 1e6:g} MB"
        instead = "put long tables of colloids or swimmers into files of their own (layout or release: file)"
        raise SceneError(f"{path}: the file is too large for a scene: {most}; {instead}")
    return text


def _position(text: str, index: int) -> Mark:
    head = text[:index]
    return head.count("\n") + 1, index - (head.rfind("\n") + 1) + 1


def _syntax_error(error: yaml.MarkedYAMLError, text: str, file: str) -> str:
    mark = error.problem_mark or error.context_mark
    if mark is None:
        return one_line(f"{file}:1:1: {error.problem}")
    found = text[mark.index : mark.index + 1]
    problem = f"{error.problem} ({error.context})" if error.context else str(error.problem)
    if error.problem == "but found another document":
        problem = "expected one scene in a file, found the start of another (`---`)"
    if found == "\t":
        problem = "a tab cannot indent or separate keys; use blanks"
    return one_line(f"{file}:{mark.line + 1}:{mark.column + 1}: {problem}")


def _kind(node: Node) -> str:
    if isinstance(node, SequenceNode):
        return "a list"
    if isinstance(node, MappingNode):
        return "a map"
    return f"the single value {node.value!r}" if len(node.value) <= _MOST_SHOWN else "one long text"


def _table_sentence(text: str) -> str | None:
    """What to do with a table given in place of a scene: lines of as many cells each, by commas, semicolons or tabs."""
    lines = [line for line in text.splitlines()[:_LOOKED_AT] if line.strip()]
    for separator in ",;\t":
        cells = {line.count(separator) for line in lines}
        if len(lines) > 1 and len(cells) == 1 and cells != {0} and not any(": " in line for line in lines):
            return (
                "this is a table, and check and run take a scene: name the table there as obstacles.path (with layout: "
                "file) where it holds colloids, or as swimmers.release.path (with kind: file) where it holds swimmers"
            )
    return None


def _mark(node: Node) -> Mark:
    return node.start_mark.line + 1, node.start_mark.column + 1


def _convert(node: Node, path: KeyPath, document: Document) -> Any:
    document.values[path] = _mark(node)
    name = node.tag.removeprefix(TAG)
    if isinstance(node, MappingNode) and name == "map":
        return _convert_map(node, path, document)
    if isinstance(node, SequenceNode) and name == "seq":
        return [_convert(item, (*path, i), document) for i, item in enumerate(node.value)]
    fault = f"the tag {node.tag[:40]!r} is not supported; write plain numbers, words, lists and maps"
    if isinstance(node, ScalarNode) and name in SCALARS:
        try:
            return SCALARS[name](node.value)
        except (ValueError, KeyError):
            fault = f"{node.value[:40]!r} cannot be read as {name}"
    document.faults.append((_mark(node), document.line(path, fault)))
    return UNREAD


def _convert_map(node: MappingNode, path: KeyPath, document: Document) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key_node, value_node in node.value:
        line, column = _mark(key_node)
        where = f"{document.file}:{line}:{column}: "
        if not isinstance(key_node, ScalarNode) or key_node.tag != TAG + "str":
            found = repr(key_node.value[:40]) if isinstance(key_node, ScalarNode) else _kind(key_node)
            inside = f"{dotted(path)}: " if path else ""
            fault = f"{where}{inside}a key must be a word, found {found}"
            document.faults.append(((line, column), one_line(fault)))
            continue
        inner = (*path, key_node.value)
        if key_node.value in result:
            first = document.keys[inner]
            fault = f"{where}{dotted(inner)}: duplicate key, first given at {first[0]}:{first[1]}"
            document.faults.append(((line, column), one_line(fault)))
            continue
        document.keys[inner] = (line, column)
        result[key_node.value] = _convert(value_node, inner, document)
    return result
