"""Figure Bullseye: a pusher aimed beside the centre of colloids of three radii leaves two of them."""

from __future__ import annotations

from typing import Any

from porous_swim.paper.figure import Reproduction, Row, disc, panels
from porous_swim.paper.scan import is_held, outgoing_angle, paper_scene, pitch_of, run_changes, thresholds
from porous_swim.running.batch import Member

NAME = "Bullseye"
TITLE = "A pusher (alpha = 0.8) aimed 0.1 a beside the centre of a colloid of radius 5, 15, 20"
RADII = (5.0, 15.0, 20.0)
LISTED = {5.0: (34.73, 51.19, 36.05), 15.0: (24.77, 68.55, -43.24)}


def reproduce(quick: bool) -> Reproduction:
    """Trajectories, and the critical radius by bisection from the same start."""
    scene = paper_scene("bullseye")
    members = run_changes(scene, [{"obstacles.radius": radius} for radius in RADII])
    (critical,) = thresholds(
        [15.0], [15.1], lambda _, A: scene.replace({"obstacles.radius": A, "run.duration": 600.0}), is_held, n_batches=7
    )
    rows = [Row("critical radius from this start", critical, paper="about 15.1", independent=15.06103, digit=1e-5)]
    for radius, member in zip(RADII, members, strict=True):
        rows += _rows(radius, member)
    tables = {
        f"A{radius:g}": {
            "time": member.time, "x": member.position[:, 0, 0], "y": member.position[:, 0, 1],
            "height": pitch_of(member, radius)[0][:, 0], "pitch": pitch_of(member, radius)[1][:, 0],
        } for radius, member in zip(RADII, members, strict=True)
    }  # fmt: skip

    def draw() -> Any:
        picture, axes = panels(3)
        for axis, radius, member in zip(axes, RADII, members, strict=True):
            disc(axis, radius)
            axis.plot(member.position[:, 0, 0], member.position[:, 0, 1], color="C3")
            axis.set(title=f"A = {radius:g}", xlim=(-45, 45), ylim=(-40, 40), xlabel="x/a", ylabel="y/a")
        return picture

    return Reproduction(tables, rows, draw)


def _rows(radius: float, member: Member) -> list[Row]:
    start, release = (float(member.encounters[name][0]) for name in ("start_time", "release_time"))
    if radius not in LISTED:
        pitch = float(pitch_of(member, radius)[1][-1, 0])
        return [
            Row(f"A = {radius:g}: contact at t", start, independent=19.76, digit=0.01),
            Row(f"A = {radius:g}: pitch at rest", pitch, independent=0.18107, digit=1e-5),
            Row(f"A = {radius:g}: held (1: yes)", float(is_held(member)), paper="1 (held)", independent=1.0),
        ]
    contact, leave, angle = LISTED[radius]
    return [
        Row(f"A = {radius:g}: contact at t", start, independent=contact, digit=0.01),
        Row(f"A = {radius:g}: leaves at t", release, independent=leave, digit=0.01),
        Row(f"A = {radius:g}: outgoing angle, degrees", outgoing_angle(member), independent=angle, digit=0.05),
    ]
