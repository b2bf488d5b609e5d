"""Figure FlowFields: the fluid around a pusher near a colloid."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim.paper.figure import Reproduction, Row, disc, panels
from porous_swim.paper.scan import paper_scene
from porous_swim.theory.flow_field import flow_field

NAME = "FlowFields"
TITLE = "Flow of a pusher (alpha = 0.8) at height 5 above a colloid of radius 10: parallel, inclined, perpendicular"
RADIUS, HEIGHT = 10.0, 5.0
PITCHES = (0.0, 0.25 * np.pi, 0.5 * np.pi)


def reproduce(quick: bool) -> Reproduction:
    """The flow in the plane of swimmer and colloid, and how well it sticks to the surface."""
    scene = paper_scene("flow_fields")
    alpha = scene.swimmers.dipole_strength
    axis_points = np.linspace(-22.0, 22.0, 45 if quick else 111)
    X, Y = np.meshgrid(axis_points, axis_points)
    outside = (np.hypot(X, Y) > RADIUS * 1.001) & (np.hypot(X, Y - RADIUS - HEIGHT) > 1e-9)
    points = np.stack([X[outside], Y[outside], np.zeros(outside.sum())], axis=1)
    swimmer = np.array([0.0, RADIUS + HEIGHT, 0.0])
    surface = _surface_points(400)
    tables, fields, worst = {}, [], 0.0
    for pitch in PITCHES:
        director = np.array([np.cos(pitch), np.sin(pitch), 0.0])
        flow = flow_field(points, swimmer, director, radius=RADIUS, dipole_strength=alpha)
        field = np.full((*X.shape, 2), np.nan)
        field[outside] = flow[:, :2]
        fields.append(field)
        columns = {"x": points[:, 0], "y": points[:, 1], "u": flow[:, 0], "v": flow[:, 1]}
        tables[f"pitch{np.degrees(pitch):.0f}"] = columns
        slip = flow_field(surface, swimmer, director, radius=RADIUS, dipole_strength=alpha)
        worst = max(worst, float(np.abs(slip).max()) / (2.0 * alpha / HEIGHT**2))
    rows = [Row("slip on the sphere over the largest free flow there", worst, independent=0.0, digit=1e-10)]

    def draw() -> Any:
        from matplotlib.colors import LogNorm

        picture, axes = panels(3)
        for axis, field, pitch in zip(axes, fields, PITCHES, strict=True):
            speed = np.hypot(field[..., 0], field[..., 1])
            axis.pcolormesh(X, Y, speed, norm=LogNorm(1e-4, 0.3), cmap="viridis", shading="auto", rasterized=True)
            axis.streamplot(
                axis_points, axis_points, field[..., 0], field[..., 1], color="w", linewidth=0.5, density=1.2
            )
            disc(axis, RADIUS)
            axis.annotate("", 3.0 * np.array([np.cos(pitch), np.sin(pitch)]) + swimmer[:2], swimmer[:2],
                          arrowprops={"color": "C3", "width": 1.5, "headwidth": 6})  # fmt: skip
            axis.set(xlabel="x/a", ylabel="y/a", title=f"pitch {np.degrees(pitch):.0f} degrees", xlim=(-22, 22),
                     ylim=(-22, 22))  # fmt: skip
        return picture

    return Reproduction(tables, rows, draw)


def _surface_points(n: int) -> np.ndarray:
    """Points spread over the sphere, the one opposite to the swimmer included."""
    k = np.arange(n) + 0.5
    polar, turn = np.arccos(1.0 - 2.0 * k / n), np.pi * (1.0 + 5.0**0.5) * k
    sphere = np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1)
    return RADIUS * np.vstack([sphere, [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]])
