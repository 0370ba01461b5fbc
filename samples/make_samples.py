"""Draw the samples: ``python -m samples.make_samples``, from the root of the project.

Writes robot.mp4, ball.gif, cat/cat_0001.png .. and snail.png beside this file, and their strokes into truth/. The
movies that benchmarks need beside them are made on demand: ``occluder_movie`` and ``turning_movie``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

import av
import imageio.v3 as iio
import numpy as np
from numpy.typing import NDArray

from samples.cast import ball, cat, gadgets, pillar, robot, snail
from samples.scene import Drawing, Movie, paint
from samples.truth import movie_truth

__all__ = ["ball_movie", "cat_movie", "frames", "occluder_movie", "robot_movie", "snail_movie", "turning_movie"]

HERE = Path(__file__).parent


def robot_movie() -> Movie:
    """A robot waves, on twos; its balloon drifts behind its head and comes back; sparks are drawn on and vanish."""
    count = 20
    blinks = {8: 0.6, 9: 1.0, 10: 0.4}
    sparks = {3: 0.35, 4: 0.7, **dict.fromkeys(range(5, 13), 1.0)}
    drawings = [robot(d / count, blinks.get(d, 0.0), sparks.get(d, 0.0)) for d in range(count)]
    return Movie("robot", (512, 512), tuple(drawings), tuple(np.repeat(np.arange(count), 2).tolist()))


def cat_movie() -> Movie:
    """A cat's tail sweeps behind it and comes out on the other side, on twos and ones; a heart is drawn over it."""
    count = 16
    blinks, twitches = {5: 0.7, 6: 1.0, 7: 0.6, 13: 1.0}, {2: 0.5, 3: 1.0, 4: 0.4}
    drawings = [
        cat(
            tail=math.cos(2 * math.pi * d / count),
            blink=blinks.get(d, 0.0),
            heart=min(1.0, max(0.0, (d - 8) / 5)),
            ear=twitches.get(d, 0.0),
        )
        for d in range(count)
    ]
    exposures = [2, 2, 1, 1, 1, 2, 1, 2, 2, 1, 1, 1, 1, 2, 2, 2]
    return Movie("cat", (420, 420), tuple(drawings), tuple(np.repeat(np.arange(count), exposures).tolist()))


def ball_movie() -> Movie:
    """A ball bounces across the page twice; dust lines are drawn on where it lands."""
    count, drawings = 20, []
    for d in range(count):
        t = (d + 2) / 10
        height = 1 - (2 * (t % 1) - 1) ** 2
        squash = 1.1 - 0.4 * math.exp(-((height / 0.12) ** 2)) - 0.1 * (height > 0.75)
        landed = int(t)
        since = (t - landed) * 10
        dust = min(1.0, since / 2) if landed and since < 4 else 0.0
        center = (64 + 13.6 * d, 266 - 52 * math.sqrt(squash) - 150 * height)
        drawings.append(ball(center, 64 + 13.6 * (10 * landed - 2), 22 * d, squash, dust))
    return Movie.on_ones("ball", (401, 301), drawings, 20)


def snail_movie() -> Movie:
    """One drawing: a snail on a mushroom."""
    return Movie.on_ones("snail", (480, 480), [snail()])


def occluder_movie(count: int = 24) -> Movie:
    """The robot, waving slowly, while a white pillar passes before it from left to right."""
    size, width = (512, 512), 90.0
    drawings: list[Drawing] = []
    for d in range(count):
        left = -width - 20 + (size[0] + width + 40) * d / (count - 1)
        drawings.append((*robot(0.15 * math.sin(math.pi * d / count), 0.0, 0.0), *pillar(left, width, size)))
    return Movie.on_ones("occluder", size, drawings)


def turning_movie(degrees: float = 45.0, count: int = 9) -> Movie:
    """Six things, each of which turns by so many degrees from drawing to drawing, about its own middle."""
    return Movie.on_ones(f"turning{degrees:g}", (512, 512), [gadgets(degrees * d) for d in range(count)])


def frames(movie: Movie) -> Iterator[NDArray[np.uint8]]:
    """The frames of a movie, holds repeated. uint8 [H, W, 3] each"""
    painted = [paint(drawing, movie.size) for drawing in movie.drawings]
    for drawing in movie.drawing_of_frame:
        yield painted[drawing]


def write_video(movie: Movie, path: Path) -> None:
    """H.264 in 4:2:0, as cameras and editors write it."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=movie.frame_rate, options={"crf": "18", "preset": "slow"})
        stream.width, stream.height = movie.size
        stream.pix_fmt = "yuv420p"
        stream.thread_count = 1
        for image in frames(movie):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))


def write_gif(movie: Movie, path: Path) -> None:
    """An animated gif of at most 256 colours."""
    iio.imwrite(path, list(frames(movie)), duration=1000 / movie.frame_rate, loop=0)


def write_sequence(movie: Movie, folder: Path) -> None:
    """Numbered PNG files, from 1; grey ones if there is no colour."""
    folder.mkdir(exist_ok=True)
    for number, image in enumerate(frames(movie), start=1):
        iio.imwrite(folder / f"{movie.name}_{number:04d}.png", image[..., 0], optimize=True)


def main() -> None:
    """Write all samples and their truth."""
    movies = {"robot": robot_movie(), "ball": ball_movie(), "cat": cat_movie(), "snail": snail_movie()}
    write_video(movies["robot"], HERE / "robot.mp4")
    write_gif(movies["ball"], HERE / "ball.gif")
    write_sequence(movies["cat"], HERE / "cat")
    iio.imwrite(HERE / "snail.png", next(frames(movies["snail"]))[..., 0], optimize=True)
    (HERE / "truth").mkdir(exist_ok=True)
    for name, movie in movies.items():
        text = json.dumps(movie_truth(movie), separators=(",", ":"))
        (HERE / "truth" / f"{name}.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
