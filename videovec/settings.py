"""All settings, their defaults and what they mean; presets in ``configs/`` only say what they change.

Lengths are px of the source unless a name says otherwise. Nothing here starts anything: a configuration is data.
"""

from __future__ import annotations

from dataclasses import dataclass, field

__all__ = [
    "Config",
    "DecodeSettings",
    "ExportSettings",
    "FitSettings",
    "InitialiseSettings",
    "InkSettings",
    "PropagateSettings",
    "RenderSettings",
    "Weights",
]


@dataclass(frozen=True, slots=True)
class DecodeSettings:
    """How frames are read and which of them are the same drawing."""

    hold_tolerance: float = 4.0
    """Frames that differ by no more than this many noise levels are one drawing."""


@dataclass(frozen=True, slots=True)
class InkSettings:
    """How page and ink are told apart."""

    flatten: bool = True
    """Divide uneven paper out."""


@dataclass(frozen=True, slots=True)
class InitialiseSettings:
    """How strokes are traced on one drawing."""

    tolerance: float = 0.35
    """How far a fitted cubic may lie from the traced centre line. px"""
    max_turn: float = 100.0
    """Largest turn at which two branches of a junction may be one stroke. degrees"""


@dataclass(frozen=True, slots=True)
class PropagateSettings:
    """How strokes are carried from drawing to drawing."""

    memory: int = 8
    """A stroke that regains its ink within this many drawings keeps its identity."""


@dataclass(frozen=True, slots=True)
class RenderSettings:
    """Which renderer draws the strokes."""

    backend: str = "auto"
    """auto, numba, torch or reference."""
    device: str = "auto"
    """auto, cpu, cuda or another torch device."""


@dataclass(frozen=True, slots=True)
class Weights:
    """Weight λ of every term of the fit; a term of weight 0 is not evaluated."""

    photometric: float = 1.0
    perceptual: float = 0.0
    self_intersection: float = 0.0
    curvature: float = 0.0
    continuity: float = 0.0
    acceleration: float = 0.0
    rigidity: float = 0.0
    width_change: float = 0.0


@dataclass(frozen=True, slots=True)
class FitSettings:
    """The joint optimisation over all drawings."""

    steps: int = 200
    """Number of optimiser updates."""
    weights: Weights = field(default_factory=Weights)


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """What is written."""

    svg_style: str = "auto"
    """auto, stroke, outline or powerstroke."""
    lottie_tolerance: float = 0.25
    """How far a reduced keyframe curve may lie from the fitted one. px"""


@dataclass(frozen=True, slots=True)
class Config:
    """Everything that a run can be told."""

    pipeline: str = "solid"
    """Name of a file in ``pipelines/``."""
    seed: int = 0
    """Seed of all randomness."""
    decode: DecodeSettings = field(default_factory=DecodeSettings)
    ink: InkSettings = field(default_factory=InkSettings)
    initialise: InitialiseSettings = field(default_factory=InitialiseSettings)
    propagate: PropagateSettings = field(default_factory=PropagateSettings)
    render: RenderSettings = field(default_factory=RenderSettings)
    fit: FitSettings = field(default_factory=FitSettings)
    export: ExportSettings = field(default_factory=ExportSettings)
