"""Gaps in the middle of a stroke: an eraser or something narrow went over it, and both sides are still seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Piece", "find_pieces", "find_ring_pieces", "nodes_of", "runs"]

Bools = NDArray[np.bool_]

Piece = tuple[int, int]
"""First and last node of a run that is seen, counted within its stroke."""

_BARE = 2
"""Nodes on bare paper in the shortest gap."""
_RUN = 3
"""Nodes of the shortest run that is seen."""
_ISLAND = 1.6
"""Widths up to which ink between two gaps is of what made them: a line that crosses with bare paper at its sides."""
_OWN = 0.3
"""Share of the nodes of a run that must be the nearest of some ink."""
_BEYOND = 0.6
"""The same for a run beyond what would be seen without gaps."""


def find_pieces(main: Piece, inked: Bools, bare: Bools, chosen: Bools, width: float) -> list[Piece]:
    """The runs of a stroke that are seen.

    Args:
        main: Where it is seen if it has no gap; none of it if the last is before the first.
        inked: Which nodes lie on ink. bool [n]
        bare: Which lie on bare paper. bool [n]
        chosen: Which are the nearest of some ink. bool [n]
        width: Of the stroke. Nodes

    Returns:
        One run or more in their order; none if the stroke is not seen.
    """
    if main[1] < main[0]:
        return []
    shown = _without_islands(_without_short_gaps(inked & ~bare, bare), width)
    seen = [run for run in runs(shown) if _is_seen(run, main, chosen)]
    if len(seen) < 2:
        return [main]
    seen[0] = min(seen[0][0], main[0]), seen[0][1]
    seen[-1] = seen[-1][0], max(seen[-1][1], main[1])
    return seen


def find_ring_pieces(main: Piece, inked: Bools, bare: Bools, chosen: Bools, width: float) -> list[Piece]:
    """The runs of a closed stroke that are seen: as of one that is opened in the middle of its longest gap.

    Args:
        main: See `find_pieces`, as for all others; what is seen without a gap may be all of it.
        inked: bool [n]
        bare: bool [n]
        chosen: bool [n]
        width: Nodes

    Returns:
        One run or more; one that goes over the seam ends after n - 1, with n the first node again.
    """
    if main[1] < main[0]:
        return []
    count, turn = len(inked), _in_longest_gap(inked & ~bare, bare)
    if turn is None:
        return [main]
    inked, bare, chosen = (np.roll(values, -turn) for values in (inked, bare, chosen))
    at = np.arange(count) + turn
    is_main = (at % count >= main[0]) & (at % count <= main[1])
    shown = _without_islands(_without_short_gaps(inked & ~bare, bare), width)
    seen = []
    for first, last in runs(shown):
        least = _OWN if is_main[first : last + 1].any() else _BEYOND
        if last - first + 1 >= _RUN and chosen[first : last + 1].mean() >= least:
            over = count if first + turn >= count else 0
            seen.append((first + turn - over, last + turn - over))
    return seen or [main]


def nodes_of(piece: Piece, count: int) -> NDArray[np.intp]:
    """The nodes of a run of a stroke that has so many."""
    return np.arange(piece[0], piece[1] + 1) % count


def _in_longest_gap(inked: Bools, bare: Bools) -> int | None:
    """A node in the middle of the longest gap of a closed stroke that shows paper; none if there is no such gap."""
    count = len(inked)
    start = int(np.argmax(inked))  # on ink, so that no gap goes over the end
    gaps = [gap for gap in runs(~np.roll(inked, -start)) if np.roll(bare, -start)[gap[0] : gap[1] + 1].sum() >= _BARE]
    if not gaps:
        return None
    first, last = max(gaps, key=lambda gap: gap[1] - gap[0])
    return (start + (first + last) // 2) % count


def _is_seen(run: Piece, main: Piece, chosen: Bools) -> bool:
    first, last = run
    is_beyond = last < main[0] or first > main[1]
    at_end = first == 0 or last == len(chosen) - 1
    own = float(chosen[first : last + 1].mean())
    return (last - first + 1 >= _RUN or (at_end and not is_beyond)) and own >= (_BEYOND if is_beyond else _OWN)


def _without_short_gaps(inked: Bools, bare: Bools) -> Bools:
    """Nodes on ink, and those in gaps that show too little paper to be any."""
    filled = inked.copy()
    for first, last in runs(~inked):
        is_inner = first > 0 and last < len(inked) - 1
        if is_inner and bare[first : last + 1].sum() < _BARE:
            filled[first : last + 1] = True
    return filled


def _without_islands(inked: Bools, width: float) -> Bools:
    """Nodes on ink, without short runs between two gaps."""
    left = inked.copy()
    for first, last in runs(inked):
        is_inner = first > 0 and last < len(inked) - 1
        if is_inner and last - first + 1 <= _ISLAND * width:
            left[first : last + 1] = False
    return left


def runs(values: Bools) -> list[Piece]:
    """First and last place of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], values.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True))
