"""One colour for every identity: distinct from its neighbours, the same in every picture, never near white."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["identity_colours"]

_GOLDEN = (np.sqrt(5) - 1) / 2
_LIGHTNESS = np.array([0.58, 0.71, 0.47, 0.64])  # four, since hues nearly repeat after 21 and 55 identities
_CHROMA = np.array([0.20, 0.16, 0.17, 0.12])
_TO_LMS = np.array(
    [[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.2914855480]]
)
_TO_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def identity_colours(ids: ArrayLike) -> NDArray[np.float64]:
    """A colour for each identity, by the golden angle in hue and four steps of lightness.

    Args:
        ids: Identities. int [S]

    Returns:
        sRGB in [0, 1]. [S, 3]

    Source:
        Oklab to linear sRGB: B. Ottosson 2020, "A perceptual color space for image processing".
    """
    numbers = np.asarray(ids, dtype=np.int64)
    hue = 2 * np.pi * (numbers * _GOLDEN)
    step = numbers % len(_LIGHTNESS)
    lab = np.stack([_LIGHTNESS[step], _CHROMA[step] * np.cos(hue), _CHROMA[step] * np.sin(hue)], axis=-1)
    linear = np.clip((lab @ _TO_LMS.T) ** 3 @ _TO_RGB.T, 0, 1)
    return np.asarray(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))
