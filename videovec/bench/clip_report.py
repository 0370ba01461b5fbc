"""Tables and CSV of benchmarks on clips."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict
from io import StringIO

from videovec.bench.clips import ClipResult
from videovec.point_metrics import THRESHOLDS

__all__ = ["CLIP_PROTOCOL", "clips_over_time", "clips_to_csv", "clips_to_table"]

CLIP_PROTOCOL = """\
IDF1 is of stroke length under the best one-to-one identities, at most 3 px and 45 degrees apart; persist(ence): share
of a true stroke's drawings with its most frequent identity; full: strokes with one identity on all drawings. Position
(< x px, px of the clip), Jaccard and occlusion accuracy of five points a stroke are those of TAP-Vid, queried where a
stroke is first seen. Jitter: second difference of the error, px. Flicker: wrong changes of the stroke count, a drawing.
Pictures are drawn by videovec's renderer in colour; medians over drawings; LPIPS is AlexNet's. per_frame is our own
still pipeline on each drawing; it and the tracers of single drawings are linked one to one from drawing to drawing,
and points on them keep their arc fraction (on ours, their parameter)."""


def clips_to_csv(results: Sequence[ClipResult]) -> str:
    """All figures, a row for each clip and method."""
    return _csv([_flat(result) for result in results])


def clips_over_time(results: Sequence[ClipResult]) -> str:
    """What changes from drawing to drawing, as CSV: a row for each clip, method and drawing."""
    return _csv(
        [
            {
                "name": result.name,
                "method": result.method,
                "drawing": drawing,
                "error": result.score.error_over_time[drawing],
                "identity": result.score.identity_over_time[drawing],
                **asdict(picture),
            }
            for result in results
            for drawing, picture in enumerate(result.pictures)
        ]
    )


def _csv(rows: Sequence[dict[str, object]]) -> str:
    text = StringIO()
    writer = csv.DictWriter(text, list(rows[0]) if rows else ["name"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _flat(result: ClipResult) -> dict[str, object]:
    row = asdict(result)
    score = row.pop("score")
    for name in ("error_over_time", "identity_over_time"):
        del score[name]
    del row["pictures"]
    medians = {name: result.median(name) for name in ("psnr", "ssim", "lpips")}
    within = {f"within_{limit:g}px": share for limit, share in zip(THRESHOLDS, score.pop("position"), strict=True)}
    flat: dict[str, object] = row | score | within | medians
    return flat


def clips_to_table(results: Sequence[ClipResult]) -> str:
    """A line for each clip and method."""
    limits = "".join(f"{f'<{limit:g}':>5}" for limit in THRESHOLDS)
    head = (
        f"{'clip':<18}{'method':<20}{'found/true':>11}{'IDF1':>6}{'persist':>8}{'full':>6}{'error':>7}{limits}"
        f"{'Jacc.':>6}{'occl.':>6}{'jitter':>7}{'flicker':>8}{'births':>7}{'deaths':>7}{'PSNR':>6}{'SSIM e-2':>9}"
        f"{'LPIPS e-3':>10}{'s/drw':>7}{'KiB':>7}"
    )
    return "\n".join([head, *(_row(result) for result in results), "", CLIP_PROTOCOL])


def _row(result: ClipResult) -> str:
    score = result.score
    return (
        f"{result.name:<18}{result.method:<20}{f'{result.strokes}/{result.true_strokes}':>11}{score.idf1:>6.2f}"
        f"{score.persistence:>8.2f}{score.full_life:>6.2f}{score.error:>7.2f}"
        + "".join(f"{share:>5.2f}" for share in score.position)
        + f"{score.jaccard:>6.2f}{score.occlusion:>6.2f}{score.jitter:>7.3f}{score.flicker:>8.2f}"
        f"{score.births:>7.2f}{score.deaths:>7.2f}{result.median('psnr'):>6.1f}{100 * result.median('ssim'):>9.2f}"
        f"{1e3 * result.median('lpips'):>10.2f}{result.seconds:>7.2f}{result.lottie_bytes / 1024:>7.1f}"
    )
