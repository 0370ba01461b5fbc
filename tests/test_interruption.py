"""Ctrl-C inside the fit: what is fitted so far is kept and written, and the next run goes on from there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from videovec.fit import draw_coverage, fit
from videovec.ink import Ink
from videovec.optimise import Interrupted, Schedule, optimise
from videovec.progress import Silent
from videovec.render import resolve_backend
from videovec.run import Request, carry_out
from videovec.run_folder import RunFolder
from videovec.settings import Config, FitSettings, RenderSettings
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

SIZE = 40
LINE = np.array([[6.0, 20.0], [15.0, 14.0], [25.0, 26.0], [34.0, 20.0]])


class Impatient(Silent):
    """Presses Ctrl-C at a step of a stage, when that stage comes for the ``time``-th time."""

    def __init__(self, stage: str, step: int, time: int = 1) -> None:
        self.notes: list[str] = []
        self._left, self._wanted, self._stage, self._time = step, stage, "", time

    def stage(self, name: str, total: int) -> None:
        self._stage = name
        self._time -= name == self._wanted

    def advance(self, count: int = 1) -> None:
        if self._stage == self._wanted and self._time == 0:
            self._left -= count
            if self._left == 0:
                raise KeyboardInterrupt

    def note(self, text: str) -> None:
        self.notes.append(text)


def moved(drawings: int, shift: tuple[float, float] = (0.0, 0.0)) -> Strokes:
    """One line that sinks by 2 px from drawing to drawing."""
    lines = [LINE + shift + [0.0, 2.0 * n] for n in range(drawings)]
    strokes = [Strokes.from_curves([line], [np.full(2, 1.5)]) for line in lines]
    return Strokes.concatenate([strokes[0]]) if drawings == 1 else _over_time(strokes[0], lines)


def _over_time(first: Strokes, lines: list[np.ndarray]) -> Strokes:
    layout = replace(first.layout, last=np.array([len(lines) - 1]))
    count = len(lines)
    return replace(
        first,
        layout=layout,
        points=np.concatenate(lines),
        half_width=np.tile(first.half_width, count),
        opacity=np.tile(first.opacity, count),
        visible=np.tile(first.visible, (count, 1)),
    )


def ink_of(strokes: Strokes, drawings: int) -> Ink:
    drawn = draw_coverage(strokes, (drawings, SIZE, SIZE), resolve_backend(RenderSettings()))
    return Ink(
        coverage=drawn,
        label=np.zeros(drawn.shape, np.uint8),
        palette=np.zeros((1, 3)),
        page=np.ones(3),
        noise=0.0,
    )


@pytest.mark.parametrize("is_newton", [False, True])
def test_an_interrupted_optimisation_brings_its_strokes_along(is_newton: bool) -> None:
    truth, start = moved(1), moved(1, (1.5, 1.5))
    target = ink_of(truth, 1).coverage
    schedule = Schedule(steps=60, scale=1.0, is_newton=is_newton)
    with pytest.raises(Interrupted) as stop:
        optimise(start, target, schedule, progress=Impatient("", 5, time=0))
    before, after = (np.abs(strokes.points - truth.points).mean() for strokes in (start, stop.value.strokes))
    assert after < 0.95 * before


@pytest.mark.parametrize("drawings", [1, 3])
def test_an_interrupted_fit_keeps_what_is_fitted(drawings: int) -> None:
    truth, start = moved(drawings), moved(drawings, (1.0, 1.0))
    ink = ink_of(truth, drawings)
    begun = fit(ink, start, replace(FitSettings(), steps=0, joint_steps=0))
    result = fit(ink, start, FitSettings(), progress=Impatient("fit", 30))
    assert begun.is_finished
    assert not result.is_finished
    assert result.psnr.min() > begun.psnr.min() + 3
    with pytest.raises(KeyboardInterrupt):
        result.finished()


def test_what_an_interrupted_run_has_fitted_is_written_and_the_next_run_goes_on(tmp_path: Path) -> None:
    coverage = ink_of(moved(3), 3).coverage
    clip = tmp_path / "clip.gif"
    iio.imwrite(clip, 255 - np.repeat(coverage[..., None], 3, axis=3), duration=100, loop=0)
    request = Request(clip, tmp_path / "out", Config(), formats=("svg",))
    impatient = Impatient("fit", 20, time=2)  # the joint fit comes after that of the first drawing
    with pytest.raises(KeyboardInterrupt):
        carry_out(request, impatient)
    record = RunFolder(tmp_path / "out").record()
    assert record is not None
    assert record.status == "unfinished"
    assert any("interrupted" in note for note in impatient.notes)
    assert len(list((tmp_path / "out").rglob("frame_*.svg"))) == 3
    early = StrokeTracks.load(tmp_path / "out" / "tracks.npz")
    assert not early.is_finished

    patient = Impatient("", -1)
    outcome = carry_out(request, patient)
    assert any("goes on" in note for note in patient.notes)
    assert outcome.record.status == "done"
    assert outcome.tracks.is_finished
    assert set(outcome.tracks.strokes.ids) == set(early.strokes.ids)
    assert outcome.record.metrics["psnr_worst_db"] >= record.metrics["psnr_worst_db"]


def test_an_interrupted_first_fit_of_a_clip_leaves_nothing_to_go_on_from(tmp_path: Path) -> None:
    coverage = ink_of(moved(3), 3).coverage
    clip = tmp_path / "clip.gif"
    iio.imwrite(clip, 255 - np.repeat(coverage[..., None], 3, axis=3), duration=100, loop=0)
    with pytest.raises(KeyboardInterrupt):
        carry_out(Request(clip, tmp_path / "out"), Impatient("fit", 5))
    record = RunFolder(tmp_path / "out").record()
    assert record is not None
    assert record.status == "interrupted"
    assert not RunFolder(tmp_path / "out").has_tracks()
