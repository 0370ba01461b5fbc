"""A brush as two files, the source of truth of all exports: ``NAME.png``, its strip, and ``NAME.json``, what it means.

The strip is a 16-bit grey image of linear ink, 65535 is full: columns along the stroke, rows across it from its left
edge to its right one as seen by the pen. The JSON says how long it is in widths and what model it belongs to.
"""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from videovec.brushwork import SUPPORT, Brush, BrushModel
from videovec.errors import InputError

__all__ = ["FORMAT", "load_brush", "meaning_json", "strip_png"]

FORMAT = 1
_FULL = 65535


def strip_png(brush: Brush) -> bytes:
    """The strip as a 16-bit grey PNG of V rows and U columns."""
    ink = np.round(np.clip(brush.strip.T, 0, 1) * _FULL).astype(np.uint16)
    buffer = BytesIO()
    Image.fromarray(ink).save(buffer, "PNG")
    return buffer.getvalue()


def meaning_json(brush: Brush) -> str:
    """What the strip means, as JSON."""
    columns, rows = brush.strip.shape
    meaning = {
        "format": "videovec brush",
        "version": FORMAT,
        "name": brush.name,
        "strip": f"{brush.name}.png",
        "model": brush.model.value,
        "width_px": brush.width,
        "repeat_widths": brush.repeat,
        "support_half_widths": SUPPORT,
        "columns": columns,
        "rows": rows,
        "values": "linear ink, 0 none, 65535 full",
        "phase": "learned for each stroke" if brush.model is BrushModel.TEXTURE else "any",
    }
    return json.dumps(meaning, indent=2) + "\n"


def load_brush(path: Path) -> Brush:
    """Read a brush.

    Args:
        path: Its JSON, or the folder that holds just one.

    Raises:
        InputError: It is no brush, or its strip is missing.
    """
    path = Path(path)
    if path.is_dir():
        found = [one for one in sorted(path.glob("*.json")) if '"videovec brush"' in one.read_text(errors="replace")]
        if len(found) != 1:
            raise InputError(f"{path}: a folder of one brush must hold one brush .json, got {len(found)}")
        path = found[0]
    try:
        meaning = json.loads(path.read_text())
        if meaning["version"] > FORMAT or meaning["support_half_widths"] != SUPPORT:
            raise InputError(f"{path}: brush format {FORMAT} is known, got {meaning['version']}")
        with Image.open(path.parent / meaning["strip"]) as image:
            ink = np.asarray(image, dtype=np.float64).T / _FULL
        return Brush(
            name=str(meaning["name"]),
            model=BrushModel(meaning["model"]),
            strip=ink,
            width=float(meaning["width_px"]),
            repeat=float(meaning["repeat_widths"]),
        )
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: a brush must be a videovec brush .json beside its strip, got {error!r}") from error
