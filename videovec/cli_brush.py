"""``videovec brush``: what can be done with a learned brush."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from videovec.options import Seed

__all__ = ["brush"]

brush = typer.Typer(no_args_is_help=True, help="Use learned brushes.")

Brush = Annotated[Path, typer.Argument(metavar="BRUSH", help="A brush's JSON, or the folder that holds it.")]
Drawing = Annotated[Path, typer.Argument(metavar="DRAWING", help="An SVG of stroked paths, or a finished run.")]
Picture = Annotated[Path, typer.Option("-o", "--out", help="The picture to write, a PNG.")]
Number = Annotated[int, typer.Option(min=1, help="Which frame of the run; the first is 1.")]


@brush.callback()
def groups() -> None:
    """Use learned brushes."""


@brush.command()
def apply(brush: Brush, drawing: Drawing, out: Picture, frame: Number = 1, seed: Seed = None) -> None:
    """Paint a drawing with a brush."""
    from videovec.files import write_file
    from videovec.painting import paint

    typer.echo(str(write_file(out, paint(brush, drawing, frame, seed or 0))))


@brush.command("export")
def write(brush: Brush, out: Annotated[Path, typer.Option("-o", "--out", help="Folder to write to.")]) -> None:
    """Write a brush for GIMP, Krita and Blender."""
    from videovec.brush import export_brush, load_brush

    for path in export_brush(load_brush(brush), out):
        typer.echo(str(path))
