"""Made-up tables with known answers."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.results.tables import (
    COLLOIDS_SCHEMA,
    ENCOUNTERS_SCHEMA,
    LAGS_SCHEMA,
    TRAJECTORY_SCHEMA,
    TableInfo,
    make_table,
)

# lags in frames, by the frames from one start of a window to the next, as docs/statistics.md has them
LAGS_OF = {1: [1, 2, 3, 4], 4: [5, 6, 7, 8, 10, 12, 14, 16], 16: [20, 24, 28, 32, 40, 48, 56, 64],
           64: [80, 96, 112, 128, 160, 192, 224, 256]}  # fmt: skip
_NULLABLE = {field.name for field in ENCOUNTERS_SCHEMA if field.nullable}


def info(
    *,
    n_swimmers: int = 1,
    last_time: float = 100.0,
    dimensions: int = 3,
    box: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> TableInfo:
    """Information of a run from time 0."""
    return TableInfo(n_swimmers, dimensions, box, 0.0, last_time, 0.01, None, {"seed": 1})


def encounters(about: TableInfo, **columns: object) -> pa.Table:
    """A table of encounters with the columns given (arrays or lists), the others 0, False or null."""
    n = len(columns["swimmer"])  # type: ignore[arg-type]
    filled = {}
    for field in ENCOUNTERS_SCHEMA:
        nothing = np.full(n, np.nan) if field.name in _NULLABLE else np.zeros(n, field.type.to_pandas_dtype())
        filled[field.name] = np.asarray(columns.pop(field.name, nothing))
    assert not columns, f"no such columns: {sorted(columns)}"
    return make_table(ENCOUNTERS_SCHEMA, filled, info=about)


def colloids(about: TableInfo, centers: np.ndarray, *, radius: float = 1.0) -> pa.Table:
    """A table of equal colloids at centres (n, 3)."""
    x, y, z = np.asarray(centers, float).T
    columns = {"colloid": np.arange(len(x)), "x": x, "y": y, "z": z, "radius": np.full(len(x), radius)}
    return make_table(COLLOIDS_SCHEMA, columns, info=about)


def trajectory(about: TableInfo, time: np.ndarray, position: np.ndarray, director: np.ndarray) -> pa.Table:
    """A table of free swimmers from times (n,), positions and directors (n, n_swimmers, 3)."""
    n_frames, n_swimmers, _ = position.shape
    n = n_frames * n_swimmers
    columns = {field.name: np.zeros(n) for field in TRAJECTORY_SCHEMA}
    columns |= dict(zip("xyz", position.reshape(n, 3).T, strict=True))
    columns |= dict(zip(("ex", "ey", "ez"), director.reshape(n, 3).T, strict=True))
    columns |= {"time": np.repeat(time, n_swimmers), "swimmer": np.tile(np.arange(n_swimmers), n_frames)}
    whole = {"swimmer", "colloid", "image_x", "image_y", "image_z", "state"}
    typed = {name: values.astype(np.int32) if name in whole else values for name, values in columns.items()}
    return make_table(TRAJECTORY_SCHEMA, typed, info=about)


def lags(about: TableInfo, time: np.ndarray, position: np.ndarray, director: np.ndarray) -> pa.Table:
    """The table of lags of times (n,), positions and directors (n, n_swimmers, 3); each swimmer is a group."""
    n_last, n_swimmers = len(time) - 1, position.shape[1]
    rows: dict[str, list[np.ndarray]] = {field.name: [] for field in LAGS_SCHEMA}
    reached = {spacing: [lag for lag in LAGS_OF[spacing] if lag <= max(1.0, 0.5 * n_last)] for spacing in LAGS_OF}
    reached = {spacing: lags for spacing, lags in reached.items() if lags}
    for spacing, lags in reached.items():
        if spacing == max(reached):  # four windows or more of the longest lag
            spacing = min(spacing, int(np.ceil(lags[-1] / 4)))
        for lag in lags:
            first = np.arange(spacing // 2, n_last - lag + 1, spacing)
            if len(first) == 0:
                continue
            square = np.sum((position[first + lag] - position[first]) ** 2, axis=2)
            overlap = np.sum(director[first + lag] * director[first], axis=2)
            values = {
                "lag": np.full(n_swimmers, time[lag] - time[0]), "group": np.arange(n_swimmers),
                "n_swimmers": np.ones(n_swimmers, int), "n_windows": np.full(n_swimmers, len(first)),
                "msd": square.mean(axis=0), "fourth_moment": (square**2).mean(axis=0),
                "director_correlation": overlap.mean(axis=0),
            }  # fmt: skip
            for name, value in values.items():
                rows[name].append(value)
    empty = {"group": np.zeros(0, int), "n_swimmers": np.zeros(0, int), "n_windows": np.zeros(0, int)}
    columns = {name: np.concatenate([empty.get(name, np.zeros(0)), *parts]) for name, parts in rows.items()}
    return make_table(LAGS_SCHEMA, columns, info=about)


def exponential_encounters(rng: np.random.Generator, *, n_swimmers: int, mean: float, last_time: float) -> pa.Table:
    """Swimmers caught again at once whenever they escape, after exponential times, cut at `last_time`."""
    columns: dict[str, list[np.ndarray]] = {name: [] for name in ("swimmer", "start_time", "end_time")}
    swimmer, start = np.arange(n_swimmers), np.zeros(n_swimmers)
    while len(swimmer):
        end = start + rng.exponential(mean, len(swimmer))
        for name, values in (("swimmer", swimmer), ("start_time", start), ("end_time", end)):
            columns[name].append(values)
        swimmer, start = swimmer[end < last_time], end[end < last_time]
    whole = {name: np.concatenate(values) for name, values in columns.items()}
    cut = whole["end_time"] >= last_time
    whole["end_time"] = np.minimum(whole["end_time"], last_time)
    order = rng.permutation(len(cut))  # a run logs rows as they end
    about = info(n_swimmers=n_swimmers, last_time=last_time)
    return encounters(about, end_censored=cut[order], **{name: values[order] for name, values in whole.items()})


def random_moves(rng: np.random.Generator, *, n_swimmers: int, n_rows: int, last_time: float) -> pa.Table:
    """Encounters of random swimmers with three colloids and their images, never two at once."""
    swimmer = rng.integers(0, n_swimmers, n_rows)
    place = np.empty(n_rows, int)  # number of the row among its swimmer's
    order = np.argsort(swimmer, kind="stable")
    first = np.searchsorted(swimmer[order], np.arange(n_swimmers))
    place[order] = np.arange(n_rows) - first[swimmer[order]]
    slot = last_time / (place.max() + 1)
    start = (place + rng.uniform(0.0, 0.4, n_rows)) * slot
    end = start + rng.uniform(0.1, 0.5, n_rows) * slot
    position = rng.normal(size=(6, n_rows))
    names = ("entry_x", "entry_y", "entry_z", "exit_x", "exit_y", "exit_z")
    return encounters(
        info(n_swimmers=n_swimmers, last_time=last_time, box=(10.0, 0.0, 0.0)),
        swimmer=swimmer,
        start_time=start,
        end_time=end,
        colloid=rng.integers(0, 3, n_rows),
        image_x=rng.integers(-1, 2, n_rows),
        winding=rng.exponential(1.0, n_rows),
        contact_time=0.5 * (end - start),
        **dict(zip(names, position, strict=True)),
    )
