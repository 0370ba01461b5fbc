"""All settings, their defaults and what they mean; presets in ``configs/`` only say what they change.

Lengths are px of the source unless a name says otherwise. Nothing here starts anything: a configuration is data.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from videovec.limits import Between, OneOf

__all__ = [
    "BrushSettings",
    "Config",
    "DecodeSettings",
    "EditSettings",
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

    hold_tolerance: Annotated[float, Between(0)] = 23.0
    """Largest change, over a 9 x 9 px window, that noise is allowed within one drawing. 8-bit levels"""
    frame_rate: Annotated[float, Between(0.01, 1000)] = 24.0
    """Frames per second of numbered images; 23.976 and 29.97 stand for the exact fractions."""


@dataclass(frozen=True, slots=True)
class InkSettings:
    """How page and ink are told apart."""

    flatten: bool = True
    """Divide uneven paper out."""
    samples: int = 12
    """Number of drawings that page, noise and palette are estimated from."""
    least_contrast: float = 0.04
    """Least difference between ink and page. Share of that between white and black"""
    noise_floor: float = 4.0
    """Ink that stands out of the page by no more than this many standard deviations is noise."""


@dataclass(frozen=True, slots=True)
class InitialiseSettings:
    """Where the first strokes come from, and how drawings are traced."""

    method: Annotated[str, OneOf(("trace", "random"))] = "trace"
    """trace finds lines and follows them; random scatters strokes and lets the fit sort them out."""
    strokes: Annotated[int, Between(1)] = 1024
    """Number of random strokes."""
    reference: str = ""
    """An artist's SVG of one frame, whose strokes are taken instead; empty for none."""
    reference_frame: Annotated[int, Between(1)] = 1
    """Which frame it shows, counted from 1."""
    tolerance: Annotated[float, Between(0.01)] = 0.35
    """How far a fitted cubic may lie from the traced centre line. px"""
    junctions: Annotated[str, OneOf(("learned", "geometry"))] = "learned"
    """Which branches of a junction are one stroke: learned asks two small networks that were shown many
    drawings; geometry takes those that turn least."""
    max_turn: Annotated[float, Between(0, 180)] = 100.0
    """Largest turn at which two branches of a junction may be one stroke, by geometry. degrees"""


@dataclass(frozen=True, slots=True)
class PropagateSettings:
    """How strokes are carried from drawing to drawing."""

    memory: Annotated[int, Between(0)] = 8
    """A stroke that regains its ink within this many drawings keeps its identity."""
    search_range: Annotated[float, Between(0)] = 8.0
    """Largest mean distance between strokes of neighbouring drawings that the per_frame pipeline links. px"""
    node_spacing: Annotated[float, Between(1)] = 4.0
    """Distance between the points of a stroke that are matched to the ink. px, when the long edge is working_size"""
    working_size: Annotated[int, Between(64)] = 640
    """Long edge to which larger drawings are shrunk while strokes are matched. px"""
    refine_steps: Annotated[int, Between(0)] = 45
    """Optimiser updates on every drawing after strokes were matched."""
    refine_rigidity: Annotated[float, Between(0)] = 0.5
    """How much strokes keep their shape meanwhile, against the sum of squared coverage errors."""
    patience: Annotated[int, Between(1)] = 24
    """For how many drawings new ink may grow before it becomes a stroke."""
    move_seams: bool = True
    """Closed strokes of which a part is hidden begin anew where they are hidden; an artist's never do."""


@dataclass(frozen=True, slots=True)
class RenderSettings:
    """Which renderer draws the strokes."""

    backend: Annotated[str, OneOf(("auto", "numba", "torch", "reference"))] = "auto"
    """auto, numba, torch or reference."""
    device: str = "auto"
    """auto, cpu, cuda or another torch device."""


@dataclass(frozen=True, slots=True)
class Weights:
    """Weight λ of every term of the fit beside the photometric one, which has 1; one of weight 0 is not evaluated.

    The photometric term is a sum of squares over pixels. The perceptual one is multiplied by the number of pixels,
    those on the shape of segments are summed over segments. The perceptual term is off: on clean line art it makes
    the fit four times as long and lowers LPIPS by a tenth at most.
    """

    perceptual: Annotated[float, Between(0)] = 0.0
    """LPIPS distance between rendered and seen drawing."""
    self_intersection: Annotated[float, Between(0)] = 0.0
    """Segments whose two handles cross."""
    curvature: Annotated[float, Between(0)] = 0.0
    """Bends sharper than the curvature threshold."""
    continuity: Annotated[float, Between(0)] = 0.0
    """Neighbouring segments whose tangents differ at their joint."""
    anchor: Annotated[float, Between(0)] = 1.0
    """Distance of each stroke's first drawing from where it was before the joint fit. px²"""
    acceleration: Annotated[float, Between(0)] = 0.04
    """Second difference in time of control points. px² per frame⁴"""
    rigidity: Annotated[float, Between(0)] = 0.3
    """Neighbouring control points that do not move together."""
    sliding: Annotated[float, Between(0)] = 0.3
    """Distance along its stroke of material from where the stroke's shape at rest has it. px²"""
    width_change: Annotated[float, Between(0)] = 1.0
    """Change in time of half-width."""


@dataclass(frozen=True, slots=True)
class EditSettings:
    """How the strokes of a single drawing are simplified and densified while they are fitted.

    Source:
        Supplement A, "Implementation Details": every 100 steps, 0.01, 1e-5 and 5 px; the units are ours. In 200 steps
        100 leaves one round; a second one, after 67 and 134, gains 1 to 2 dB with as many segments.
    """

    every: Annotated[int, Between(0)] = 67
    """Optimiser updates between two rounds of edits; 0 for none."""
    sigma_min: Annotated[float, Between(0)] = 0.01
    """Strokes of less width (px) or less opacity are dropped."""
    delta_max: Annotated[float, Between(0)] = 1e-5
    """Squared error of ink that no stroke draws, above which it gets one. Share of the page's pixels; where lines are
    thinner than 1 px, times their width"""
    d_min: Annotated[float, Between(0)] = 5.0
    """Length under which a stroke that others cover is dropped, and gap over which two may be joined. px"""
    tolerance: Annotated[float, Between(0.01)] = 0.35
    """How far a line may move when segments are joined or traced. px"""
    price: Annotated[float, Between(0)] = 0.002
    """By how much the sum of squared coverage errors may rise, or must fall, for each control point less or more; a
    stroke less is worth ten. Where lines are thinner than 1 px: times the square of their width."""


@dataclass(frozen=True, slots=True)
class FitSettings:
    """The joint optimisation over all drawings."""

    steps: Annotated[int, Between(0)] = 200
    """Optimiser updates of a drawing that was just initialised."""
    scale: Annotated[float, Between(1)] = 2.0
    """Width of the renderer's kernel at the start of such a fit; it falls to 1. px"""
    opacity_rate: Annotated[float, Between(0)] = 0.0
    """Step of the logit of a stroke's opacity in such a fit; 0 keeps opacities."""
    joint_steps: Annotated[int, Between(0)] = 80
    """Optimiser updates over all drawings, from strokes that were carried there."""
    window: Annotated[int, Between(2)] = 48
    """Drawings that are in memory at once."""
    overlap: Annotated[int, Between(1)] = 6
    """Drawings on either side of a window that are fitted with it and belong to the next."""
    perceptual_every: Annotated[int, Between(1)] = 10
    """Optimiser updates between two evaluations of the perceptual term."""
    weights: Weights = field(default_factory=Weights)
    edits: EditSettings = field(default_factory=EditSettings)


@dataclass(frozen=True, slots=True)
class BrushSettings:
    """How the brush of textured lines is learned."""

    brush: str = ""
    """A brush that is known, a file of an earlier run; empty learns one."""
    model: Annotated[str, OneOf(("auto", "profile", "texture", "grain"))] = "auto"
    """What the brush is taken for: auto, profile, texture or grain."""
    share: Annotated[str, OneOf(("clip", "ink"))] = "clip"
    """Who shares a brush: clip, all strokes; ink, those of one colour."""
    boil: bool = False
    """Whether lines boil: every drawing begins anywhere along the texture."""
    profile_steps: Annotated[int, Between(0)] = 150
    """Optimiser updates of strokes with a profile."""
    texture_steps: Annotated[int, Between(0)] = 200
    """Optimiser updates of strokes with a shared texture."""
    least_width: Annotated[float, Between(0)] = 2.5
    """Strokes of less mean width show too little of their grain to measure it. px"""
    least_grain: Annotated[float, Between(0)] = 0.05
    """Ink that varies less than this inside strokes is smooth."""
    longest_segment: Annotated[float, Between(0.5)] = 4.0
    """Longer segments are halved, so that width and density can vary. widths"""
    shortest_repeat: Annotated[float, Between(0.5)] = 4.0
    """Shortest repeat of a texture. widths"""
    longest_repeat: Annotated[float, Between(0.5)] = 40.0
    """Longest repeat of a texture. widths"""
    texture_margin: Annotated[float, Between(0, 1)] = 0.07
    """A texture must explain this much more of held-out strokes than of shuffled ones."""
    lean_share: Annotated[float, Between(0, 1)] = 0.12
    """A one-sided profile must explain this share of the grain of held-out strokes."""


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """What is written."""

    svg_style: Annotated[str, OneOf(("auto", "stroke", "outline", "powerstroke"))] = "auto"
    """auto, stroke, outline or powerstroke."""
    line_tolerance: Annotated[float, Between(0)] = 0.25
    """A stroke is written as a line of its mean width where that draws 95 % of its edge within this. px"""
    lottie_tolerance: Annotated[float, Between(0)] = 0.25
    """How far a stroke between reduced and rounded keyframes may lie from the fitted one. px"""
    lottie_decimals: Annotated[int, Between(0, 6)] = 1
    """Decimals of a coordinate."""
    texture: Annotated[str, OneOf(("mean", "image"))] = "mean"
    """How SVG frames and Lottie show textured strokes: mean, even ink of the same density; image, embedded pixels."""
    lottie_smooth: bool = False
    """Move evenly through held drawings instead of stepping from one to the next as the source does."""


@dataclass(frozen=True, slots=True)
class Config:
    """Everything that a run can be told."""

    pipeline: str = "solid"
    """Name of a file in ``pipelines/``."""
    seed: Annotated[int, Between(0)] = 0
    """Seed of all randomness."""
    decode: DecodeSettings = field(default_factory=DecodeSettings)
    ink: InkSettings = field(default_factory=InkSettings)
    initialise: InitialiseSettings = field(default_factory=InitialiseSettings)
    propagate: PropagateSettings = field(default_factory=PropagateSettings)
    render: RenderSettings = field(default_factory=RenderSettings)
    fit: FitSettings = field(default_factory=FitSettings)
    brush: BrushSettings = field(default_factory=BrushSettings)
    export: ExportSettings = field(default_factory=ExportSettings)
