"""What every statistic of the tables must do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from porous_swim.analysis.estimates import Estimate

_ROUNDING = 1e-9  # relative: sums in another order, and fits that stop at 1e-10
_MISSED = 4.0  # binomial standard errors by which a coverage may be off: one false alarm in 16 000


def check_statistic(statistic: Callable[..., Any], tables: Mapping[str, Any], *, ordered: bool = False) -> None:
    """Require of `statistic(**tables)`:

    it has a docstring; called twice it gives the same; it does not depend on how swimmers are numbered, but for the
    order of rows where it gives one for each swimmer, encounter or hop (`ordered`); every `Estimate` in what it returns
    has a number of samples, a unit as text, and an error that is finite and not negative wherever two samples or more
    tell a value.

    Args:
        statistic: the function.
        tables: its arguments by name, pyarrow tables and others.
        ordered: True where the rows of its result are in the order of swimmers.
    """
    name = getattr(statistic, "__name__", repr(statistic))
    assert statistic.__doc__, f"{name}: it has no docstring"
    found = statistic(**tables)
    again = _numbers(statistic(**tables))
    assert set(again) == set(_numbers(found)), f"{name}: called again it returns other things"
    for key, numbers in _numbers(found).items():
        assert np.array_equal(numbers, again[key], equal_nan=True), f"{name}: called again it gives another {key}"
    _check_renumbered(statistic, tables, found, name, ordered)
    for key, estimate in _estimates(found):
        _check_estimate(estimate, f"{name}: {key}")


def check_coverage(
    statistic: Callable[[Any], Estimate], draw: Callable[[np.random.Generator], Any], truth: float, *,
    level: float = 0.95, repeats: int = 400, n_samples: int, seed: int = 1,
) -> None:  # fmt: skip
    """Require that value ± t x standard error covers `truth` in the share `level` of so many repeats of an experiment.

    `draw(rng)` makes the data of one, of `n_samples` independent samples, and t is Student's for these.
    """
    from scipy.stats import t as student

    rng, reach = np.random.default_rng(seed), float(student.ppf(0.5 + 0.5 * level, n_samples - 1))
    found = [statistic(draw(rng)) for _ in range(repeats)]
    share = np.mean([abs(each.value - truth) <= reach * each.standard_error for each in found])
    allowed = _MISSED * math.sqrt(level * (1.0 - level) / repeats)
    name = getattr(statistic, "__name__", repr(statistic))
    assert abs(share - level) <= allowed, f"{name}: intervals of {level:g} cover the truth in {share:g} of the repeats"


def _check_renumbered(
    statistic: Callable[..., Any], tables: Mapping[str, Any], found: Any, name: str, ordered: bool
) -> None:
    expected, other = _numbers(found), _numbers(statistic(**_renumbered(tables)))
    for key, numbers in expected.items():
        if ordered and key.endswith(".swimmer"):
            continue
        if ordered:
            numbers, other[key] = np.sort(numbers, axis=None), np.sort(other[key], axis=None)
        assert other[key].shape == numbers.shape, f"{name}: with swimmers renumbered {key} has another shape"
        scale = np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0)
        close = np.isclose(other[key], numbers, rtol=_ROUNDING, atol=_ROUNDING * scale, equal_nan=True)
        assert np.all(close), f"{name}: {key} depends on how swimmers are numbered"


def _renumbered(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables with the numbers of all swimmers reversed, and in the order of these again."""
    columns = [table["swimmer"].to_numpy() for table in tables.values() if _has_swimmers(table)]
    last = max((int(column.max()) for column in columns if len(column)), default=0)
    result = dict(tables)
    for key, table in tables.items():
        if _has_swimmers(table):
            number = last - table["swimmer"].to_numpy()
            keys = (number, table["time"].to_numpy()) if table.column_names[0] == "time" else (number,)
            at = table.column_names.index("swimmer")
            column = pa.array(number, type=table.schema.field("swimmer").type)
            changed = table.set_column(at, table.schema.field("swimmer"), column)
            order = np.lexsort(keys) if len(keys) == 2 else np.argsort(number, kind="stable")
            result[key] = changed.take(pa.array(order)).replace_schema_metadata(table.schema.metadata)
    return result


def _has_swimmers(table: Any) -> bool:
    return isinstance(table, pa.Table) and "swimmer" in table.column_names


def _check_estimate(estimate: Estimate, where: str) -> None:
    assert estimate.n >= 0, f"{where}: it rests on {estimate.n} samples"
    assert estimate.n_censored >= 0, f"{where}: of {estimate.n_censored} samples only a part was seen"
    assert isinstance(estimate.unit, str), f"{where}: its unit is {estimate.unit!r}"
    if math.isfinite(estimate.value) and estimate.n > 1:
        error = estimate.standard_error
        assert error >= 0.0, f"{where}: {estimate.value:g} of {estimate.n} samples has the error {error}"
        assert math.isfinite(error), f"{where}: {estimate.value:g} of {estimate.n} samples has the error {error}"


def _numbers(found: Any) -> dict[str, np.ndarray]:
    return {key: np.asarray(value, dtype=float) for key, value in _leaves(found) if _is_numeric(value)}


def _estimates(found: Any) -> Iterator[tuple[str, Estimate]]:
    yield from ((key, value) for key, value in _leaves(found, whole=Estimate) if isinstance(value, Estimate))


def _leaves(found: Any, key: str = "it", whole: type | None = None) -> Iterator[tuple[str, Any]]:
    """Yield what a result holds, at any depth, with its place."""
    if isinstance(found, pa.Table):
        found = {name: found[name].to_numpy() for name in found.column_names}
    if isinstance(found, Mapping):
        parts = [(str(name), value) for name, value in found.items()]
    elif isinstance(found, (tuple, list)):
        parts = [(str(number), value) for number, value in enumerate(found)]
    elif is_dataclass(found) and (whole is None or not isinstance(found, whole)):
        parts = [(each.name, getattr(found, each.name)) for each in fields(found)]
    else:
        yield key, found
        return
    for name, value in parts:
        yield from _leaves(value, f"{key}.{name}", whole)


def _is_numeric(value: Any) -> bool:
    return np.asarray(value).dtype.kind in "biuf"
