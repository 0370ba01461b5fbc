"""The GPU's kernels, run by Triton's interpreter on the CPU, against the CPU's."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
import torch
from test_render import SCENES, distance, in_precision
from torch import Tensor

from videovec.render import CoverageMatch, coverage_loss_and_gradients, list_pairs

FIELDS = ("loss", "value", "control", "half_width", "interval", "opacity")
KERNELS = ("videovec.render.triton_match", "videovec.render.triton_kernels")


@pytest.fixture(scope="module")
def match() -> Iterator[Callable[..., tuple[Tensor, ...]]]:
    """`match_with_triton`, interpreted: what Triton decorates is decided when it is imported."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRITON_INTERPRET", "1")
        for name in KERNELS:
            patch.delitem(sys.modules, name, raising=False)
        yield importlib.import_module(KERNELS[0]).match_with_triton
        for name in KERNELS:
            sys.modules.pop(name, None)


@pytest.mark.parametrize("with_extra", [False, True])
@pytest.mark.parametrize("name", ["crossing strokes", "cusp", "dots", "thick", "hairlines", "hidden ends"])
def test_the_kernels_match_and_differentiate_like_the_cpu(
    name: str, with_extra: bool, match: Callable[..., tuple[Tensor, ...]]
) -> None:
    scene = in_precision(SCENES[name](), torch.float32)
    rng = torch.Generator().manual_seed(0)
    target = torch.randint(0, 256, scene.size, generator=rng, dtype=torch.uint8)
    pairs = list_pairs(scene, 1.5)
    extra = torch.randn(len(pairs.active), generator=rng) if with_extra else None
    for _ in range(8):
        here = coverage_loss_and_gradients(scene, pairs, 1.5, target, extra)
    there = CoverageMatch(*match(scene, replace(pairs, t=pairs.t.clone()), 1.5, target, extra))
    for field in FIELDS:
        assert distance(getattr(there, field), getattr(here, field)) < 1e-4, field


def test_the_kernels_find_nearest_points_from_a_rough_start(match: Callable[..., tuple[Tensor, ...]]) -> None:
    scene = in_precision(SCENES["self-crossing"](), torch.float32)
    target, pairs = torch.zeros(scene.size, dtype=torch.uint8), list_pairs(scene, 1.0)
    rough = replace(pairs, t=pairs.t.clone())
    for _ in range(8):
        here = coverage_loss_and_gradients(scene, pairs, 1.0, target)
        there = CoverageMatch(*match(scene, rough, 1.0, target))
    assert distance(rough.t, pairs.t) < 1e-4
    assert distance(there.control, here.control) < 1e-3


def test_nothing_to_draw_is_matched_too(match: Callable[..., tuple[Tensor, ...]]) -> None:
    scene = in_precision(SCENES["lone stroke"](), torch.float32)
    away = replace(scene, control=scene.control + 500)
    found = CoverageMatch(*match(away, list_pairs(away, 1.0), 1.0, torch.zeros(scene.size, dtype=torch.uint8)))
    assert found.loss.tolist() == [0.0]
    assert found.control.abs().sum() == 0
