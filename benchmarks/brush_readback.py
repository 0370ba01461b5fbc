"""Whether other programs read videovec's brushes: Pillow, and GIMP, Blender and Krita where they are installed.

    python benchmarks/brush_readback.py brush            # a folder that `videovec run --preset textured` wrote
    python benchmarks/brush_readback.py                  # a brush of noise that is made here

Pillow opens the 16-bit strip and the ``.gbr`` tip. GIMP (``gimp-console``, Debian: ``gimp``) has a brush folder of
its own, lists what it loaded from there, and paints a straight line with the pipe, in black at native size; the picture
is compared with the strip laid along that line, away from its ends. Blender (``blender -b``) runs the script of the
material. Krita, which has no batch mode for brushes, is started for a minute on a made-up screen (``xvfb-run``) with
data folders of its own, and what it registered is read from its resource database; it does not paint.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
import signal
import sqlite3
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates

from videovec.brush import Brush, BrushModel, export_brush, load_brush
from videovec.brush.export_gimp import CELL

Floats = NDArray[np.float64]
LENGTH, HEIGHT = 1000, 160  # px of the page that GIMP paints on
_BEGIN = 100.0
_KRITA_SECONDS = 75  # it never ends by itself
_WIDTH = CELL / 1.25  # px of the brush in the cells of its pipe

SCRIPT = """
(let* ((image (car (gimp-image-new {length} {height} GRAY)))
       (layer (car (gimp-layer-new image {length} {height} GRAY-IMAGE "line" 100 LAYER-MODE-NORMAL-LEGACY)))
       (points (make-vector 4 'double)))
  (gimp-image-insert-layer image layer 0 -1)
  (gimp-context-set-foreground '(0 0 0))
  (gimp-context-set-background '(255 255 255))
  (gimp-drawable-fill layer FILL-BACKGROUND)
  (for-each (lambda (name) (gimp-message (string-append "brush: " name))) (cadr (gimp-brushes-get-list "")))
  (gimp-context-set-brush "{name}")
  (gimp-context-set-brush-default-size)
  (gimp-context-set-brush-default-spacing)
  (gimp-context-set-brush-default-hardness)
  (gimp-context-set-opacity 100)
  (gimp-context-set-paint-mode LAYER-MODE-NORMAL-LEGACY)
  (gimp-context-set-dynamics "Dynamics Off")
  (vector-set! points 0 {begin}) (vector-set! points 1 {middle})
  (vector-set! points 2 {end}) (vector-set! points 3 {middle})
  (gimp-paintbrush layer 0 4 points PAINT-INCREMENTAL 0)
  (file-png-save RUN-NONINTERACTIVE image layer "{out}" "{out}" 0 9 0 0 0 0 0)
  (gimp-quit 0))
"""


def made() -> Brush:
    """A brush of noise."""
    field = gaussian_filter(np.random.default_rng(0).normal(size=(108, 24)), (2.0, 1.2), mode="wrap")
    across = np.clip((1.0 - np.abs((np.arange(24) + 0.5) / 24 * 2 - 1) * 1.3) * 6, 0, 1)
    strip = np.clip(0.6 + 0.2 * field / field.std(), 0, 1) * across
    return Brush("noise", BrushModel.TEXTURE, strip, 10.0, 9.0)


def by_pillow(brush: Brush, folder: Path) -> str:
    """What Pillow reads of the strip and of the tip."""
    with Image.open(folder / f"{brush.name}.png") as image:
        worst = np.abs(np.asarray(image, dtype=float).T / 65535 - brush.strip).max()
    with Image.open(folder / f"{brush.name}.gbr") as image:
        tip = f"{image.format} {image.size[0]} x {image.size[1]}, spacing {image.info['spacing']} %"
    return f"Pillow: strip within {worst:.1e}; {tip}"


def by_gimp(brush: Brush, folder: Path, program: str) -> str:
    """Which brushes GIMP loads, and how near a line that it paints is to the strip."""
    home = Path(tempfile.mkdtemp())
    (home / "brushes").mkdir()
    for kind in ("gbr", "gih"):
        shutil.copy(folder / f"{brush.name}.{kind}", home / "brushes")
    out = home / "line.png"
    script = SCRIPT.format(
        length=LENGTH, height=HEIGHT, name=brush.name, begin=_BEGIN, end=LENGTH - _BEGIN, middle=HEIGHT / 2, out=out
    )
    environment = {**os.environ, "GIMP2_DIRECTORY": str(home)}
    told = [program, "--no-interface", "--no-fonts", "--batch-interpreter", "plug-in-script-fu-eval", "-b", script]
    done = subprocess.run(told, env=environment, capture_output=True, text=True, timeout=300)
    said = done.stdout + done.stderr
    loaded = sorted({line.split("brush: ")[1] for line in said.splitlines() if f"brush: {brush.name}" in line})
    if not out.exists():
        return f"GIMP: loaded {loaded}, painted nothing: {said[-400:]}"
    with Image.open(out) as image:
        painted = 1 - np.asarray(image.convert("L"), dtype=float) / 255
    shutil.rmtree(home)
    return f"GIMP: loaded {loaded}; a straight line is {likeness(brush, painted):.1f} dB from the strip"


def by_blender(brush: Brush, folder: Path, program: str) -> str:
    """What Blender says of the material that the script made."""
    told = [program, "-b", "--python-exit-code", "3", "-P", str(folder / f"{brush.name}_blender.py")]
    done = subprocess.run(told, capture_output=True, text=True, timeout=300)
    version, *_ = done.stdout.splitlines()
    said = [line for line in done.stdout.splitlines() if line.startswith("material")]
    return f"{version}: exit {done.returncode}, {said[0] if said else done.stderr[-400:]}"


def by_krita(brush: Brush, folder: Path, program: str) -> str:
    """Which of the files Krita registers: name, kind, and bytes of the thumbnail that it made of each."""
    home = Path(tempfile.mkdtemp())
    for kind, place in (("kpp", "paintoppresets"), ("gbr", "brushes"), ("gih", "brushes")):
        (home / "krita" / place).mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / f"{brush.name}.{kind}", home / "krita" / place)
    environment = {**os.environ, "HOME": str(home), "XDG_DATA_HOME": str(home), "XDG_CONFIG_HOME": str(home / "config")}
    told = ["xvfb-run", "-a", program, "--nosplash"]
    with (home / "said").open("w") as said:
        running = subprocess.Popen(told, env=environment, stdout=said, stderr=said, start_new_session=True)
        try:
            running.wait(_KRITA_SECONDS)
        except subprocess.TimeoutExpired:
            os.killpg(running.pid, signal.SIGTERM)
            running.wait()
    query = (
        "select r.filename, r.name, t.name, length(r.thumbnail) from resources r "
        "join resource_types t on t.id = r.resource_type_id where r.status = 1 and r.filename like ? and r.name like ?"
    )
    cache = home / "krita" / "resourcecache.sqlite"
    with contextlib.closing(sqlite3.connect(cache)) as database:
        rows = database.execute(query, (f"{brush.name}.%", f"{brush.name}%")).fetchall()
    shutil.rmtree(home)
    return "Krita registered " + "; ".join(
        f"{file} as {name!r} in {kind}, thumbnail {n} B" for file, name, kind, n in rows
    )


def likeness(brush: Brush, painted: Floats) -> float:
    """PSNR of a painted line against the strip laid along it, at the place where it fits best. dB"""
    columns = len(brush.strip)
    inner = slice(int(_BEGIN + 2 * _WIDTH), int(LENGTH - _BEGIN - 2 * _WIDTH))
    rows = slice(HEIGHT // 2 - CELL // 2, HEIGHT // 2 + CELL // 2)
    seen = painted[rows, inner]
    v = ((np.arange(CELL) + 0.5) / CELL * 2 - 1) * 1.25
    across = (v / 1.3 + 1) / 2 * brush.strip.shape[1] - 0.5
    padded = np.pad(brush.strip, ((1, 1), (0, 0)), mode="wrap")
    best = 0.0
    for start in np.arange(0, columns, columns / (brush.repeat * _WIDTH) / 2):  # half a pixel apart
        along = (np.arange(seen.shape[1]) / _WIDTH / brush.repeat * columns + start) % columns
        wanted = map_coordinates(padded, np.meshgrid(along + 0.5, across), order=1, mode="constant")
        best = max(best, float(-10 * np.log10(np.mean((seen - wanted) ** 2))))
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        brush = replace(load_brush(args.folder), name="videovec") if args.folder else made()
        export_brush(brush, Path(place))
        print(by_pillow(brush, Path(place)))
        program = shutil.which("gimp-console") or shutil.which("gimp-console-2.10")
        print(by_gimp(brush, Path(place), program) if program else "GIMP: not installed")
        program = shutil.which("blender")
        print(by_blender(brush, Path(place), program) if program else "Blender: not installed")
        program = shutil.which("krita") if shutil.which("xvfb-run") else None
        print(by_krita(brush, Path(place), program) if program else "Krita, or xvfb-run: not installed")


if __name__ == "__main__":
    main()
