"""A clip that is longer than a window of the fit, and one that starts from an artist's strokes."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.clip import Clip, Timeline
from videovec.fit import draw_coverage, fit
from videovec.ink import Ink
from videovec.progress import Silent
from videovec.render import resolve_backend
from videovec.run import find_pipeline
from videovec.settings import Config, FitSettings, InitialiseSettings, RenderSettings
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes

Floats = NDArray[np.float64]

SIDE = 96
CURVES = (
    np.array([[16, 40], [36, 40], [56, 40], [76, 40.0]]),
    np.array([[20, 60], [36, 70], [56, 50], [70, 62.0]]),
)


def moving(curves: tuple[Floats, ...], drawings: int) -> Strokes:
    """Strokes that drift and turn."""
    strokes = []
    for k, curve in enumerate(curves):
        points = []
        for d in range(drawings):
            angle = 0.03 * d
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            points.append((curve - SIDE / 2) @ turn + SIDE / 2 + (0.4 * d, 0.3 * d))
        joints = (len(curve) + 2) // 3
        life = StrokeLife(
            id=k + 1,
            first=0,
            points=np.stack(points),
            half_width=np.full((drawings, joints), 1.5),
            opacity=np.ones(drawings),
            visible=np.tile([0.0, 1.0], (drawings, 1)),
            color=np.zeros(3),
            layer=k,
            is_closed=False,
        )
        strokes.append(life.as_strokes())
    return Strokes.concatenate(strokes)


def coverage_of(strokes: Strokes, drawings: int) -> NDArray[np.uint8]:
    return draw_coverage(strokes, (drawings, SIDE, SIDE), resolve_backend(RenderSettings()))


@pytest.fixture(scope="module")
def long() -> tuple[Strokes, Ink, Strokes]:
    """The truth, its ink, and the same strokes off by noise."""
    true = moving(CURVES, 14)
    coverage = coverage_of(true, 14)
    noise = np.random.default_rng(0).normal(0, 0.4, true.points.shape)
    ink = Ink(coverage, np.zeros_like(coverage), np.zeros((1, 3)), np.ones(3), 0.0)
    return true, ink, replace(true, points=true.points + noise)


def test_identities_and_smooth_motion_survive_the_edges_of_windows(long: tuple[Strokes, Ink, Strokes]) -> None:
    true, ink, start = long
    settings = FitSettings(joint_steps=50, window=5, overlap=2)
    parts = fit(ink, start, settings).strokes
    assert parts.ids.tolist() == [1, 2]
    assert parts.layout.first.tolist() == [0, 0]
    assert parts.layout.last.tolist() == [13, 13]
    whole = fit(ink, start, replace(settings, window=48)).strokes
    for stroke in range(2):
        life, alone = StrokeLife.of(parts, stroke), StrokeLife.of(whole, stroke)
        ends, true_ends = life.points[:, [0, -1]], StrokeLife.of(true, stroke).points[:, [0, -1]]
        assert np.linalg.norm(ends[1:] - true_ends[1:], axis=-1).mean() < 0.3
        shake = np.linalg.norm(np.diff(life.points - StrokeLife.of(true, stroke).points, 2, axis=0), axis=-1).mean(1)
        still = np.linalg.norm(np.diff(alone.points - StrokeLife.of(true, stroke).points, 2, axis=0), axis=-1).mean(1)
        at_edges = shake[[3, 4, 7, 8]]  # windows end after drawings 4 and 8
        assert at_edges.max() < still.max() + 0.15


def svg_of(curves: list[Floats]) -> str:
    paths = []
    for curve in curves:
        (x, y), *rest = curve.tolist()
        data = f"M{x},{y} C" + " ".join(f"{a},{b}" for a, b in rest)
        paths.append(f'<path d="{data}" fill="none" stroke="black" stroke-width="3"/>')
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE} {SIDE}">{"".join(paths)}</svg>'


def test_an_artists_strokes_stay_as_they_were_drawn_in_order_and_direction(tmp_path: Path) -> None:
    """The artist bends one stroke at a junction where every tracer goes straight on, and draws from right to left."""
    bent = np.array([[14, 40], [22, 40], [34, 40], [46, 40], [48, 52], [50, 64], [52, 80.0]])
    rest = np.array([[84, 40], [72, 40], [60, 40], [46, 40.0]])
    lone = np.array([[70, 84], [74, 72], [64, 62], [72, 54.0]])
    artist = [rest, lone, bent]
    true = moving(tuple(artist), 4)
    pictures = tuple(np.repeat((255 - page)[..., None], 3, axis=2) for page in coverage_of(true, 4))
    times = tuple(Fraction(d, 12) for d in range(4))
    clip = Clip("c", pictures, Timeline(np.arange(4), times, Fraction(4, 12), np.arange(1, 5)))
    path = tmp_path / "first.svg"
    path.write_text(svg_of(artist), encoding="utf-8")
    config = Config(initialise=InitialiseSettings(reference=str(path)), fit=FitSettings(steps=40, joint_steps=20))
    strokes = find_pipeline("solid")(clip, config, Silent()).strokes
    assert strokes.ids.tolist() == [1, 2, 3]
    assert strokes.layout.last.tolist() == [3, 3, 3]
    for stroke in range(3):
        for drawing in range(4):
            found, wanted = (s.points_of(s.row(stroke, drawing)) for s in (strokes, true))
            assert np.abs(found[[0, -1]] - wanted[[0, -1]]).max() < 1.5
