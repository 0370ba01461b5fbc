"""Line charts as SVG, for figures that change from drawing to drawing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

__all__ = ["Panel", "chart_svg"]

Floats = NDArray[np.float64]

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 700, 190, 52, 12, 26, 24  # px of a panel, and of its margins
_LEGEND = 22  # px
_COLOURS = ("#1f5fbf", "#d9480f", "#2b8a3e", "#9c36b5", "#868e96", "#0b7285", "#a61e4d", "#5f3dc4")


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One figure of several series.

    Args:
        title: What it is, with its unit.
        series: Its values by name, one for each drawing; nothing is drawn where they are not finite.
        is_log: Whether equal factors, not equal differences, are equally high.
        shown: Values that the axis holds, whatever the series are.
    """

    title: str
    series: Mapping[str, Sequence[float]]
    is_log: bool = False
    shown: tuple[float, ...] = ()


def chart_svg(panels: Sequence[Panel]) -> str:
    """Panels below each other over one axis of drawings, with a legend above.

    Args:
        panels: At least one; a series has the same colour in all of them.

    Returns:
        An SVG document.
    """
    names = list(dict.fromkeys(name for panel in panels for name in panel.series))
    colours = {name: _COLOURS[k % len(_COLOURS)] for k, name in enumerate(names)}
    height = _LEGEND + _HEIGHT * len(panels)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{height}" viewBox="0 0 {_WIDTH} {height}" '
        'font-family="sans-serif" font-size="11"><rect width="100%" height="100%" fill="#fff"/>'
    ]
    x = float(_LEFT)
    for name, colour in colours.items():
        parts.append(f'<rect x="{x:.0f}" y="9" width="16" height="3" fill="{colour}"/>')
        parts.append(f'<text x="{x + 20:.0f}" y="14">{escape(name)}</text>')
        x += 44 + 6.2 * len(name)
    for k, panel in enumerate(panels):
        parts.append(f'<g transform="translate(0 {_LEGEND + k * _HEIGHT})">{"".join(_panel(panel, colours))}</g>')
    return "\n".join([*parts, "</svg>\n"])


def _panel(panel: Panel, colours: Mapping[str, str]) -> Iterator[str]:
    values = {name: np.asarray(series, dtype=np.float64) for name, series in panel.series.items()}
    yield f'<text x="{_LEFT}" y="{_TOP - 8}" font-weight="bold">{escape(panel.title)}</text>'
    every = np.concatenate([np.array(panel.shown, dtype=np.float64), *values.values()])
    finite = every[np.isfinite(every) & ((every > 0) | (not panel.is_log))]
    count = max((len(series) for series in values.values()), default=0)
    if not len(finite):
        return
    ticks = _log_ticks(finite) if panel.is_log else _ticks(finite)
    bottom = _HEIGHT - _BOTTOM

    def height(value: Floats) -> Floats:
        low, high, at = (np.log10(v) if panel.is_log else np.asarray(v) for v in (ticks[0], ticks[-1], value))
        return np.asarray(bottom - (at - low) / (high - low) * (bottom - _TOP))

    for tick in ticks:
        y = float(height(np.asarray(tick)))
        yield f'<path d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}" stroke="#ddd"/>'
        yield f'<text x="{_LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>'
    x = _LEFT + (_WIDTH - _LEFT - _RIGHT) * (np.arange(count) + 0.5) / max(count, 1)
    for drawing in range(0, count, max(1, -(-count // 16))):
        yield f'<text x="{x[drawing]:.1f}" y="{bottom + 15}" text-anchor="middle">{drawing + 1}</text>'
    for name, series in values.items():
        shown = np.clip(np.where(np.isfinite(series), series, np.nan), ticks[0], ticks[-1])
        yield from _line(x[: len(series)], height(shown), colours[name])


def _line(x: Floats, y: Floats, colour: str) -> Iterator[str]:
    """A line through the points that there are, broken where there are none."""
    there = np.isfinite(y)
    for run in np.split(np.arange(len(y)), np.flatnonzero(np.diff(there)) + 1):
        if len(run) and there[run[0]]:
            points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x[run], y[run], strict=True))
            yield f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.6"/>'
            yield "".join(f'<circle cx="{x[k]:.1f}" cy="{y[k]:.1f}" r="2" fill="{colour}"/>' for k in run)


def _ticks(values: Floats) -> list[float]:
    """Round numbers, at equal steps, that hold all values between them."""
    low, high = float(values.min()), float(values.max())
    raw = max(high - low, 1e-6 * max(abs(high), 1.0)) / 4
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(factor for factor in (1, 2, 5, 10) if factor * power >= raw * (1 - 1e-9))
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return [float(round(k * step, 12)) for k in np.arange(first, max(last, first + 1) + 1)]


def _log_ticks(values: Floats) -> list[float]:
    """Powers of ten that hold all values between them."""
    low, high = np.floor(np.log10(values.min())), np.ceil(np.log10(values.max()))
    return [float(10.0**k) for k in np.arange(low, max(high, low + 1) + 1)]
