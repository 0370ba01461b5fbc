"""Masks and their skeletons: where the ink's ridges are, one pixel wide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.compiling import compiled

__all__ = ["thin"]

Mask = NDArray[np.uint8]

# The eight neighbours of a pixel, clockwise from above: p2 .. p9 of the paper.
_ROW = np.array([-1, -1, 0, 1, 1, 1, 0, -1])
_COLUMN = np.array([0, 1, 1, 1, 0, -1, -1, -1])


def _deletable() -> NDArray[np.bool_]:
    """Which neighbourhoods let their pixel go, for each of the two subiterations. bool [2, 256]"""
    codes = np.arange(256)
    p2, p3, p4, p5, p6, p7, p8, p9 = ((codes >> bit) & 1 == 1 for bit in range(8))
    crossings = sum((~a & (b | c)).astype(int) for a, b, c in ((p2, p3, p4), (p4, p5, p6), (p6, p7, p8), (p8, p9, p2)))
    one = sum((a | b).astype(int) for a, b in ((p9, p2), (p3, p4), (p5, p6), (p7, p8)))
    two = sum((a | b).astype(int) for a, b in ((p2, p3), (p4, p5), (p6, p7), (p8, p9)))
    count = np.minimum(one, two)
    simple = (crossings == 1) & (count >= 2) & (count <= 3)
    return np.stack([simple & ~((p6 | p7 | ~p9) & p8), simple & ~((p2 | p3 | ~p5) & p4)])


@compiled()
def _peel(mask: Mask, deletable: NDArray[np.bool_], row: NDArray[np.int64], column: NDArray[np.int64]) -> None:
    """Remove layer after layer in place; only pixels whose surroundings changed are looked at again."""
    queued = np.zeros(mask.shape, np.bool_)
    border = np.empty((mask.size, 2), np.int32)
    count = 0
    for y in range(1, mask.shape[0] - 1):
        for x in range(1, mask.shape[1] - 1):
            if mask[y, x]:
                for k in range(8):
                    if not mask[y + row[k], x + column[k]]:
                        border[count, 0], border[count, 1] = y, x
                        queued[y, x] = True
                        count += 1
                        break
    gone = np.empty(mask.size, np.int32)
    idle = 0
    step = 0
    while idle < 2:
        removed = 0
        for i in range(count):
            y, x = border[i]
            code = np.int64(0)
            for k in range(8):
                code |= np.int64(mask[y + row[k], x + column[k]]) << k
            if deletable[step % 2, code]:
                gone[removed] = i
                removed += 1
        for j in range(removed):
            y, x = border[gone[j]]
            mask[y, x] = 0
        for j in range(removed):
            y, x = border[gone[j]]
            for k in range(8):
                v, u = y + row[k], x + column[k]
                if mask[v, u] and not queued[v, u] and 0 < v < mask.shape[0] - 1 and 0 < u < mask.shape[1] - 1:
                    border[count, 0], border[count, 1] = v, u
                    queued[v, u] = True
                    count += 1
        kept = 0
        for i in range(count):
            if mask[border[i, 0], border[i, 1]]:
                border[kept] = border[i]
                kept += 1
        count = kept
        idle = 0 if removed else idle + 1
        step += 1


def thin(mask: Mask) -> Mask:
    """Reduce a mask to its skeleton, one pixel wide and as connected as the mask.

    Args:
        mask: Non-zero where there is ink. [H, W]

    Returns:
        1 on the skeleton, 0 elsewhere. uint8 [H, W]

    Source:
        Guo and Hall 1989, "Parallel thinning with two-subiteration algorithms", algorithm A1.
    """
    padded = np.pad((mask > 0).astype(np.uint8), 1)
    _peel(padded, _deletable(), _ROW, _COLUMN)
    return padded[1:-1, 1:-1].copy()
