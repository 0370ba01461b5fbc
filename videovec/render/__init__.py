"""The differentiable 2D Gaussian renderer of strokes, in closed form."""

from videovec.render.backend import Backend, resolve_backend
from videovec.render.fused import CoverageMatch, coverage_loss_and_gradients
from videovec.render.image import composite, render_image
from videovec.render.pairs import PairList, list_pairs
from videovec.render.scene import Scene

__all__ = [
    "Backend",
    "CoverageMatch",
    "PairList",
    "Scene",
    "composite",
    "coverage_loss_and_gradients",
    "list_pairs",
    "render_image",
    "resolve_backend",
]
