"""``videovec bench``: measurements on drawings and clips whose true strokes are known."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from videovec.console import progress_on
from videovec.options import Preset, Quiet, Settings

if TYPE_CHECKING:
    from videovec.bench import Result
    from videovec.bench.clips import ClipResult, ClipRun

__all__ = ["bench"]

bench = typer.Typer(no_args_is_help=True, help="Measure on drawings whose true strokes are known.")

Stills = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of NAME/truth.json and NAME/SET_SIZE.png.")]
Clips = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of clips and their truth, such as samples.")]
Table = Annotated[Path | None, typer.Option("-o", "--out", help="Also write every score to this CSV.")]

Textured = Annotated[
    bool,
    typer.Option("--textured", help="Draw the truth with brushes of Debian's krita-data and gimp-data, or made ones."),
]
Pictures = Annotated[
    Path | None, typer.Option("--pictures", help="Folder for pictures: input, strokes by colour, error.")
]


@bench.callback()
def groups() -> None:
    """Measure on drawings whose true strokes are known."""


@bench.command()
def stills(
    folder: Stills,
    sets: Annotated[list[str] | None, typer.Option("--set-name", help="Only this set; may be repeated.")] = None,
    sizes: Annotated[list[int] | None, typer.Option("--size", help="Only this long edge; may be repeated.")] = None,
    methods: Annotated[list[str] | None, typer.Option("--method", help="ours, autotrace ...; may be repeated.")] = None,
    textured: Textured = False,
    brushes: Annotated[list[str] | None, typer.Option("--brush", help="Only this brush; may be repeated.")] = None,
    pen: Annotated[float | None, typer.Option("--pen", help="Width of the brushes' pen, in long edges; 0.01.")] = None,
    out: Table = None,
    pictures: Pictures = None,
    preset: Preset = None,
    settings: Settings = None,
    quiet: Quiet = False,
) -> None:
    """Compare what tracers make of drawings with their true strokes."""
    from videovec.bench import bench_stills, picture_file, read_stills, scores_to_csv, scores_to_table, textured_stills
    from videovec.bench.drawings import PEN, SIZES
    from videovec.bench.stills import TEXTURED_METHODS
    from videovec.config import configure
    from videovec.files import write_file

    def draw(result: Result) -> None:
        if pictures is not None:
            name, data = picture_file(result)
            write_file(pictures / name, data)

    config = configure(preset or ("textured" if textured else None), settings or ())
    if textured:
        found = textured_stills(folder, sizes or SIZES, brushes or (), pen or PEN)
    else:
        found = read_stills(folder, sets or (), sizes or ())
    default = TEXTURED_METHODS if textured else ("ours",)
    with progress_on(quiet=quiet) as progress:
        scores = bench_stills(found, config, methods or default, draw, progress)
    typer.echo(scores_to_table(scores))
    if out:
        write_file(out, scores_to_csv(scores))


@bench.command()
def clips(
    folder: Clips,
    names: Annotated[list[str] | None, typer.Option("--name", help="Only this clip; may be repeated.")] = None,
    methods: Annotated[
        list[str] | None,
        typer.Option("--method", help="A pipeline, autotrace, skeleton ...; may be repeated. Default: four of them."),
    ] = None,
    out: Table = None,
    pictures: Annotated[
        Path | None, typer.Option("--pictures", help="Folder for strips of strokes by identity and curves over time.")
    ] = None,
    preset: Preset = None,
    settings: Settings = None,
    quiet: Quiet = False,
) -> None:
    """Compare what pipelines make of clips with their true strokes: identity, position, jitter."""
    from videovec.bench.clip_methods import METHODS
    from videovec.bench.clip_pictures import picture_files
    from videovec.bench.clip_report import clips_over_time, clips_to_csv, clips_to_table
    from videovec.bench.clip_truth import read_clips
    from videovec.bench.clips import bench_clips
    from videovec.config import configure
    from videovec.files import write_file

    runs: list[ClipRun] = []
    results: list[ClipResult] = []

    def draw(run: ClipRun, result: ClipResult) -> None:
        if results and results[0].name != result.name:
            runs.clear()
            results.clear()
        runs.append(run)
        results.append(result)
        if pictures:
            for name, data in picture_files(runs, results):
                write_file(pictures / name, data)  # after every method: a bench that is cut short has pictures too

    found, config = read_clips(folder, names or ()), configure(preset, settings or ())
    with progress_on(quiet=quiet) as progress:
        scores = bench_clips(found, config, methods or METHODS, draw, progress)
    typer.echo(clips_to_table(scores))
    if out:
        write_file(out, clips_to_csv(scores))
        write_file(out.with_stem(f"{out.stem}_over_time"), clips_over_time(scores))
