"""A brush as a Krita preset (``.kpp``) that paints with the pipe of `export_gimp`, turned along the stroke.

The preset is a PNG thumbnail with the settings in a text chunk; it names the ``.gih`` file, which has to be imported
too. Cells are turned by the drawing angle, so that the grain follows curves; between neighbouring dabs on a bend the
cosines no longer sum to one: an approximation.

Source of the format: presets that come with Krita 5.1 (paintop ``paintbrush``, preset version 2.2).
"""

from __future__ import annotations

from html import escape
from io import BytesIO

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from videovec.brush.export_gimp import dab_cells
from videovec.brushwork import Brush

__all__ = ["kpp_preset"]

_THUMBNAIL = 200  # px
_PRESSURE = '<!DOCTYPE params><params id="pressure"><curve>0,0;1,1;</curve></params>'
_ANGLE = '<!DOCTYPE params><params id="drawingangle" angleOffset="0" fanCornersEnabled="0" fanCornersStep="30"/>'


def kpp_preset(brush: Brush) -> bytes:
    """The preset; it needs ``NAME.gih`` among Krita's brush tips."""
    tip = f"{brush.name}.gih"
    definition = (
        f'<Brush type="gbr_brush" filename="{escape(tip)}" BrushVersion="2" spacing="0.2" scale="1" angle="0" '
        'useAutoSpacing="0" autoSpacingCoeff="1" ColorAsMask="1"/>'
    )
    params = {
        "CompositeOp": "normal",
        "paintop": "paintbrush",
        "PaintOpAction": "2",
        "brush_definition": definition,
        "requiredBrushFile": tip,
        "requiredBrushFilesList": tip,
        "OpacityUseCurve": "true",
        "OpacitySensor": _PRESSURE,
        "OpacityValue": "1",
        "PressureSize": "true",
        "SizeUseCurve": "true",
        "SizeSensor": _PRESSURE,
        "SizeValue": "1",
        "PressureRotation": "true",
        "RotationUseCurve": "true",
        "RotationSensor": _ANGLE,
        "RotationValue": "1",
    }
    body = "".join(f'<param type="string" name="{name}"><![CDATA[{value}]]></param>' for name, value in params.items())
    info = PngInfo()
    info.add_text("version", "2.2")
    info.add_text("preset", f'<Preset paintopid="paintbrush" name="{escape(brush.name)}">{body}</Preset>', zip=True)
    buffer = BytesIO()
    _thumbnail(brush).save(buffer, "PNG", pnginfo=info)
    return buffer.getvalue()


def _thumbnail(brush: Brush) -> Image.Image:
    """A straight stroke of dabs on white."""
    cells = dab_cells(brush)
    clear = np.ones((_THUMBNAIL, _THUMBNAIL))
    side = cells.shape[1]
    step = round(side * 0.2)
    top = (_THUMBNAIL - side) // 2
    for k, x in enumerate(range(10, _THUMBNAIL - side - 10, step)):
        clear[top : top + side, x : x + side] *= 1 - cells[k % len(cells)]
    return Image.fromarray(np.round(clear * 255).astype(np.uint8)).convert("RGBA")
