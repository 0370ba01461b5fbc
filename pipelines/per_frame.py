"""The baseline of the field: every drawing vectorised alone, its strokes linked to their neighbours afterwards."""

from videovec.clip import Clip
from videovec.fit import fit, judge
from videovec.initialise import initialise
from videovec.ink import extract_ink
from videovec.link import link
from videovec.opacity import measure_opacity
from videovec.progress import Progress
from videovec.render import resolve_backend
from videovec.settings import Config
from videovec.tracks import StrokeTracks


def run(clip: Clip, config: Config, progress: Progress) -> StrokeTracks:
    """Vectorise each drawing of a clip alone, then link."""
    ink = extract_ink(clip, config.ink, progress)
    drawings = []
    for drawing in range(ink.drawing_count):
        alone = ink.at_drawing(drawing)
        strokes = initialise(alone, 0, config.initialise)
        fitted = fit(alone, strokes, config.fit, config.render, progress).finished()
        drawings.append(fitted.strokes.shifted(drawing))
    strokes = measure_opacity(link(drawings, config.propagate.search_range), ink)
    return StrokeTracks.of(clip, ink, judge(ink, strokes, resolve_backend(config.render)))
