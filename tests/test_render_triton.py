"""The GPU's kernels against the CPU's: on a GPU where there is one, else run by Triton's interpreter."""

from __future__ import annotations

import os
from dataclasses import fields, replace
from typing import Any, TypeVar

import pytest
import torch
from test_render import SCENES, distance, in_precision
from torch import Tensor

from videovec.render import CoverageMatch, PairList, Scene, coverage_loss_and_gradients, list_pairs
from videovec.render.pairs import Chunks

T = TypeVar("T", Scene, PairList, Chunks)

FIELDS = ("loss", "value", "control", "half_width", "interval", "opacity")
DEVICE = "cpu" if os.environ.get("TRITON_INTERPRET") == "1" else "cuda"


def match(scene: Scene, pairs: PairList, scale: float, target: Tensor, extra: Tensor | None = None) -> CoverageMatch:
    """`match_with_triton` where its kernels run, on a copy of what changes in place."""
    from videovec.render.triton_match import match_with_triton

    there = _moved(scene)
    listed = replace(_moved(pairs), chunks=_moved(pairs.chunks))
    added = None if extra is None else extra.to(DEVICE)
    found = match_with_triton(there, listed, scale, target.to(DEVICE), added)
    pairs.t.copy_(listed.t)
    return CoverageMatch(*(values.cpu() for values in found))


def _moved(record: T) -> T:
    """A record whose tensors lie on the device of the kernels."""
    values = {field.name: getattr(record, field.name) for field in fields(record)}
    moved: dict[str, Any] = {name: v.to(DEVICE) for name, v in values.items() if isinstance(v, Tensor)}
    return replace(record, **moved)


@pytest.mark.parametrize("with_extra", [False, True])
@pytest.mark.parametrize("name", ["crossing strokes", "cusp", "dots", "thick", "hairlines", "hidden ends"])
def test_the_kernels_match_and_differentiate_like_the_cpu(name: str, with_extra: bool) -> None:
    scene = in_precision(SCENES[name](), torch.float32)
    rng = torch.Generator().manual_seed(0)
    target = torch.randint(0, 256, scene.size, generator=rng, dtype=torch.uint8)
    pairs = list_pairs(scene, 1.5)
    extra = torch.randn(len(pairs.active), generator=rng) if with_extra else None
    for _ in range(8):
        here = coverage_loss_and_gradients(scene, pairs, 1.5, target, extra)
    there = match(scene, replace(pairs, t=pairs.t.clone()), 1.5, target, extra)
    for field in FIELDS:
        assert distance(getattr(there, field), getattr(here, field)) < 1e-4, field


def test_the_kernels_find_nearest_points_from_a_rough_start() -> None:
    scene = in_precision(SCENES["self-crossing"](), torch.float32)
    target, pairs = torch.zeros(scene.size, dtype=torch.uint8), list_pairs(scene, 1.0)
    rough = replace(pairs, t=pairs.t.clone())
    for _ in range(8):
        here = coverage_loss_and_gradients(scene, pairs, 1.0, target)
        there = match(scene, rough, 1.0, target)
    assert distance(rough.t, pairs.t) < 1e-4
    assert distance(there.control, here.control) < 1e-3


def test_nothing_to_draw_is_matched_too() -> None:
    scene = in_precision(SCENES["lone stroke"](), torch.float32)
    away = replace(scene, control=scene.control + 500)
    found = match(away, list_pairs(away, 1.0), 1.0, torch.zeros(scene.size, dtype=torch.uint8))
    assert found.loss.tolist() == [0.0]
    assert found.control.abs().sum() == 0
