"""Learned brushes: what textured lines are drawn with, learned from drawings, applied to strokes, given to artists."""

from videovec.brush.apply import apply_brush, brush_coverage, draw_brushwork, solid_strokes, stroke_marks
from videovec.brush.bridge import bridge
from videovec.brush.choose import Evidence
from videovec.brush.detect import TextureEvidence, looks_textured, propose_textured
from videovec.brush.export_brush import brush_files, export_brush
from videovec.brush.fit_brush import BrushFit, fit_brush
from videovec.brush.fit_brushes import TexturedFit, fit_brushes
from videovec.brush.mend import mend
from videovec.brush.scraps import drop_scraps
from videovec.brush.solidify import solidify
from videovec.brush.storage import load_brush
from videovec.brushwork import Brush, BrushModel, Brushwork, Laying

__all__ = [
    "Brush",
    "BrushFit",
    "BrushModel",
    "Brushwork",
    "Evidence",
    "Laying",
    "TextureEvidence",
    "TexturedFit",
    "apply_brush",
    "bridge",
    "brush_coverage",
    "brush_files",
    "draw_brushwork",
    "drop_scraps",
    "export_brush",
    "fit_brush",
    "fit_brushes",
    "load_brush",
    "looks_textured",
    "mend",
    "propose_textured",
    "solid_strokes",
    "solidify",
    "stroke_marks",
]
