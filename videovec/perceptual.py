"""LPIPS: how different two images look, as the features of AlexNet see it, and its gradient for the fit."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from videovec.errors import FitError
from videovec.render import PairList

__all__ = ["Features", "Perceptual", "PerceptualTerm"]

WEIGHTS = "lpips_alex_fp16.safetensors"
CHECKSUM = "d11528d7686c1f52136a619aa31480be644813b6a6f0ffe73f102931079dfb68"
SHIFT = (-0.030, -0.088, -0.188)
"""Mean of the metric's inputs, which lie in [-1, 1]."""
SPREAD = (0.458, 0.448, 0.450)
"""Standard deviation of the metric's inputs."""
LAYERS = ((4, 2), (1, 2), (1, 1), (1, 1), (1, 1))
"""Stride and padding of the five convolutions; the second and third follow a pooling."""
KEPT_PIXELS = 2_000_000
"""Pixels of targets whose features are kept, at about 35 bytes each."""
LEAST_SIDE = 64
"""Smaller images are enlarged by a whole factor: the network's five layers need room. px"""

Features = tuple[Tensor, ...]
"""Unit-length features of N images after each of the five layers. 5 x [N, c, h, w]"""


@dataclass(frozen=True, slots=True, eq=False)
class Perceptual:
    """The network and its heads.

    Args:
        kernels: Weights of the convolutions. 5 x [out, in, k, k]
        biases: Their biases. 5 x [out]
        heads: Weight of each feature of each layer. 5 x [1, out, 1, 1]

    Source:
        Zhang et al. 2018, "The Unreasonable Effectiveness of Deep Features as a Perceptual Metric"; net alex, v0.1.
    """

    kernels: tuple[Tensor, ...]
    biases: tuple[Tensor, ...]
    heads: tuple[Tensor, ...]

    @staticmethod
    def load(device: torch.device | str = "cpu") -> Perceptual:
        """Read the weights that come with the library.

        Raises:
            FitError: The file is not the one that this code was tested with.
        """
        tensors = _read_weights(files("videovec").joinpath("weights", WEIGHTS).read_bytes())
        named = {
            kind: tuple(tensors[f"{kind.replace('.', f'{n}.')}"].to(device) for n in range(len(LAYERS)))
            for kind in ("conv.weight", "conv.bias", "lin.weight")
        }
        return Perceptual(named["conv.weight"], named["conv.bias"], named["lin.weight"])

    def features(self, images: Tensor) -> Features:
        """What the network sees, to be compared with `between`.

        Args:
            images: sRGB in [0, 1]. [N, 3, H, W]
        """
        factor = -(-LEAST_SIDE // min(images.shape[2:]))
        if factor > 1:
            images = images.repeat_interleave(factor, dim=2).repeat_interleave(factor, dim=3)
        x = (2 * images - 1 - images.new_tensor(SHIFT)[:, None, None]) / images.new_tensor(SPREAD)[:, None, None]
        found = []
        for n, (stride, padding) in enumerate(LAYERS):
            if n in (1, 2):
                x = functional.max_pool2d(x, 3, 2)
            x = functional.conv2d(x, self.kernels[n], self.biases[n], stride, padding).relu()
            found.append(x / (x.square().sum(dim=1, keepdim=True) + 1e-20).sqrt())
        return tuple(found)

    def between(self, a: Features, b: Features) -> Tensor:
        """Distance of each image of ``a`` from that of ``b``. [N]"""
        layers = [
            functional.conv2d((x - y).square(), head).mean(dim=(1, 2, 3))
            for x, y, head in zip(a, b, self.heads, strict=True)
        ]
        return torch.stack(layers).sum(dim=0)

    def distance(self, a: Tensor, b: Tensor) -> Tensor:
        """LPIPS between images, 0 for the same, about 0.1 for hardly alike.

        Args:
            a: sRGB in [0, 1]. [N, 3, H, W]
            b: Likewise.

        Returns:
            Distances. [N]
        """
        return self.between(self.features(a), self.features(b))


class PerceptualTerm:
    """LPIPS of the drawings of a fit, black on white, with its gradient by the coverage of active pixels.

    Drawings are taken one by one, so that memory does not grow with them; what the network sees of the target is kept
    for the first few. At 512 px an evaluation takes about 0.2 s on one core: once every ten steps or more, there.

    Args:
        target: Ink coverage, 255 is full. uint8 [D, H, W]
        device: Where the network runs.
    """

    def __init__(self, target: Tensor, device: torch.device | str = "cpu") -> None:
        self._target = target
        self._network = Perceptual.load(device)
        self._kept: dict[int, Features] = {}

    def gradient(self, pairs: PairList, value: Tensor) -> tuple[Tensor, Tensor]:
        """Evaluate the term.

        Args:
            pairs: Tells where the active pixels lie.
            value: Coverage of each active pixel. [A]

        Returns:
            LPIPS of each drawing [D], and the derivative of their sum by each value [A].
        """
        drawings, height, width = self._target.shape
        losses, slopes = value.new_zeros(drawings), torch.zeros_like(value)
        for drawing in range(drawings):
            part = slice(int(pairs.drawing_pixels[drawing]), int(pairs.drawing_pixels[drawing + 1]))
            pixels = pairs.active[part] - drawing * height * width
            covered = value[part].detach().float().requires_grad_()
            seen = self._seen(drawing, covered.detach())
            with torch.enable_grad():
                page = covered.new_zeros(height * width).index_put((pixels,), covered)
                loss = self._network.between(self._network.features(_as_image(page.view(height, width))), seen).sum()
                if len(covered):
                    slopes[part] = torch.autograd.grad(loss, covered)[0].to(value)
            losses[drawing] = loss.detach()
        return losses, slopes

    def _seen(self, drawing: int, like: Tensor) -> Features:
        """Features of a target, kept while there is room."""
        if drawing in self._kept:
            return self._kept[drawing]
        with torch.no_grad():
            seen = self._network.features(_as_image(self._target[drawing].to(like) / 255))
        if len(self._kept) * self._target[0].numel() < KEPT_PIXELS:
            self._kept[drawing] = seen
        return seen


def _as_image(coverage: Tensor) -> Tensor:
    """Black ink on white paper. [1, 3, H, W]"""
    return (1 - coverage).expand(1, 3, -1, -1)


def _read_weights(data: bytes) -> dict[str, Tensor]:
    """Tensors of a safetensors file: the length of a JSON header, the header, the numbers."""
    found = hashlib.sha256(data).hexdigest()
    if found != CHECKSUM:
        raise FitError(f"{WEIGHTS} must have sha256 {CHECKSUM}, got {found}: install videovec again")
    begin = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:begin])
    return {
        name: torch.from_numpy(
            np.frombuffer(data[begin + entry["data_offsets"][0] : begin + entry["data_offsets"][1]], np.float16)
            .reshape(entry["shape"])
            .astype(np.float32)
        )
        for name, entry in header.items()
        if name != "__metadata__"
    }
