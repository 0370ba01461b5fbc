"""Make the gallery: frames of every sample above, their strokes coloured by identity below.

python -m samples.make_gallery
"""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from videovec.clip import Clip
from videovec.config import configure
from videovec.decode import decode
from videovec.progress import Silent
from videovec.run import find_pipeline
from videovec.settings import Config
from videovec.tracks import StrokeTracks
from videovec.write.preview import contact_sheet, draw_identities

HERE = Path(__file__).parent
CLIPS = ("robot.mp4", "ball.gif", "cat/cat_%04d.png", "snail.png")
COLUMNS, HEIGHT = 6, 220  # pictures in a row; px

Picture = NDArray[np.uint8]


def rows_of(clip: Clip, tracks: StrokeTracks) -> tuple[list[Picture], list[Picture]]:
    """A few frames of a clip, and the strokes found in them."""
    count = clip.timeline.frame_count
    frames = np.unique(np.linspace(0, count - 1, min(count, COLUMNS)).round().astype(int)).tolist()
    scale = HEIGHT / clip.size[0]
    width = round(clip.size[1] * scale)
    sources = [Image.fromarray(clip.drawings[clip.timeline.drawing_of_frame[f]]) for f in frames]
    above = [np.asarray(image.resize((width, HEIGHT), Image.Resampling.LANCZOS)) for image in sources]
    return above, [draw_identities(tracks, frame, scale) for frame in frames]


def main() -> None:
    """Run every sample and write its sheet, and the README's picture of the first."""
    config: Config = configure()
    folder = HERE / "gallery"
    folder.mkdir(exist_ok=True)
    for name in CLIPS:
        clip = decode(HERE / name, config.decode)
        tracks = find_pipeline(config.pipeline)(clip, config, Silent())
        above, below = rows_of(clip, tracks)
        sheet = contact_sheet(above + below, len(above))
        iio.imwrite(folder / f"{clip.name.split('_')[0]}.png", sheet, optimize=True)
        print(f"{clip.name}: {clip.timeline.drawing_count} drawings, {len(tracks.strokes)} strokes")


if __name__ == "__main__":
    main()
