"""A brush as GIMP tips: one dab (``.gbr``, version 2) and a pipe of overlapping dabs (``.gih``).

GIMP stamps; it cannot bend a strip. The pipe comes close: cell k shows the strip around u_k = k W/4 under a raised
cosine. The cosines of neighbouring cells sum to 1, and each is an exponent of clearness, 1 - (1 - T)^w, so that dabs
laid over one another a quarter of a width apart give the strip back exactly on a straight line along +x. On curves the
grain keeps its place along the stroke but does not turn with it: an approximation.

Source of the formats: GIMP's ``devel-docs/gbr.txt`` and ``gih.txt``.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from videovec.brushwork import SUPPORT, Brush

__all__ = ["CELL", "dab_cells", "gbr_tip", "gih_pipe"]

Floats = NDArray[np.float64]

CELL = 80  # px, side of a cell; a quarter of a width is 16 px of it
_CELL_WIDTHS = 1.25  # widths across a cell
_STEP = 0.25  # widths from dab to dab
_SPACING = round(100 * _STEP / _CELL_WIDTHS)  # percent of a cell


def dab_cells(brush: Brush) -> Floats:
    """Cells whose dabs, a quarter of a width apart and laid over one another, are the strip. [K, 80, 80] in [0, 1]"""
    count = max(round(brush.repeat / _STEP), 1)
    offset = ((np.arange(CELL) + 0.5) / CELL - 0.5) * _CELL_WIDTHS  # widths from the cell's centre
    u = (np.arange(count)[:, None] / count + offset / brush.repeat) % 1.0
    columns, rows = brush.strip.shape
    x, y = u * columns - 0.5, (2 * offset / SUPPORT + 1) / 2 * rows - 0.5
    left = np.floor(x).astype(np.intp)
    share = (x - left)[..., None]
    along = (1 - share) * brush.strip[left % columns] + share * brush.strip[(left + 1) % columns]  # [K, 80, V]
    across = np.clip(np.floor(y).astype(np.intp), -1, rows - 1)
    padded = np.pad(along, ((0, 0), (0, 0), (1, 1)))
    part = np.clip(y - across, 0, 1)
    ink = (1 - part) * padded[:, :, across + 1] + part * padded[:, :, across + 2]
    weight = np.where(np.abs(offset) < 0.5, _STEP * (1 + np.cos(2 * np.pi * offset)), 0.0)
    cells = 1 - (1 - np.clip(ink, 0, 1 - 1e-4)) ** weight[None, :, None]
    return np.asarray(cells.transpose(0, 2, 1))


def gbr_tip(cell: Floats, name: str, spacing: int = _SPACING) -> bytes:
    """One tip [H, W] as a GIMP brush of version 2, 8 bit."""
    height, width = cell.shape
    title = name.encode("utf-8") + b"\0"
    header = struct.pack(">5I4sI", 28 + len(title), 2, width, height, 1, b"GIMP", spacing)
    return header + title + np.round(cell * 255).astype(np.uint8).tobytes()


def gih_pipe(brush: Brush) -> bytes:
    """The strip as a GIMP brush pipe whose cells come one after the other."""
    cells = dab_cells(brush)
    count = len(cells)
    head = (
        f"{brush.name}\n{count} ncells:{count} cellwidth:{CELL} cellheight:{CELL} step:{_SPACING} dim:1 cols:1 rows:1 "
        f"placement:constant rank0:{count} sel0:incremental\n"
    )
    return head.encode() + b"".join(gbr_tip(cell, f"{brush.name} {k + 1}") for k, cell in enumerate(cells))
