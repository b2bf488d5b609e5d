"""The record of an encounter: rows by name, and what a step does to them."""

# No `from __future__ import annotations`: Taichi needs live annotations of kernels.
import numpy as np
import pytest
import taichi as ti

from porous_swim.engine import backend
from porous_swim.engine.encounter_log import Records
from porous_swim.engine.kernel import record as record_module
from porous_swim.engine.kernel.device_log import LogLong, log_columns
from porous_swim.engine.kernel.record import checked, make_record
from porous_swim.engine.kernel.state import real_rows
from porous_swim.physics.model import Model
from porous_swim.results import encounter_columns
from porous_swim.results.encounter_columns import COLUMNS, AtRelease, Greatest, Least, Sum
from tests.support.engines import field_of

LANES = 4
VALUES = [0.1, 0.2, 0.7, 0.4]  # of the steps of `record_of`


@pytest.fixture(scope="module", autouse=True)
def device():
    backend.ensure("cpu")


def record_of(dimensions: int, *, more: str = "max_height") -> np.ndarray:
    """Rows of the lanes, (n_lanes, LANES) float32, after some steps of the odd ones, with a value for `more`, too."""
    rows = real_rows(dimensions, located=False)
    gather, hold, clear = make_record(Model(ti.f32, dimensions))
    Wide, WideInt = ti.types.vector(LANES, ti.f32), ti.types.vector(LANES, ti.i32)
    reals = ti.types.ndarray(ti.f32, ndim=1)

    @ti.kernel
    def kernel(values: reals, out: ti.types.ndarray(ti.f32, ndim=2)):
        for _ in range(1):
            f = [Wide(9.0) for _ in ti.static(range(rows.n_lanes))]
            on = WideInt(0)
            for j in range(LANES):
                clear(f, j)
                on[j] = j % 2
            for step in range(values.shape[0]):
                v = Wide(values[step])
                gather(
                    f, on != 0,
                    {"push": v, "winding": v, "signed": v, "height": v, "min_height": v, "max_height": v, more: v},
                )  # fmt: skip
                hold(f, on != 0, {"release_sine": v, "release_winding": v})
            for row in ti.static(range(rows.n_lanes)):
                for j in range(LANES):
                    out[row, j] = f[row][j]

    out = np.zeros((rows.n_lanes, LANES), np.float32)
    kernel(np.array(VALUES, np.float32), out)
    return out


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_step_adds_to_sums_and_moves_bounds_in_its_lanes_alone(dimensions):
    rows, found = real_rows(dimensions, located=False), record_of(dimensions)
    # single precision: sums of four numbers to a few roundings, all else exact
    for name in ("push", "winding", "height", *(("signed",) if dimensions == 2 else ())):
        assert found[getattr(rows, name), 1::2] == pytest.approx(sum(VALUES), rel=3e-7)
    assert hasattr(rows, "signed") == (dimensions == 2)
    assert np.all(found[rows.min_height, 1::2] == np.float32(min(VALUES)))
    assert np.all(found[rows.max_height, 1::2] == np.float32(max(VALUES)))
    assert np.all(found[rows.release_sine, 1::2] == np.float32(VALUES[-1]))
    starts = {Sum: 0.0, Least: np.inf, Greatest: -np.inf, AtRelease: 0.0}
    for record in encounter_columns.records(dimensions):
        assert np.all(found[getattr(rows, record.row), 0::2] == starts[type(record)])
    assert np.all(found[rows.clock] == 9.0)  # no row of the record


def test_rows_and_the_log_follow_from_the_list_of_columns():
    for dimensions in (2, 3):
        rows, logged = vars(real_rows(dimensions, located=False)), vars(log_columns(dimensions))
        for record in encounter_columns.records(dimensions):
            assert record.row in logged
            assert all(row in rows for row in record.rows)
    assert "push_rest" in rows
    assert "signed" not in logged


def test_a_row_without_a_value_does_not_compile(monkeypatch):
    more = (*encounter_columns.all_records(), Sum("wandered"))
    monkeypatch.setattr(record_module, "all_records", lambda: more)
    with pytest.raises(ti.TaichiCompilationError, match="no value is recorded for the row 'wandered'"):
        record_of(2)


def test_a_value_without_a_row_does_not_compile():
    with pytest.raises(ti.TaichiCompilationError, match="a value is recorded for 'wandered', which is no row of kind"):
        record_of(2, more="wandered")


def test_what_a_step_adds_is_no_value_at_a_release():
    with pytest.raises(ValueError, match="recorded for 'push', which is no row of kind AtRelease"):
        checked({"push": 0.0, "release_sine": 0.0, "release_winding": 0.0}, AtRelease)


def test_a_bound_before_the_first_step_and_a_release_that_never_came_are_no_values():
    columns = log_columns(3)
    real, step = np.zeros((2, columns.n_real)), np.zeros((2, len(LogLong)), np.int64)
    real[:, columns.release_winding], real[:, columns.max_height] = 0.25, [-np.inf, 1.2]
    step[:, LogLong.END], step[:, LogLong.RELEASE] = 10, [-1, 4]
    (table,) = Records(field_of([[0, 0, 0]], 2.0), 0.1, 2).parts(
        real, np.array([[0, 0, 0, 0, 0], [1, 0, 0, 0, 0]]), step
    )
    assert set(table) == {column.name for column in COLUMNS}
    assert table["max_height"].tolist() == pytest.approx([np.nan, 1.2], nan_ok=True)
    assert table["release_winding"].tolist() == pytest.approx([np.nan, 0.25], nan_ok=True)
    assert np.isnan(table["signed_winding"]).all()
