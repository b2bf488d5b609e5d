"""Every registered part passes the checks of `porous_swim.testing`: a new one is a line here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.core.registry import parts_of
from porous_swim.observers.lags import Lags
from porous_swim.observers.progress import make_progress
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from porous_swim.testing import check_flow, check_layout, check_motility, check_observer, check_release, check_stepper

FLAT = {"dimensions": 2}
BOX = {"boundary": "periodic", "size": [30.0, 30.0, 30.0]}
FLAT_BOX = {"dimensions": 2, "boundary": "periodic", "size": [30.0, 30.0]}
COLLOIDS = "x,y,z,radius\n5,5,0,2\n11,5,0,3\n-4,25,0,2.5\n"
STARTS = "x,y,z,ex,ey,ez\n" + "".join(f"{0.1 * k},1.5,2,0,0.6,0.8\n" for k in range(100))

LAYOUTS: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"layout": "none"}, {}),
    ({"layout": "none"}, FLAT_BOX),
    ({"layout": "single", "radius": 3.0, "position": [1.0, 2.0, -3.0]}, BOX),
    ({"layout": "wall", "normal": [0.0, 3.0, 4.0], "position": [1.0, 2.0, 3.0]}, {}),
    ({"layout": "square", "radius": 2.0, "spacing": 4.0, "cells": [5, 4]}, FLAT),
    ({"layout": "hexagonal", "radius": 2.0, "spacing": 4.0, "cells": [5, 3]}, FLAT),
    ({"layout": "sc", "radius": 2.0, "spacing": 4.0, "cells": [3, 4, 5]}, {}),
    ({"layout": "bcc", "radius": 2.0, "spacing": 4.0, "cells": [3, 4, 2]}, {}),
    ({"layout": "fcc", "radius": 2.0, "spacing": 4.0, "cells": [3, 4, 2]}, {}),
    ({"layout": "random", "radius": [2.0, 3.0], "count": 60, "packing_fraction": 0.2, "min_gap": 0.1}, {}),
    ({"layout": "random", "radius": 1.0, "packing_fraction": 0.2}, FLAT_BOX),
    ({"layout": "packing", "radius": [2.0, 3.0], "count": 60, "packing_fraction": 0.4}, {}),
    ({"layout": "file", "path": "colloids.csv"}, BOX),
]
RELEASES: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"kind": "uniform"}, {}),
    ({"kind": "point", "position": [1.0, 2.0, 3.0]}, {}),
    ({"kind": "point", "position": [1.0, 2.0], "director": [3.0, 4.0]}, {"domain": FLAT_BOX}),
    ({"kind": "beam", "origin": [0.0, 10.0, 3.0], "director": [0.0, 3.0, 4.0], "width": 5.0}, {}),
    ({"kind": "beam", "origin": [0.0, 10.0], "director": [3.0, 4.0], "width": 5.0}, {"domain": FLAT_BOX}),
    ({"kind": "parallel", "height": 1.2}, {}),
    ({"kind": "parallel", "height": 1.2}, {"domain": FLAT_BOX}),
    ({"kind": "file", "path": "starts.csv"}, {}),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("files")
    (made / "colloids.csv").write_text(COLLOIDS)
    (made / "starts.csv").write_text(STARTS)
    return made


@pytest.mark.parametrize(("obstacles", "domain"), LAYOUTS, ids=lambda each: each.get("layout"))
def test_a_layout_is_one(obstacles: dict[str, Any], domain: dict[str, Any], folder: Path) -> None:
    check_layout(obstacles, domain=domain, folder=folder, overlap=1e-6 if obstacles["layout"] == "packing" else 1e-9)


@pytest.mark.parametrize(("release", "around"), RELEASES, ids=lambda each: each.get("kind"))
def test_a_release_is_one(release: dict[str, Any], around: dict[str, Any], folder: Path) -> None:
    flat = "domain" in around
    colloid = {"layout": "single", "radius": 3.0, "position": [10.0, 10.0] if flat else [10.0, 10.0, 10.0]}
    check_release(release, obstacles=colloid, folder=folder, **around)


FLOWS: dict[str, dict[str, bool]] = {"none": {}, "image_dipole": {}, "near_wall": {"turns_alone": True}}


@pytest.mark.parametrize(("kind", "options"), FLOWS.items())
def test_a_flow_is_one(kind: str, options: dict[str, bool]) -> None:
    check_flow(kind, **options)


MOTILITIES: list[dict[str, Any]] = [{"kind": "steady"}]


@pytest.mark.parametrize("motility", MOTILITIES, ids=lambda each: each.get("kind"))
def test_a_motility_is_one(motility: dict[str, Any]) -> None:
    check_motility(motility)


@pytest.mark.parametrize("integrator", ["euler", "reflected", "located"])
def test_a_stepper_is_one(integrator: str) -> None:
    check_stepper(integrator)


@pytest.mark.parametrize(
    "make",
    [
        TimeSeries,
        lambda schedule: Trajectory(schedule, swimmers=np.arange(20)),
        lambda schedule: make_progress(schedule, n_steps=50, n_swimmers=20, quiet=True),
        lambda schedule: Lags(np.ones(20), period=schedule.period),
    ],
    ids=["time series", "trajectory", "progress", "lags"],
)
def test_an_observer_is_one(make: Any) -> None:
    check_observer(make)


def test_every_part_is_checked() -> None:
    assert {given["layout"] for given, _ in LAYOUTS} == set(parts_of(ps.Layout))
    assert {given["kind"] for given, _ in RELEASES} == set(parts_of(ps.Release))
    assert set(FLOWS) == set(parts_of(ps.Flow))
    assert {given["kind"] for given in MOTILITIES} == set(parts_of(ps.Motility))
