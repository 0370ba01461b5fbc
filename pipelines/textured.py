"""Textured line art: strokes of the ink made solid, carried through the clip, then the brush that drew them."""

from functools import partial

from videovec.brush import bridge, drop_scraps, fit_brushes, mend, solidify
from videovec.clip import Clip
from videovec.fit import fit
from videovec.initialise import initialise
from videovec.ink import extract_ink
from videovec.progress import Progress
from videovec.propagate import propagate
from videovec.settings import Config
from videovec.start import first_strokes, start_drawing, start_settings, walk_settings
from videovec.tracks import StrokeTracks
from videovec.vote import vote


def run(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
    """Vectorise a clip whose lines are drawn with a brush."""
    ink = extract_ink(clip, config.ink, progress)
    solid = solidify(ink)
    trace = partial(initialise, settings=config.initialise)
    seed = start_drawing(clip, ink, config.initialise)
    begun = first_strokes(solid, seed, config)
    if not config.initialise.reference:  # an artist's strokes stay as they were drawn
        begun = mend(begun, solid.at_drawing(seed), config.fit.edits)
    first = fit(solid.at_drawing(seed), begun, start_settings(config), config.render, progress)
    strokes = first.finished().strokes
    if not config.initialise.reference:
        strokes = bridge(drop_scraps(strokes), ink.at_drawing(seed), config.fit.edits)
    carried = propagate(solid, strokes.shifted(seed), walk_settings(config), trace, progress)
    if not config.initialise.reference:
        carried = vote(solid, carried, seed, trace, progress)
    strokes = carried.strokes
    if ink.drawing_count > 1:  # a still was fitted already
        strokes = fit(solid, strokes, config.fit, config.render, progress).finished().strokes
    textured = fit_brushes(ink, strokes, config.brush, progress, config.seed)
    return StrokeTracks.of(clip, ink, textured.result, textured.events(carried.events), textured.brushwork)
