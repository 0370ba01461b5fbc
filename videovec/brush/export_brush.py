"""All files of a brush, and a note that says which of them are the brush and which come close."""

from __future__ import annotations

from pathlib import Path

from videovec.brush.export_blender import blender_image, blender_script
from videovec.brush.export_gimp import dab_cells, gbr_tip, gih_pipe
from videovec.brush.export_krita import kpp_preset
from videovec.brush.storage import meaning_json, strip_png
from videovec.brushwork import Brush
from videovec.files import write_file

__all__ = ["brush_files", "export_brush"]

_NOTE = """{name}: a brush learned by videovec ({model}, pen {width:.1f} px, repeats after {repeat:.2f} widths)

{name}.png, {name}.json   The brush itself: 16-bit linear ink along (x) and across (y) the stroke, and what it means.
{name}.gih                GIMP, Krita: overlapping dabs. Exact on a straight line along +x; approximate on curves.
                         GIMP: native size, dynamics off, mode Normal (legacy), Incremental on.
{name}.gbr                GIMP, Krita: one of those dabs. Approximate: every mark is the same.
{name}.kpp                Krita preset that paints with {name}.gih, turned along the stroke. Import both. Approximate.
{name}_blender.py, .png   Blender: makes a Grease Pencil material that lays the strip along the stroke.
"""


def export_brush(brush: Brush, folder: Path) -> tuple[Path, ...]:
    """Write a brush for all programs.

    Args:
        brush: The brush; its name becomes the stem of the files.
        folder: Where to.

    Returns:
        The files.

    Raises:
        OutputError: The folder cannot be written to.
    """
    return tuple(write_file(folder / file, data) for file, data in brush_files(brush))


def brush_files(brush: Brush) -> tuple[tuple[str, bytes], ...]:
    """Names and contents of the files that a brush is written as."""
    name = brush.name
    note = _NOTE.format(name=name, model=brush.model.value, width=brush.width, repeat=brush.repeat)
    return (
        (f"{name}.png", strip_png(brush)),
        (f"{name}.json", meaning_json(brush).encode()),
        (f"{name}.gih", gih_pipe(brush)),
        (f"{name}.gbr", gbr_tip(dab_cells(brush)[0], f"{name} dab")),
        (f"{name}.kpp", kpp_preset(brush)),
        (f"{name}_blender.png", blender_image(brush)),
        (f"{name}_blender.py", blender_script(brush).encode()),
        (f"{name}.txt", note.encode()),
    )
