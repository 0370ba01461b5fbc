"""Edits of one drawing's strokes while they are fitted: fewer where nothing is lost, more where ink is left over."""

from __future__ import annotations

from videovec.edits.apply import complete, edit, finish

__all__ = ["complete", "edit", "finish"]
