"""Learned brushes: what textured lines are drawn with, learned from drawings, applied to strokes, given to artists."""

from videovec.brush.apply import apply_brush, solid_strokes
from videovec.brush.choose import Evidence
from videovec.brush.detect import TextureEvidence, looks_textured
from videovec.brush.export_brush import export_brush
from videovec.brush.fit_brush import BrushFit, fit_brush
from videovec.brush.model import Brush, BrushModel, Laying
from videovec.brush.solidify import solidify
from videovec.brush.storage import load_brush

__all__ = [
    "Brush",
    "BrushFit",
    "BrushModel",
    "Evidence",
    "Laying",
    "TextureEvidence",
    "apply_brush",
    "export_brush",
    "fit_brush",
    "load_brush",
    "looks_textured",
    "solid_strokes",
    "solidify",
]
