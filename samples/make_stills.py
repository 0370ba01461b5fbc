"""Make the gallery's page of stills: what goes in, our strokes by colour, our SVG, and what AutoTrace makes of it.

python -m samples.make_stills
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import resvg_py
from numpy.typing import NDArray
from PIL import Image

from videovec.bench import TRACERS
from videovec.config import configure
from videovec.decode import decode
from videovec.ink import extract_ink
from videovec.progress import Silent
from videovec.run import find_pipeline
from videovec.write.preview import contact_sheet, draw_strokes
from videovec.write.svg import svg_frame

HERE = Path(__file__).parent
STILLS = ("snail.png", "cat/cat_0001.png")
SIDE = 330  # px of a picture

Picture = NDArray[np.uint8]


def pictures(path: Path) -> list[Picture]:
    """Input, our strokes, our SVG as resvg draws it, AutoTrace's strokes; strokes each in a colour of its own."""
    config = configure()
    clip = decode(path)
    tracks = find_pipeline(config.pipeline)(clip, config, Silent())
    peer = TRACERS["autotrace"].trace(extract_ink(clip, config.ink), config).strokes
    scale = SIDE / max(clip.size)
    svg = bytes(resvg_py.svg_to_bytes(svg_string=svg_frame(tracks, 0), background="#ffffff", zoom=2))
    print(f"{path.name}: {len(tracks.strokes)} strokes, AutoTrace {len(peer)}")
    return [
        _small(clip.drawings[0]),
        draw_strokes(tracks.strokes, 0, clip.size, scale),
        _small(np.asarray(iio.imread(BytesIO(svg)))[..., :3]),
        draw_strokes(peer, 0, clip.size, scale),
    ]


def _small(picture: Picture) -> Picture:
    height, width = (round(side * SIDE / max(picture.shape[:2])) for side in picture.shape[:2])
    return np.asarray(Image.fromarray(picture).resize((width, height), Image.Resampling.LANCZOS))


def main() -> None:
    """Write the page."""
    sheet = contact_sheet([picture for name in STILLS for picture in pictures(HERE / name)], 4)
    iio.imwrite(HERE / "gallery" / "stills.png", sheet, optimize=True)


if __name__ == "__main__":
    main()
