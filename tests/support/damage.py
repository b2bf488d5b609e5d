"""Run folders as bad disks, careless scripts and hostile hands leave them: one kind of damage for each number.

    python -m tests.support.damage 1000 [first]

makes so many of a small run, loads, summarises and reports each, and lists what ended in anything but an error of
ours that names a file, or took longer than it may. A report of every hundredth is drawn in full.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import porous_swim as ps
from porous_swim.analysis.summary import summarize, summary_lines
from porous_swim.core.errors import ResultsError
from porous_swim.reporting import write
from porous_swim.reporting.page import html
from porous_swim.reporting.run import runs_of
from porous_swim.reporting.run_warnings import run_warnings
from porous_swim.results.tables import SCHEMAS

LONGEST = 30.0  # seconds of CPU for one folder
SCENE = {
    "name": "small",
    "description": "thirty swimmers in a crystal",
    "units": {"length": "1 um", "speed": "5 um/s"},
    "swimmers": {"count": 30, "dipole_strength": 2.0},
    "noise": {"kind": "brownian", "translational_diffusion": 0.02},
    "obstacles": {"layout": "hexagonal", "radius": 3.5, "spacing": 10.0, "cells": [2, 1]},
    "domain": {"dimensions": 2},
    "run": {"time_step": 0.01, "duration": 60.0},
    "record": {"every": 0.5, "swimmers": 10},
}
NUMBERS = [np.nan, np.inf, -np.inf, -1.0, 0.0, 1e300, -1e300, 1e18, 5e-324, 2**31 - 1, -(2**31), 7]
JUNK: list[Any] = [
    None, [], {}, "", "\x1b[31m\x00</svg>$\\foo$", -1, 0, 2**70, 1e308, True, [1, [2, [3]]], {"a": {"b": [None]}},
    "nan", float("nan"), [[]] * 3,
]  # fmt: skip

PLANE = {"dimensions": 2}
OTHER_SCENES: list[dict[str, Any]] = [
    {"domain": {"dimensions": 3}, "obstacles": {"layout": "sc", "radius": 2.0, "spacing": 9.0, "cells": [2, 2, 2]}},
    {"obstacles": {"layout": "wall", "normal": [0.0, 1.0]}, "domain": PLANE,
     "swimmers.release": {"kind": "point", "position": [0.0, 5.0]}},
    {"obstacles": {"layout": "random", "radius": 2.0, "count": 9}, "domain": PLANE | {"size": [50.0, 60.0]}},
    {"swimmers.count": 7}, {"units": None}, {"encounter.escape_height": 9.0}, {"noise": {"kind": "none"}},
    {"description": "\x1b]0;x\x07 $ _ <b>"},
]  # fmt: skip


def make_run(folder: Path) -> Path:
    """A run to be damaged."""
    ps.run(ps.Scene.from_mapping(SCENE), out=folder)
    return folder


def damage(folder: Path, rng: np.random.Generator) -> str:
    """Damage a copy of the run in `folder` in one way that `rng` draws; say how."""
    kinds: list[Callable[[Path, np.random.Generator], str]] = [
        _flip_bits, _cut, _empty, _foreign_cells, _foreign_cells, _foreign_cells, _shuffle, _drop, _double, _retype,
        _junk_info, _junk_info, _junk_summary, _junk_summary, _deep_summary, _swap, _junk_scene,
    ]  # fmt: skip
    return kinds[int(rng.integers(len(kinds)))](folder, rng)


def _file(folder: Path, rng: np.random.Generator, suffix: str = "") -> Path:
    paths = sorted(path for path in folder.iterdir() if path.is_file() and path.suffix != ".rrd")
    return _one([path for path in paths if path.name.endswith(suffix)], rng)


def _one(items: Any, rng: np.random.Generator) -> Any:
    return items[int(rng.integers(len(items)))]


def _flip_bits(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng)
    content = bytearray(path.read_bytes())
    for _ in range(int(rng.integers(1, 20))):
        content[int(rng.integers(len(content)))] ^= 1 << int(rng.integers(8))
    path.write_bytes(content)
    return f"bits of {path.name}"


def _cut(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng)
    content = path.read_bytes()
    path.write_bytes(content[: int(rng.integers(len(content)))])
    return f"{path.name} cut"


def _empty(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng)
    path.unlink()
    if rng.random() < 0.5:
        path.mkdir()
    return f"{path.name} gone"


def _rewrite(path: Path, table: pa.Table) -> None:
    pq.write_table(table, path)


def _foreign_cells(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng, ".parquet")
    table = pq.read_table(path)
    column = _one(table.column_names, rng)
    field, values = table.schema.field(column), table.column(column).to_pylist()
    for _ in range(int(rng.integers(1, 4)) if values else 0):
        number = _one(NUMBERS, rng)
        if pa.types.is_boolean(field.type):
            number = bool(rng.random() < 0.5)
        elif pa.types.is_integer(field.type):
            info = np.iinfo(field.type.to_pandas_dtype())
            number = int(np.clip(number if np.isfinite(number) else -1, info.min, info.max // 2))
        values[int(rng.integers(len(values)))] = number
    index = table.schema.get_field_index(column)
    _rewrite(path, table.set_column(index, field, pa.array(values, field.type)))
    return f"{path.name}: numbers of {column}"


def _shuffle(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng, ".parquet")
    table = pq.read_table(path)
    _rewrite(path, table.take(pa.array(rng.permutation(len(table)))))
    return f"{path.name} shuffled"


def _drop(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng, ".parquet")
    table = pq.read_table(path)
    kept = rng.random(len(table)) < _one([0.0, 0.1, 0.9], rng)
    _rewrite(path, table.filter(pa.array(kept)))
    return f"{path.name}: {int(kept.sum())} rows left"


def _double(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng, ".parquet")
    table = pq.read_table(path)
    rows = np.repeat(np.arange(len(table)), rng.integers(1, 3, len(table)))
    _rewrite(path, table.take(pa.array(rows)))
    return f"{path.name}: rows doubled"


def _retype(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng, ".parquet")
    table = pq.read_table(path)
    index = int(rng.integers(len(table.column_names)))
    other = _one([pa.string(), pa.float32(), pa.int64()], rng)
    name = table.column_names[index]
    values = pa.array([None] * len(table), other)
    _rewrite(path, table.set_column(index, pa.field(name, other), values))
    return f"{path.name}: {name} as {other}"


def _junk_info(folder: Path, rng: np.random.Generator) -> str:
    path = _file(folder, rng, ".parquet")
    table = pq.read_table(path)
    info = json.loads(table.schema.metadata[b"porous_swim"])
    key, junk = _one([*info, *info, "unknown"], rng), _one(JUNK, rng)
    if junk is None and rng.random() < 0.3:
        info.pop(key, None)
    elif isinstance(info.get(key), dict) and rng.random() < 0.5:
        info[key][_one([*info[key], "x"], rng)] = junk
    else:
        info[key] = junk
    text = "[" * 10_000 if rng.random() < 0.05 else json.dumps(info)
    _rewrite(path, table.replace_schema_metadata({**table.schema.metadata, b"porous_swim": text.encode()}))
    return f"{path.name}: metadata {key} = {junk!r}"


def _junk_summary(folder: Path, rng: np.random.Generator) -> str:
    path = folder / "summary.json"
    summary = json.loads(path.read_text())
    node, keys = summary, []
    while True:
        keys.append(_one(list(node), rng))
        if not (isinstance(node[keys[-1]], dict) and node[keys[-1]]) or rng.random() < 0.3:
            break
        node = node[keys[-1]]
    junk = _one(JUNK, rng)
    if rng.random() < 0.2:
        del node[keys[-1]]
    else:
        node[keys[-1]] = junk
    path.write_text(json.dumps(summary))
    return f"summary: {'.'.join(keys)} = {junk!r}"


def _deep_summary(folder: Path, rng: np.random.Generator) -> str:
    depth = int(rng.integers(5, 3000))
    (folder / "summary.json").write_text('{"a":' * depth + "1" + "}" * depth)
    return f"summary {depth} deep"


def _swap(folder: Path, rng: np.random.Generator) -> str:
    first, second = _file(folder, rng), _file(folder, rng)
    if first != second:
        shutil.copyfile(second, first)
    return f"{second.name} in place of {first.name}"


def _junk_scene(folder: Path, rng: np.random.Generator) -> str:
    other = ps.Scene.from_mapping(SCENE).replace(_one(OTHER_SCENES, rng))
    (folder / "scene.yaml").write_text(other.to_yaml())
    return "another scene"


def look(folder: Path, *, draws: bool) -> str:
    """Load, summarise and report a folder; return the error of ours, if there is one. Others come through."""
    try:
        results = ps.load_results(folder)
        tables = (results.colloids, results.timeseries, results.lags)
        summary = summarize(results.stored, *tables, persistence_time=50.0, warnings=[])
        summary_lines(summary)
        if draws:
            ps.report(results, folder / "report")
            return ""
        runs = runs_of([results])
        sections = [make(runs) for make in write.SECTIONS]
        html("t", write._lead(runs), sections, {}, [sentence for run in runs for sentence in run_warnings(run)])
    except ResultsError as error:
        if str(folder) not in str(error):
            raise AssertionError("names no file") from error
        return str(error)
    return ""


def trial(run: Path, number: int, *, draws: bool) -> tuple[str, str]:
    """Damage number so and so: what it is, and what went wrong with it, or nothing."""
    rng = np.random.default_rng([number, 0])
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        shutil.copytree(run, folder, ignore=shutil.ignore_patterns("*.rrd", "report"))
        what, begin = damage(folder, rng), time.process_time()
        try:
            look(folder, draws=draws)
        except Exception:
            return what, traceback.format_exc()
        seconds = time.process_time() - begin
        return what, f"took {seconds:.0f} s" if seconds > LONGEST else ""


def main() -> None:
    count, first = (int(argument) for argument in (*sys.argv[1:], "0")[:2])
    with tempfile.TemporaryDirectory() as scratch:
        run = make_run(Path(scratch) / "whole")
        found = []
        for number in range(first, first + count):
            what, wrong = trial(run, number, draws=number % 100 == 0)
            if wrong:
                found.append(number)
                print(f"--- {number}: {what}\n{wrong}", flush=True)
    print(f"{count} damaged folders, {len(found)} ended in no error of ours: {found}")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    assert set(SCHEMAS) == {"encounters", "colloids", "timeseries", "lags", "trajectory"}
    main()
