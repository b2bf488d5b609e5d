"""How the results of a run are read back from its folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pyarrow as pa

from porous_swim.core.errors import ResultsError
from porous_swim.core.paths import absolute
from porous_swim.results.check import checked
from porous_swim.results.encounter_table import ENCOUNTERS, MANY, Encounters
from porous_swim.results.manifest import SUMMARY, Manifest
from porous_swim.results.results import Results
from porous_swim.results.run_lock import who_ran
from porous_swim.results.tables import SCHEMAS, TableInfo, read_table


def load_results(folder: Path | str, *, verify: bool = False) -> Results:
    """Read a run folder; a table that its run could not write is empty, and `summary["missing"]` says why.

    Every table must be of the run and of the size that its summary says, and of the same checksum where it is read
    whole. A longer table of encounters is checked page by page as it is read; `verify` compares the checksums of all
    files, the recording too: a second for each GB or so.

    Raises:
        ResultsError: the folder is no run that ended, or a file is missing, damaged or of another run.
    """
    folder = absolute(folder)
    if not folder.is_dir():
        raise ResultsError(f"{folder}: there is no such run folder")
    summary = _read_summary(folder / SUMMARY)
    manifest = Manifest.of(summary, folder)
    for name in manifest.files if verify else ():
        manifest.check(name, whole=True)
    stored = _encounters(manifest)
    others = {name: schema for name, schema in SCHEMAS.items() if name != "encounters"}
    found = {name: _table(manifest, name, schema) for name, schema in others.items()}
    infos = {}
    for name, source in {"encounters": stored, **found}.items():
        if source is not None:
            path = folder / f"{name}.parquet"
            try:
                infos[name] = TableInfo.of(source)
            except ResultsError as error:
                raise ResultsError(f"{path}: {error}") from error
            manifest.check_run(path.name, infos[name])
            manifest.check_rows(path.name, len(source))
    if "colloids" not in infos:
        raise ResultsError(f"{folder}: the run could not write its colloids ({manifest.missing['colloids.parquet']})")
    info = infos.get("encounters", infos["colloids"])
    tables = {
        name: info.attach(others[name].empty_table()) if table is None else table for name, table in found.items()
    }
    stored = Encounters.in_memory(info.attach(SCHEMAS["encounters"].empty_table())) if stored is None else stored
    return checked(Results(stored, **tables, summary=summary, folder=folder, info=info), folder)


def _encounters(manifest: Manifest) -> Encounters | None:
    """The encounters of a folder; None where its run could not write them."""
    path = manifest.folder / ENCOUNTERS
    if ENCOUNTERS in manifest.missing and not path.exists():
        return None
    record = manifest.files.get(ENCOUNTERS)
    manifest.check(ENCOUNTERS, whole=record is not None and (record.rows or 0) <= MANY)
    return Encounters.at(path)


def _table(manifest: Manifest, name: str, schema: pa.Schema) -> pa.Table | None:
    """Another table of a folder; None where its run could not write it."""
    path = manifest.folder / f"{name}.parquet"
    if path.name in manifest.missing and not path.exists():
        return None
    manifest.check(path.name, whole=True)
    return read_table(path, schema)


def _read_summary(path: Path) -> dict[str, Any]:
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        run = who_ran(path.parent)
        what = "is no run folder or its run died" if run is None else f"run is under way or died ({run})"
        raise ResultsError(f"{path.parent}: no {SUMMARY}, which a run writes last, so this {what}") from error
    except (OSError, ValueError, RecursionError) as error:
        raise ResultsError(f"{path}: cannot be read as JSON ({error})") from error
    if not isinstance(summary, dict):
        raise ResultsError(f"{path}: found a {type(summary).__name__} where a map belongs")
    return summary
