"""Which branches of a junction are one stroke, by the vote of all drawings on which it is seen."""

from __future__ import annotations

from videovec.vote.poll import vote

__all__ = ["vote"]
