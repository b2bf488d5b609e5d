"""YAML files as plain data with marks."""

from __future__ import annotations

from pathlib import Path

import pytest

from porous_swim.core.errors import SceneError
from porous_swim.scene.document import parse_document, read_document, read_value
from porous_swim.scene.yaml_core import write_yaml


def complaint(text: str) -> str:
    with pytest.raises(SceneError) as caught:
        parse_document(text, file="s.yaml")
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001), ("1e3", 1000.0), (".5", 0.5), ("-1.5E+2", -150.0), ("010", 10), ("0o17", 15),
        ("0x1F", 31),
        ("+7", 7), ("2:30", "2:30"), ("no", "no"), ("on", "on"), ("true", True), ("FALSE", False), ("~",
        None),
        ("", None), (".inf", float("inf")), ("-.INF", -float("inf")), ("1_000", "1_000"), ("2024-01-01",
        "2024-01-01"),
        ("'1'", "1"), ("[1, [2.0]]", [1, [2.0]]),
    ],
)  # fmt: skip
def test_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    read = read_value(text)
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb:\n  a: 2\n  a: 3\n", "s.yaml:4:3: b.a: duplicate key, first given at 3:3"),
        ("a:\n\tb: 1\n", "s.yaml:2:1: a tab cannot indent or separate keys; use blanks"),
        ("", "s.yaml:1:1: the file is empty; a scene is a map of keys"),
        ("# nothing but this\n", "s.yaml:1:1: the file is empty; a scene is a map of keys"),
        ("a: 1\n---\nb: 2\n", "s.yaml:2:1: expected one scene in a file, found the start of another (`---`)"),
        ("- 1\n", "s.yaml:1:1: a scene is a map of keys, found a list"),
        ("word", "s.yaml:1:1: a scene is a map of keys, found the single value 'word'"),
        ("a: {1: x}", "s.yaml:1:5: a: a key must be a word, found '1'"),
        ("? [a]\n: 1", "s.yaml:1:3: a key must be a word, found a list"),
        ("a: &x 1\nb: *x", "s.yaml:1:4: anchors (&) and aliases (*) are not supported; write the value out"),
        ("a: 1\nb: {c: *x}", "s.yaml:2:8: anchors (&) and aliases (*) are not supported; write the value "
         "out"),
        ("a: !!int abc", "s.yaml:1:4: a: 'abc' cannot be read as int"),
        ("a: b: c", "s.yaml:1:5: mapping values are not allowed here"),
        ("a: \x01", "s.yaml:1:4: the character 1 is not allowed"),
    ],
)  # fmt: skip
def test_what_yaml_cannot_mean_is_said_in_one_sentence(text: str, message: str) -> None:
    assert complaint(text) == message


@pytest.mark.parametrize("text", ["a: [1,", "a: 'x", "a: %x", "a: !own 1", "a: 1\n---\nb: 2", "a:\n  b: 1\n c: 2"])
def test_broken_syntax_names_file_line_and_column(text: str) -> None:
    file, line, column, sentence = complaint(text).split(":", 3)
    assert file == "s.yaml"
    assert int(line) >= 1
    assert int(column) >= 1
    assert sentence.strip()


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_in_place_of_a_scene_is_told_as_such_and_not_repeated(separator: str) -> None:
    rows = [["x", "y", "radius"], *([str(i), "2.5", "1"] for i in range(1000))]
    with pytest.raises(SceneError) as caught:
        parse_document("\n".join(separator.join(row) for row in rows), file="beads.csv")
    assert "this is a table, and check and run take a scene: name the table there as obstacles.path" in str(
        caught.value
    )
    assert len(str(caught.value)) < 300


def test_a_long_text_is_not_repeated() -> None:
    with pytest.raises(SceneError, match=r"^s.yaml:1:1: a scene is a map of keys, found one long text$"):
        parse_document("word " * 100, file="s.yaml")


def test_nesting_without_end_is_refused() -> None:
    assert "too deep" in complaint("a: " + "[" * 100_000)


def test_marks_stand_at_keys_and_values() -> None:
    document = parse_document("a: 1\nb:\n  - {c: 2}\n", file="s.yaml")
    assert document.keys[("b", 0, "c")] == (3, 6)
    assert document.values[("b", 0, "c")] == (3, 9)
    assert str(document.error(("b", 0, "c"), "no")) == "s.yaml:3:9: b[0].c: no"
    assert str(document.error(("b", 0, "d"), "no", on_key=True)) == "s.yaml:2:1: b[0].d: no"


def test_a_replaced_value_has_no_place_in_the_file() -> None:
    document = parse_document("a: {b: 1, c: 2}\n", file="s.yaml").with_values({("a", "b"): 3})
    assert document.data == {"a": {"b": 3, "c": 2}}
    assert str(document.error(("a", "b"), "no")) == "a.b: no"
    assert str(document.error(("a", "c"), "no")) == "s.yaml:1:14: a.c: no"


def test_a_key_below_a_number_cannot_be_replaced() -> None:
    with pytest.raises(SceneError, match=r"^a\.b\.c: a\.b is not a map of keys$"):
        parse_document("a: {b: 1}\n", file="s.yaml").with_values({("a", "b", "c"): 3})


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    (tmp_path / "latin.yaml").write_bytes(b"a: 1\nb: caf\xe9\n")
    for path, sentence in [
        (tmp_path / "none.yaml", "there is no such file"),
        (tmp_path, "this is a folder, expected a YAML file"),
    ]:
        with pytest.raises(SceneError) as caught:
            read_document(path)
        assert str(caught.value) == f"{path}: {sentence}"
    with pytest.raises(SceneError, match=r"latin\.yaml:2:7: the file is not UTF-8 text, found byte 0xe9$"):
        read_document(tmp_path / "latin.yaml")


def test_a_byte_order_mark_is_no_part_of_the_first_key(tmp_path: Path) -> None:
    (tmp_path / "bom.yaml").write_bytes(b"\xef\xbb\xbfa: 1\n")
    assert read_document(tmp_path / "bom.yaml").data == {"a": 1}


def test_written_yaml_reads_back_the_same() -> None:
    data = {
        "words": ["no", "1e3", "0o7", "2:30", "", "a: b", "# c", "true", "é"],
        "numbers": [1e-5, 1e300, 3, 0.1],
    }
    assert parse_document(write_yaml(data), file="s.yaml").data == data
