"""The command line. Each command reads its options, calls the library, and says what came of it.

Exit status: 0 done; 1 our fault; 2 the user's; 3 finished, but frames lie above ``--max-error``; 130 interrupted.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from videovec.cli_bench import bench
from videovec.cli_brush import brush
from videovec.console import complain, progress_on
from videovec.errors import UserError, VideovecError
from videovec.options import (
    AsJson,
    Correct,
    Device,
    DryRun,
    Exit,
    Force,
    Formats,
    Frames,
    Fresh,
    Init,
    MaxError,
    Out,
    Preset,
    Quiet,
    Reference,
    RunPath,
    Seed,
    Settings,
    Source,
    Strokes,
    SvgStyle,
    parse_frames,
)
from videovec.threads import wait_passively

if TYPE_CHECKING:
    from videovec.run import Outcome, Plan, Request
    from videovec.settings import Config

__all__ = ["app", "main"]


class _Commands(TyperGroup):
    """The commands, with errors told in one line and as an exit status."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            complain("interrupted; what was finished is kept")
            status = Exit.INTERRUPTED
        except UserError as error:
            complain(str(error))
            status = Exit.USER_FAULT
        except Exception as error:
            if (
                isinstance(error, typer.Abort | BrokenPipeError)
                or hasattr(error, "exit_code")
                or ctx.params.get("debug")
            ):
                raise  # typer's own, or wanted in full
            what = str(error) if isinstance(error, VideovecError) else f"{type(error).__name__}: {error}"
            complain(f"a fault of videovec: {what} (videovec --debug ... shows where)")
            status = Exit.OUR_FAULT
        raise typer.Exit(status)


app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(bench, name="bench")
app.add_typer(brush, name="brush")


def _version(wanted: bool) -> None:
    if wanted:
        from videovec import __version__

        typer.echo(f"videovec {__version__}")
        raise typer.Exit


@app.callback()
def options(
    debug: Annotated[bool, typer.Option("--debug", help="Show where an error comes from.")] = False,
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show it.")] = False,
) -> None:
    """Line-art clips to Bézier strokes with one identity over the whole clip."""


# typer takes one parameter for each option, so the two commands that fit have as many as they have options
@app.command()
def run(
    clip: Source,
    out: Out = None,
    frames: Frames = None,
    preset: Preset = None,
    settings: Settings = None,
    device: Device = None,
    seed: Seed = None,
    reference: Reference = None,
    correct: Correct = None,
    init: Init = None,
    strokes: Strokes = None,
    svg_style: SvgStyle = None,
    max_error: MaxError = None,
    fresh: Fresh = False,
    force: Force = False,
    dry_run: DryRun = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Vectorise a clip: SVG frames, Lottie, tracks and a preview."""
    from videovec.run import Request

    shortcuts = {
        "render.device": device,
        "seed": seed,
        "initialise.reference": str(reference.absolute()) if reference else None,
        "initialise.method": init,
        "initialise.strokes": strokes,
        "export.svg_style": svg_style,
    }
    request = Request(
        source=clip,
        out=out,
        config=_config(preset, settings, shortcuts),
        frames=parse_frames(frames),
        resume=not fresh,
        force=force,
        correct=tuple(correct or ()),
    )
    _carry_out(request, dry_run=dry_run, as_json=as_json, quiet=quiet, max_error=max_error)


@app.command()
def track(
    clip: Source,
    out: Out = None,
    frames: Frames = None,
    preset: Preset = None,
    settings: Settings = None,
    device: Device = None,
    seed: Seed = None,
    max_error: MaxError = None,
    fresh: Fresh = False,
    force: Force = False,
    dry_run: DryRun = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Vectorise a clip, and write its tracks alone."""
    from videovec.run import Request

    request = Request(
        source=clip,
        out=out,
        config=_config(preset, settings, {"render.device": device, "seed": seed}),
        frames=parse_frames(frames),
        resume=not fresh,
        force=force,
        formats=("npz", "json"),
    )
    _carry_out(request, dry_run=dry_run, as_json=as_json, quiet=quiet, max_error=max_error)


@app.command()
def export(
    run: RunPath,
    formats: Formats = None,
    out: Out = None,
    settings: Settings = None,
    svg_style: SvgStyle = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Write the strokes of a finished run again, in any format and style, without fitting."""
    from videovec.export import FORMATS
    from videovec.finished_run import FinishedRun

    overrides = [*(settings or []), *([f"export.svg_style={svg_style}"] if svg_style else [])]
    with progress_on(quiet=quiet) as progress:
        written = FinishedRun.open(run).export(formats or FORMATS, overrides, out, progress)
    if as_json:
        typer.echo(json.dumps([str(path) for path in written], indent=1))
    else:
        typer.echo(f"{len(written)} files written to {out or run}")


@app.command()
def view(run: RunPath) -> None:
    """Open the preview of a finished run."""
    from videovec.finished_run import FinishedRun

    preview = FinishedRun.open(run).preview()
    typer.echo(str(preview))
    typer.launch(str(preview))


@app.command()
def compare(runs: Annotated[list[Path], typer.Argument(metavar="RUN...")], as_json: AsJson = False) -> None:
    """Put the figures of finished runs side by side."""
    from videovec.finished_run import FinishedRun

    columns = [FinishedRun.open(run).figures() for run in runs]
    if as_json:
        typer.echo(json.dumps({str(run): column for run, column in zip(runs, columns, strict=True)}, indent=1))
        return
    width = max(12, *(len(run.name) for run in runs))
    typer.echo(f"{'':<20}" + "".join(f"  {run.name:>{width}}" for run in runs))
    for name in dict.fromkeys(name for column in columns for name in column):
        typer.echo(f"{name:<20}" + "".join(f"  {column.get(name, ''):>{width}}" for column in columns))


@app.command()
def doctor(as_json: AsJson = False) -> None:
    """Check whether this machine can do what videovec needs."""
    from videovec.doctor import examine

    findings = examine()
    if as_json:
        typer.echo(json.dumps([asdict(finding) for finding in findings], indent=1))
    else:
        for finding in findings:
            mark = "FAIL" if finding.is_fatal else "note" if finding.advice else "ok"
            typer.echo(f"{mark:<5} {finding.name:<10} {finding.state}")
            if finding.advice:
                typer.echo(f"{'':<17}{finding.advice}")
    if any(finding.is_fatal for finding in findings):
        raise typer.Exit(Exit.USER_FAULT)


@app.command("settings")
def list_settings(preset: Preset = None, settings: Settings = None, as_json: AsJson = False) -> None:
    """List every setting, its value and its meaning, and the presets."""
    from videovec.config import configure, describe_settings, preset_names

    listed = describe_settings(configure(preset, settings or ()))
    if as_json:
        typer.echo(json.dumps({setting.key: setting.default for setting in listed}, indent=1))
        return
    width = max(len(setting.key) for setting in listed)
    for setting in listed:
        typer.echo(f"{setting.key:<{width}}  {setting.default!s:<8} {setting.meaning} ({setting.kind_name})")
    typer.echo(f"\npresets: {', '.join(preset_names())}")


def main() -> None:
    """Entry point of the command ``videovec``."""
    wait_passively()
    app()


def _config(preset: str | None, settings: list[str] | None, shortcuts: Mapping[str, object]) -> Config:
    from videovec.config import configure

    given = {key: value for key, value in shortcuts.items() if value is not None}
    return configure(None, settings or (), base=configure(preset, given))


def _carry_out(request: Request, *, dry_run: bool, as_json: bool, quiet: bool, max_error: float | None) -> None:
    from videovec.run import carry_out, prepare

    with progress_on(quiet=quiet) as progress:
        if dry_run:
            _tell(_summary_of_plan(prepare(request, progress)), as_json)
            return
        outcome = carry_out(request, progress)
    _tell(_summary_of_outcome(outcome), as_json)
    errors = zip(outcome.tracks.timeline.frame_numbers.tolist(), outcome.record.frame_errors, strict=True)
    above = [number for number, error in errors if max_error is not None and error > max_error]
    if above:
        complain(f"{len(above)} frames lie above --max-error {max_error:g}: {', '.join(map(str, above[:10]))}")
        raise typer.Exit(Exit.ABOVE_ERROR)


def _tell(summary: dict[str, object], as_json: bool) -> None:
    if as_json:
        typer.echo(json.dumps(summary, indent=1, ensure_ascii=False))
    else:
        for name, value in summary.items():
            typer.echo(f"{name}: {value}")


def _summary_of_plan(plan: Plan) -> dict[str, object]:
    return {
        **plan.record.clip,
        "pipeline": plan.request.config.pipeline,
        "out": str(plan.folder.path),
        "would": "write again, strokes are fitted already" if plan.is_fitted else "fit and write",
    }


def _summary_of_outcome(outcome: Outcome) -> dict[str, object]:
    record = outcome.record
    return {**record.clip, **record.metrics, "seconds_spent": record.seconds_spent(), "out": str(outcome.folder.path)}
