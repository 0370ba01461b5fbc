"""The brushes of a clip: one for all strokes, or one for each ink."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.brush.apply import brush_coverage
from videovec.brush.choose import Evidence
from videovec.brush.fit_brush import BrushFit, fit_brush
from videovec.brush.partings import number_parts, parting_events, wholes_of
from videovec.brushwork import Brushwork, Laying
from videovec.events import Event
from videovec.fit import FitResult, compare
from videovec.ink import Ink, ink_alone
from videovec.progress import Progress
from videovec.settings import BrushSettings
from videovec.strokes import Strokes

__all__ = ["TexturedFit", "fit_brushes"]


@dataclass(frozen=True, slots=True, eq=False)
class TexturedFit:
    """Textured strokes, what draws them, and why.

    Args:
        result: The strokes refined with their brushes, and what the ink says of them.
        brushwork: The brushes, and how they were laid.
        evidence: For each brush, why it is what it is.
        whole: Identity of the stroke given to the fit that each one is, or is a part of. int [S]
    """

    result: FitResult
    brushwork: Brushwork
    evidence: tuple[Evidence, ...]
    whole: NDArray[np.intp]

    def events(self, before: tuple[Event, ...]) -> tuple[Event, ...]:
        """What happened to the strokes, from what happened to those given to the fit."""
        return parting_events(self.result.strokes, self.whole, self.result.evidence.support, before)


def fit_brushes(
    ink: Ink, strokes: Strokes, settings: BrushSettings, progress: Progress | None = None, seed: int = 0
) -> TexturedFit:
    """Learn the brushes that draw a clip.

    Args:
        ink: D drawings, textured.
        strokes: A solid fit of them.
        settings: How brushes are learned, and whether inks share one.
        progress: Told of the steps.
        seed: Of shuffling and grain.

    Returns:
        Refined strokes, ink by ink where every ink has its brush, and their brushwork.

    Raises:
        FitError: There are no strokes.
    """
    label = np.linalg.norm(strokes.color[:, None] - ink.palette, axis=2).argmin(axis=1)
    inks = np.unique(label)
    if settings.share == "clip" or len(inks) < 2:
        shares = [(ink, strokes)]
    else:
        shares = [(ink_alone(ink, int(one)), strokes.select(label == one)) for one in inks]
    fits = [fit_brush(seen, given, settings, progress, seed) for seen, given in shares]
    refined = Strokes.empty()
    for fit, (_, given) in zip(fits, shares, strict=True):
        highest = max([int(strokes.ids.max()), *refined.ids.tolist()])
        refined = Strokes.concatenate([refined, number_parts(fit.strokes, given, highest)])
    brushes = [
        replace(fit.brush, name=f"{fit.brush.name}_{k + 1}" if k else fit.brush.name) for k, fit in enumerate(fits)
    ]
    brushwork = Brushwork(tuple(brushes), _chosen(fits), _together([fit.laying for fit in fits]))
    drawn = brush_coverage(brushwork, refined, ink.coverage.shape)
    evidence = tuple(fit.evidence for fit in fits)
    return TexturedFit(compare(ink, refined, drawn), brushwork, evidence, wholes_of(refined, strokes))


def _chosen(fits: list[BrushFit]) -> NDArray[np.intp]:
    return np.repeat(np.arange(len(fits)), [len(fit.strokes) for fit in fits])


def _together(layings: list[Laying]) -> Laying:
    return Laying(
        *(
            np.concatenate(parts)
            for parts in zip(*((one.sign, one.phase, one.density, one.shift) for one in layings), strict=True)
        )
    )
