"""Where the first strokes come from: traced, scattered at random, or drawn by an artist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip
from videovec.errors import InputError
from videovec.fit import draw_coverage
from videovec.initialise import initialise
from videovec.ink import Ink, amount_of_ink, first_full
from videovec.propagate import make_target, propagate
from videovec.reference import read_reference
from videovec.render import resolve_backend
from videovec.settings import Config, FitSettings, InitialiseSettings, PropagateSettings
from videovec.strokes import Strokes

__all__ = ["first_strokes", "scatter", "start_drawing", "start_settings", "walk_settings"]

Floats = NDArray[np.float64]

_RANDOM_STEPS = 800  # optimiser updates that random strokes get at least
_RANDOM_SCALE = 8.0  # px; the kernel that they start with
_RANDOM_OPACITY_RATE = 0.05
_LENGTH = 0.8  # of the mean distance between random strokes: their length
_BEND = 0.15  # of their length: how far handles of random strokes lie off the chord
_OPACITY = 0.8  # of random strokes
_NEAR = 1.5  # px within which a reference lies on the ink and needs no registration
_RECOGNISED = 0.5  # of a reference's strokes that registration must find again


def start_drawing(clip: Clip, ink: Ink, settings: InitialiseSettings) -> int:
    """The drawing whose strokes come first: the one that the reference shows, else the first that shows enough.

    Where lines are still being drawn on, or something hides them, strokes are traced on a fuller drawing and followed
    from there both ways.

    Raises:
        InputError: The clip has no such frame.
    """
    if not settings.reference:
        return first_full(amount_of_ink(ink))
    numbers = clip.timeline.frame_numbers
    found = np.flatnonzero(numbers == settings.reference_frame)
    if not len(found):
        raise InputError(
            f"initialise.reference_frame must be one of the frames {numbers[0]}..{numbers[-1]} that are read, "
            f"got {settings.reference_frame}"
        )
    return int(clip.timeline.drawing_of_frame[found[0]])


def first_strokes(ink: Ink, drawing: int, config: Config) -> Strokes:
    """The strokes that a fit begins with.

    Args:
        ink: The ink of D drawings.
        drawing: The drawing that the strokes are for.
        config: Its ``initialise`` says where they come from.

    Returns:
        Strokes of drawing 0, so that they fit ``ink.at_drawing(drawing)``.

    Raises:
        InputError: The reference cannot be read, or shows something else.
    """
    alone = ink.at_drawing(drawing)
    if config.initialise.reference:
        return _referenced(alone, config)
    if config.initialise.method == "random":
        return scatter(alone, config.initialise.strokes, np.random.default_rng(config.seed))
    return initialise(alone, 0, config.initialise)


def start_settings(config: Config) -> FitSettings:
    """How the first strokes are fitted: random ones from far away, an artist's without edits."""
    if config.initialise.reference:
        return replace(config.fit, edits=replace(config.fit.edits, every=0))
    if config.initialise.method == "random":
        return replace(
            config.fit,
            steps=max(config.fit.steps, _RANDOM_STEPS),
            scale=max(config.fit.scale, _RANDOM_SCALE),
            opacity_rate=max(config.fit.opacity_rate, _RANDOM_OPACITY_RATE),
        )
    return config.fit


def walk_settings(config: Config) -> PropagateSettings:
    """How the first strokes are carried: an artist's begin where they were drawn to begin."""
    return replace(config.propagate, move_seams=config.propagate.move_seams and not config.initialise.reference)


def scatter(ink: Ink, count: int, rng: np.random.Generator) -> Strokes:
    """Strokes of one segment, evenly over the page, in any direction.

    Args:
        ink: The ink of one drawing; it only says how large the page is, and of which colours.
        count: How many.
        rng: Where chance comes from.

    Returns:
        S strokes of drawing 0, each of the ink that is nearest to its middle.
    """
    height, width = ink.size
    middle = rng.uniform([0.0, 0.0], [width, height], (count, 2))
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    length = _LENGTH * np.sqrt(height * width / count)
    places = np.linspace(-0.5, 0.5, 4)[:, None] * length
    points = middle[:, None] + places * along[:, None]
    points[:, 1:3] += rng.normal(0.0, _BEND * length, (count, 2, 2))
    column, row = np.clip(middle.astype(np.intp), 0, [width - 1, height - 1]).T
    strokes = Strokes.from_curves(
        list(points),
        [np.full(2, max(0.75, 0.002 * max(ink.size)))] * count,
        color=ink.palette[ink.label[0, row, column]],
    )
    return replace(strokes, opacity=np.full(count, _OPACITY))


def _referenced(ink: Ink, config: Config) -> Strokes:
    """An artist's strokes, moved onto the ink if they lie off it."""
    strokes = read_reference(config.initialise.reference, ink.size)
    nearest = np.linalg.norm(strokes.color[:, None] - ink.palette, axis=2).argmin(axis=1)
    strokes = replace(strokes, color=ink.palette[nearest])
    target = make_target(ink.coverage[0], config.propagate.working_size)
    distance = target.distance_at(strokes.points[::3] * target.scale) / target.scale
    if np.median(distance) <= _NEAR:
        return strokes
    return _registered(strokes, ink, config)


def _registered(strokes: Strokes, ink: Ink, config: Config) -> Strokes:
    """Strokes carried onto the ink as from one drawing of a clip to the next."""
    drawn = draw_coverage(strokes, ink.coverage.shape, resolve_backend(config.render))
    both = replace(ink, coverage=np.concatenate([drawn, ink.coverage]), label=np.repeat(ink.label, 2, axis=0))
    settings: PropagateSettings = config.propagate

    def traced(ink: Ink, drawing: int) -> Strokes:
        return initialise(ink, drawing, config.initialise)

    moved = propagate(both, strokes, settings, traced).strokes.at_drawing(1, as_drawing=0)
    moved = moved.select(np.isin(moved.ids, strokes.ids))
    if len(moved) < _RECOGNISED * len(strokes):
        raise InputError(
            f"{config.initialise.reference}: must show frame {config.initialise.reference_frame} of the clip, "
            f"got a drawing of which {len(moved)} of {len(strokes)} strokes are found there"
        )
    return replace(moved, visible=np.tile([0.0, 1.0], (len(moved), 1)))
