"""A brush as a Blender script that makes a Grease Pencil material: the strip laid along the stroke.

Blender maps the image along the stroke's arc and turns it with the stroke, as `apply_brush` does; its phase begins at
each stroke's first point, and its density follows the strength of the stroke's points.
"""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image

from videovec.brushwork import SUPPORT, Brush

__all__ = ["blender_image", "blender_script"]

_SCRIPT = '''"""Make the Grease Pencil material {name!r}: run it in Blender's text editor, or with blender -b -P."""

import os

import bpy

HERE = os.path.dirname(os.path.abspath(globals().get("__file__", bpy.data.filepath or "")))
NAME = {name!r}

image = bpy.data.images.load(os.path.join(HERE, {image!r}), check_existing=True)
material = bpy.data.materials.get(NAME) or bpy.data.materials.new(NAME)
if not material.grease_pencil:
    bpy.data.materials.create_gpencil_data(material)
style = material.grease_pencil
style.show_stroke = True
style.show_fill = False
style.mode = "LINE"
style.stroke_style = "TEXTURE"
style.stroke_image = image
style.color = (0.0, 0.0, 0.0, 1.0)
style.mix_stroke_factor = 1.0
style.alignment_mode = "PATH"
# The strip is {length:.3f} widths long and {across:.2f} widths across; Blender scales it by pixels of the image.
style.pixel_size = {pixel_size:.3f}
print("material", NAME, style.stroke_style, tuple(image.size))
'''


def blender_image(brush: Brush) -> bytes:
    """The strip as black ink with 8-bit alpha, columns along the stroke."""
    ink = np.round(np.clip(brush.strip.T, 0, 1) * 255).astype(np.uint8)
    buffer = BytesIO()
    Image.fromarray(np.dstack([np.zeros_like(ink), ink]), mode="LA").convert("RGBA").save(buffer, "PNG")
    return buffer.getvalue()


def blender_script(brush: Brush) -> str:
    """A script that makes the material from ``NAME_blender.png`` beside it."""
    columns = brush.strip.shape[0]
    return _SCRIPT.format(
        name=brush.name,
        image=f"{brush.name}_blender.png",
        length=brush.repeat,
        across=SUPPORT,
        pixel_size=100.0 * brush.repeat / columns,
    )
