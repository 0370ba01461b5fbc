"""A preview for people: the source beside its strokes, coloured by identity, at the source's own times."""

from __future__ import annotations

import io

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from videovec.clip import Clip
from videovec.quality import draw_tracks
from videovec.tracks import StrokeTracks
from videovec.write.preview import contact_sheet, draw_identities
from videovec.write.time_base import time_base

__all__ = ["preview_image", "preview_video"]

Image = NDArray[np.uint8]

_MACROBLOCK = 16  # px
_SMALLEST, _LARGEST = 400, 960  # px of the longer side of a panel


def preview_image(tracks: StrokeTracks, clip: Clip | None, frame: int) -> Image:
    """A frame: source and strokes side by side, or the strokes alone where there is no clip.

    Textured strokes are shown twice: as their brush draws them, then by identity.

    Returns:
        uint8 [H', W', 3]
    """
    longer = max(tracks.size)
    scale = np.ceil(_SMALLEST / longer) if longer < _SMALLEST else min(1.0, _LARGEST / longer)
    identities = draw_identities(tracks, frame, float(scale))
    drawing = int(tracks.timeline.drawing_of_frame[frame])
    pictures: list[Image] = []
    if clip is not None:
        source = clip.drawings[drawing]
        pictures.append(source if source.dtype == np.uint8 else (source >> 8).astype(np.uint8))
    if tracks.brushwork is not None:
        pictures.append(np.rint(255 * draw_tracks(tracks, drawing)).astype(np.uint8))
    size = (identities.shape[1], identities.shape[0])
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    panels = [np.asarray(cv2.resize(picture, size, interpolation=method), np.uint8) for picture in pictures]
    return contact_sheet([*panels, identities], columns=3)


def preview_video(tracks: StrokeTracks, clip: Clip | None) -> bytes:
    """The preview as an H.264 mp4 with the exact times of the frames.

    Args:
        tracks: The strokes of a clip.
        clip: The clip, where it is at hand.

    Returns:
        The file; the same for the same input, whatever the machine's number of cores.
    """
    base = time_base(tracks.timeline)
    buffer = io.BytesIO()
    with av.open(buffer, "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=base.rate)
        stream.options = {"crf": "18", "preset": "veryfast", "threads": "1", "bf": "0"}
        stream.pix_fmt = "yuv420p"
        stream.time_base = 1 / base.rate
        planes, shown = _planes(preview_image(tracks, clip, 0)), 0
        stream.height, stream.width = planes.shape[0] * 2 // 3, planes.shape[1]
        for frame, drawing in enumerate(tracks.timeline.drawing_of_frame.tolist()):
            if drawing != shown:
                planes, shown = _planes(preview_image(tracks, clip, frame)), drawing
            picture = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            picture.pts, picture.time_base = int(base.frame_ticks[frame]), 1 / base.rate
            picture.duration = int(base.frame_ticks[frame + 1] - base.frame_ticks[frame])
            container.mux(stream.encode(picture))
        container.mux(stream.encode())
    return buffer.getvalue()


def _planes(image: Image) -> Image:
    """An image in the planes of 4:2:0 video, grown to whole macroblocks.

    The encoder fills incomplete ones with whatever lies in memory, and av's own conversion of colours differs from run
    to run: with either, the same input would not be the same bytes.
    """
    height, width = image.shape[:2]
    whole = np.pad(image, ((0, -height % _MACROBLOCK), (0, -width % _MACROBLOCK), (0, 0)), mode="edge")
    return np.asarray(cv2.cvtColor(whole, cv2.COLOR_RGB2YUV_I420), np.uint8)
