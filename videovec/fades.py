"""Lines that fade: inks of the palette that are another ink on its way in or out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["find_fades"]

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

_OFF = 0.04
"""Distance from the straight way between page and an ink, as a share of it, up to which a colour is a share of it."""
_STEP = 0.06
"""Change of the share between two drawings that is a fade."""
_FULL = 230
"""Coverage of pixels that show their ink whole, of 255."""
_FEWEST = 40
"""Pixels of an ink on one drawing that can tell whether it fades."""
_FADING = 0.35
"""Share of them that must fade at once; less may be where another line moves over them."""


def find_fades(inks: Floats, label: Bytes, coverage: Bytes) -> dict[int, int]:
    """Inks that are shares of stronger ones, and that change to other shares where they are.

    Args:
        inks: Difference of each ink from the page. [I, 3]
        label: Ink of each pixel. uint8 [D, H, W]
        coverage: Share of that ink. uint8 [D, H, W]

    Returns:
        For each ink that fades, the one whose share it is.
    """
    whole, level = _shares(inks)
    weak = [i for i in range(len(inks)) if whole[i] != i]
    drawings = range(len(label))
    return {i: int(whole[i]) for i in weak if any(_fades_at(label, coverage, (i, d), level, whole) for d in drawings)}


def _shares(inks: Floats) -> tuple[NDArray[np.intp], Floats]:
    """The strongest ink of which each is a share, itself if there is none, and the share. int [I], [I]"""
    strength = np.linalg.norm(inks, axis=1)
    whole, level = np.arange(len(inks)), np.ones(len(inks))
    order = np.argsort(-strength, kind="stable").tolist()
    for place, i in enumerate(order):
        for j in order[:place]:
            share = float(inks[i] @ inks[j]) / float(inks[j] @ inks[j])
            if whole[j] == j and np.linalg.norm(inks[i] - share * inks[j]) <= _OFF * strength[j]:
                whole[i], level[i] = j, share
                break
    return whole, level


def _fades_at(label: Bytes, coverage: Bytes, where: tuple[int, int], level: Floats, whole: NDArray[np.intp]) -> bool:
    """Whether most pixels of an ink on a drawing show another share of the same ink one drawing before or after."""
    weak, drawing = where
    mask = (label[drawing] == weak) & (coverage[drawing] >= _FULL)
    count = int(mask.sum())
    if count < _FEWEST:
        return False
    for other in (drawing - 1, drawing + 1):
        if 0 <= other < len(label):
            there = label[other][mask]
            share = level[there] * coverage[other][mask] / 255.0
            changed = (whole[there] == whole[weak]) & (share > _STEP) & (np.abs(share - level[weak]) > _STEP)
            if changed.sum() >= _FADING * count:
                return True
    return False
