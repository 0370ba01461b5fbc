"""A life that is being followed from drawing to drawing, and what is remembered of how it went."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from videovec.propagate.momentum import PATIENCE, affine_part
from videovec.propagate.nodes import Basis, basis_of
from videovec.propagate.record import Life

__all__ = ["Follower", "follow"]

Floats = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Follower:
    """A life that is being followed.

    Args:
        life: Its rows so far.
        basis: Its nodes.
        shape: Where its nodes would be without sudden short bends; see `recall`. [n, 2] px
        velocity: How each node moved in the last step. [n, 2] working px
        unseen: For how many drawings nothing was seen of it.
        drift: How each node would go on; what an affine map says of the last step in which the stroke was told apart.
            [n, 2] working px
        waited: For how many drawings it has not been told apart from others; at first it may never have been.
        open: Where its nodes would be if it were not squeezed; none of a stroke that is not closed. [n, 2] px
    """

    life: Life
    basis: Basis
    shape: Floats
    velocity: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    unseen: int = 0
    drift: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    waited: int = PATIENCE
    open: Floats | None = None

    def half_width(self, drawing: int) -> float:
        """Mean half-width on a drawing. px"""
        return float(self.life.rows[drawing].half_width.mean())

    def go_on(self, now: Floats, before: Floats, is_blind: bool) -> None:
        """Remember how it went: while the ink says little of it, as before, but for where it is as a whole.

        Args:
            now: Its nodes. [n, 2] working px
            before: Where they were. [n, 2] working px
            is_blind: Whether the ink says little of it.
        """
        step = now - before
        if is_blind:
            self.drift = self.drift + step.mean(axis=0) - self.drift.mean(axis=0)
        else:
            self.drift = affine_part(now, step)


def follow(life: Life, drawing: int, spacing: float, scale: float = 1.0, before: int | None = None) -> Follower:
    """Begin to follow a life from one of its drawings.

    Args:
        life: The life.
        drawing: One on which it has a row.
        spacing: Distance between its nodes. px
        scale: Working px for each px.
        before: The drawing that was walked over last; if the life has a row there, it goes on from there.
    """
    points = life.rows[drawing].points
    basis = basis_of(points, spacing, life.is_closed)
    shape, still = basis.weights @ points, np.zeros((len(basis.u), 2))
    velocity = scale * (shape - basis.weights @ life.rows[before].points) if before in life.rows else still
    return Follower(life, basis, shape, velocity, drift=still, open=shape if life.is_closed else None)
