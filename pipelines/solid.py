"""Solid line art: trace the first drawing, carry its strokes through the clip, vote on junctions, fit all together."""

from functools import partial

from videovec.brush import propose_textured
from videovec.clip import Clip
from videovec.edits import complete
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.ink import extract_ink
from videovec.opacity import measure_opacity
from videovec.progress import Progress
from videovec.propagate import propagate
from videovec.settings import Config
from videovec.start import first_strokes, start_drawing, start_settings, walk_settings
from videovec.tracks import StrokeTracks
from videovec.vote import vote


def run(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
    """Vectorise a clip whose lines are solid."""
    ink = extract_ink(clip, config.ink, progress)
    propose_textured(ink, progress)
    trace = partial(initialise, settings=config.initialise)
    seed = start_drawing(clip, ink, config.initialise)
    begun = first_strokes(ink, seed, config)
    first = fit(ink.at_drawing(seed), begun, start_settings(config), config.render, progress)
    if ink.drawing_count == 1:
        return StrokeTracks.of(clip, ink, first)
    strokes = first.finished().strokes
    if config.initialise.reference:  # what an artist left out gets strokes of its own, as new ink does later on
        strokes = complete(strokes, ink.at_drawing(seed), config.fit.edits)
    carried = propagate(ink, strokes.shifted(seed), walk_settings(config), trace, progress)
    if not config.initialise.reference:  # an artist's strokes stay as they were drawn
        carried = vote(ink, carried, seed, trace, progress)
    result = fit(ink, measure_opacity(carried.strokes, ink), config.fit, config.render, progress)
    return StrokeTracks.of(clip, ink, result, carried.events)
