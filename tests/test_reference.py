from pathlib import Path

import numpy as np
import pytest

from videovec.curves import sample_by_arc
from videovec.errors import InputError
from videovec.reference import read_reference

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '


def svg(tmp_path: Path, body: str, attributes: str = 'width="100" height="100" viewBox="0 0 100 100"') -> Path:
    path = tmp_path / "drawing.svg"
    path.write_text(f"{HEAD}{attributes}>{body}</svg>")
    return path


LINE = '<path d="M10 20 L40 20" stroke="#f00" stroke-width="4" fill="none"/>'


def test_a_line_is_a_cubic_with_its_width_and_colour(tmp_path: Path) -> None:
    strokes = read_reference(svg(tmp_path, LINE), (100, 100))
    np.testing.assert_allclose(strokes.points, [[10, 20], [20, 20], [30, 20], [40, 20]])
    np.testing.assert_allclose(strokes.half_width, [2, 2])
    np.testing.assert_allclose(strokes.color, [[1, 0, 0]])


def test_groups_transforms_and_use_are_flattened(tmp_path: Path) -> None:
    body = f'<g transform="translate(5 0)"><g transform="scale(2)" id="a">{LINE}</g></g><use xlink:href="#a" y="10"/>'
    strokes = read_reference(svg(tmp_path, body), (100, 100))
    np.testing.assert_allclose(strokes.points[[0, 3]], [[25, 40], [85, 40]])
    np.testing.assert_allclose(strokes.points[[4, 7]], [[20, 50], [80, 50]])
    np.testing.assert_allclose(strokes.half_width, 4)


@pytest.mark.parametrize(
    ("attributes", "size", "first"),
    [
        ('width="100pt" height="100pt" viewBox="0 0 100 100"', (200, 200), (20, 40)),
        ('viewBox="0 0 100 100"', (50, 50), (5, 10)),
        ('width="100" height="100"', (100, 300), (110, 20)),
    ],
)
def test_a_document_of_any_unit_fills_the_page(
    tmp_path: Path, attributes: str, size: tuple[int, int], first: tuple[float, float]
) -> None:
    np.testing.assert_allclose(read_reference(svg(tmp_path, LINE, attributes), size).points[0], first, atol=1e-6)


def test_order_and_direction_are_kept(tmp_path: Path) -> None:
    body = "".join(f'<path d="M{x} 90 L{x} 10" stroke="black" fill="none"/>' for x in (70, 30, 50))
    strokes = read_reference(svg(tmp_path, body), (100, 100))
    np.testing.assert_allclose(strokes.points[::4], [[70, 90], [30, 90], [50, 90]])


@pytest.mark.parametrize(
    ("shape", "length"),
    [
        ('<circle cx="50" cy="50" r="20" fill="none" stroke="black"/>', 2 * np.pi * 20),
        ('<rect x="10" y="10" width="30" height="20" fill="none" stroke="black"/>', 100.0),
        ('<polygon points="0,0 30,0 30,40" fill="none" stroke="black"/>', 120.0),
        ('<path d="M0 0 Q 50 100 100 0" fill="none" stroke="black"/>', 147.894),
        ('<path d="M10 50 A 40 40 0 0 1 90 50" fill="none" stroke="black"/>', np.pi * 40),
    ],
)
def test_every_shape_becomes_its_curve(tmp_path: Path, shape: str, length: float) -> None:
    strokes = read_reference(svg(tmp_path, shape), (100, 100))
    points = sample_by_arc(strokes.points_of(0), 4000)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(length, rel=1e-3)
    assert strokes.is_closed[0] == ("path" not in shape)
    if strokes.is_closed[0]:
        np.testing.assert_array_equal(strokes.points[0], strokes.points[-1])


def test_subpaths_are_strokes_and_fills_are_not(tmp_path: Path) -> None:
    body = '<path d="M0 0 L9 0 M0 9 L9 9" fill="none" stroke="black"/><path d="M0 0 L9 0 L9 9 Z" fill="red"/>'
    assert len(read_reference(svg(tmp_path, body), (100, 100))) == 2


def test_identities_of_our_own_files_come_back(tmp_path: Path) -> None:
    body = "".join(f'<path data-stroke-id="{k}" d="M0 {k} L9 {k}" stroke="black"/>' for k in (7, 3))
    body += '<path d="M0 50 L9 50" stroke="black"/>'
    assert read_reference(svg(tmp_path, body), (100, 100)).ids.tolist() == [7, 3, 8]


@pytest.mark.parametrize("text", ["", "not a drawing", HEAD + '><path d="M0 0 L9 9" fill="red"/></svg>'])
def test_what_is_no_drawing_is_refused_by_name(tmp_path: Path, text: str) -> None:
    path = tmp_path / "drawing.svg"
    path.write_text(text)
    with pytest.raises(InputError, match=r"drawing\.svg: must"):
        read_reference(path, (100, 100))


def test_a_missing_file_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.svg: must be an SVG that can be read"):
        read_reference(tmp_path / "none.svg", (100, 100))
