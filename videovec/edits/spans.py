"""One cubic in the place of two neighbouring ones, for many pairs at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from videovec.curves import derivative, evaluate

__all__ = ["span"]

Floats = NDArray[np.float64]

_SAMPLES = 12  # on each of the two cubics
_ROUNDS = 6  # of Gauss and Newton
_STIFF = 1e3  # how much a handle resists leaving its direction, against the mean squared distance
_DAMPING = 1e-4


def span(before: Floats, after: Floats, is_held: NDArray[np.bool_]) -> tuple[Floats, Floats, Floats]:
    """Fit a cubic to each pair of neighbouring cubics, by distances along its normal.

    Two cubics that are parts of one give that one: it is where the fit starts.

    Args:
        before: The first of each pair. [B, 4, 2] px
        after: The second, which begins where the first ends. [B, 4, 2] px
        is_held: Whether the direction at the beginning, and at the end, must stay. bool [B, 2]

    Returns:
        The cubics [B, 4, 2] px, the distances of samples from them [B, M] px, and the arc that each sample stands
        for [B, M] px.
    """
    one, two = (np.linalg.norm(leg, axis=-1) for leg in (before[:, 3] - before[:, 2], after[:, 1] - after[:, 0]))
    share = np.clip(one / np.maximum(one + two, 1e-9), 0.05, 0.95)[:, None]
    cubic = np.stack(
        [
            before[:, 0],
            before[:, 0] + (before[:, 1] - before[:, 0]) / share,
            after[:, 3] + (after[:, 2] - after[:, 3]) / (1.0 - share),
            after[:, 3],
        ],
        axis=1,
    )
    local = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    samples = np.concatenate([evaluate(part[:, None], local[None]) for part in (before, after)], axis=1)
    arcs = [np.linalg.norm(derivative(part[:, None], local[None]), axis=-1) / _SAMPLES for part in (before, after)]
    t = np.concatenate([share * local, share + (1.0 - share) * local], axis=1)
    across = _normals(cubic[:, 1:3] - cubic[:, [0, 3]])  # [B, 2, 2]
    stiff = _STIFF * is_held[..., None, None] * across[..., :, None] * across[..., None, :]  # [B, 2, 2, 2]
    for _ in range(_ROUNDS):
        t = _nearest(cubic, samples, t)
        cubic = _improved(cubic, samples, t, stiff)
    t = _nearest(cubic, samples, t)
    return cubic, np.linalg.norm(evaluate(cubic[:, None], t) - samples, axis=-1), np.concatenate(arcs, axis=1)


def _improved(cubic: Floats, samples: Floats, t: Floats, stiff: Floats) -> Floats:
    """One Gauss-Newton step of the two handles, on distances along the normal."""
    normal = _normals(derivative(cubic[:, None], t))
    off = ((samples - evaluate(cubic[:, None], t)) * normal).sum(axis=-1)
    basis = np.stack([3.0 * t * (1.0 - t) ** 2, 3.0 * t**2 * (1.0 - t)], axis=-1)
    rows = (basis[..., None] * normal[..., None, :]).reshape(*t.shape, 4)
    system = np.einsum("bmi,bmj->bij", rows, rows) / t.shape[1] + _DAMPING * np.eye(4)
    system[:, :2, :2] += stiff[:, 0]
    system[:, 2:, 2:] += stiff[:, 1]
    right = np.einsum("bmi,bm->bi", rows, off) / t.shape[1]
    moved = np.linalg.solve(system, right[..., None])[..., 0].reshape(-1, 2, 2)
    result = cubic.copy()
    result[:, 1:3] += moved
    return result


def _nearest(cubic: Floats, samples: Floats, t: Floats) -> Floats:
    """One Newton step of every sample's parameter."""
    slope = derivative(cubic[:, None], t)
    gap = ((evaluate(cubic[:, None], t) - samples) * slope).sum(axis=-1)
    return np.asarray(np.clip(t - gap / np.maximum(np.square(slope).sum(axis=-1), 1e-9), 0.0, 1.0))


def _normals(vectors: Floats) -> Floats:
    turned = np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)
    return np.asarray(turned / np.maximum(np.linalg.norm(turned, axis=-1, keepdims=True), 1e-9))
