"""Learned brushes: what textured lines are drawn with, learned from drawings, applied to strokes, given to artists."""

from videovec.brush.fit_brush import BrushFit, fit_brush
from videovec.brush.model import Brush, BrushModel, Laying

__all__ = ["Brush", "BrushFit", "BrushModel", "Laying", "fit_brush"]
