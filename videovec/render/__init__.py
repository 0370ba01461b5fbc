"""The differentiable 2D Gaussian renderer of strokes, in closed form."""

from videovec.render.backend import Backend, BackendReport, describe_backend, prepare_backend, resolve_backend
from videovec.render.fused import (
    CoverageMatch,
    NormalEquations,
    coverage_loss_and_gradients,
    coverage_normal_equations,
)
from videovec.render.image import composite, render_image
from videovec.render.listing import list_pairs
from videovec.render.pairs import PairList
from videovec.render.scene import Scene

__all__ = [
    "Backend",
    "BackendReport",
    "CoverageMatch",
    "NormalEquations",
    "PairList",
    "Scene",
    "composite",
    "coverage_loss_and_gradients",
    "coverage_normal_equations",
    "describe_backend",
    "list_pairs",
    "prepare_backend",
    "render_image",
    "resolve_backend",
]
