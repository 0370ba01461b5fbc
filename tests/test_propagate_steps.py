from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from videovec.propagate.kernels import nearest, relax, rotations
from videovec.propagate.nodes import bases_of, gather
from videovec.propagate.registration import FINE, register, source_of
from videovec.propagate.search import find_motions, scene_of
from videovec.propagate.target import make_target
from videovec.strokes import Strokes


def stroke_points(rng: np.random.Generator, segments: int, is_closed: bool) -> np.ndarray:
    points = rng.uniform(20, 180, (3 * segments + 1, 2))
    if is_closed:
        points[-1] = points[0]
    return points


def strokes_of(points: np.ndarray, is_closed: bool) -> Strokes:
    return Strokes.from_curves([points], [np.ones((len(points) + 2) // 3)], is_closed=[is_closed])


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 1000), st.integers(1, 300), st.integers(1, 300), st.floats(1, 300))
def test_nearest_features_are_those_of_a_tree(seed: int, queries: int, entries: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    query, data = rng.normal(0, spread, (queries, 5)), rng.normal(0, 40, (entries, 5))
    found, squared = nearest(query, data, rng.integers(0, entries, queries))
    distance, _ = cKDTree(data).query(query)
    np.testing.assert_allclose(np.sqrt(squared), distance, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(query - data[found], axis=1), distance, rtol=1e-9)


@pytest.mark.parametrize("is_closed", [False, True])
@pytest.mark.parametrize("segments", [1, 3, 9])
def test_an_affine_motion_of_the_nodes_is_that_of_the_control_points(segments: int, is_closed: bool) -> None:
    points = stroke_points(np.random.default_rng(segments), segments, is_closed)
    nodes = gather(bases_of(strokes_of(points, is_closed), 4.0))
    shift = np.array([7.0, -3.0])
    moved = nodes.moved(points, nodes.positions(points) + shift)
    np.testing.assert_allclose(moved, points + shift, atol=1e-6)
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    moved = nodes.moved(points, nodes.positions(points) @ turn)
    np.testing.assert_allclose(nodes.positions(moved), nodes.positions(points) @ turn, atol=0.3)
    if is_closed:
        np.testing.assert_allclose(moved[0], moved[-1])


def test_nodes_that_stay_leave_control_points_as_they_are() -> None:
    points = stroke_points(np.random.default_rng(5), 4, False)
    nodes = gather(bases_of(strokes_of(points, False), 4.0))
    np.testing.assert_allclose(nodes.moved(points, nodes.positions(points)), points, atol=1e-9)


def test_a_turned_shape_has_its_rotation_at_every_node_and_is_at_rest() -> None:
    points = stroke_points(np.random.default_rng(2), 3, False)
    nodes = gather(bases_of(strokes_of(points, False), 4.0))
    rest = nodes.positions(points)
    source = source_of(nodes, rest, make_target(np.zeros((200, 200), np.uint8), 640))
    angle = 1.1
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    edges = source.stiffness(1.0, 0.1)
    found = rotations(rest @ turn, rest, *edges, 1.0, 1.0)
    np.testing.assert_allclose(np.arctan2(found[:, 1], found[:, 0]), angle, atol=1e-6)
    springs = np.zeros((len(nodes), 3)), np.zeros((len(nodes), 2))
    np.testing.assert_allclose(relax(rest @ turn, rest, edges, springs, (1.0, 1.0), 40), rest @ turn, atol=1e-6)


def square_of_ink(size: int = 200) -> np.ndarray:
    """An L and a bar, of which no rotation looks like another."""
    image = np.zeros((size, size), np.uint8)
    image[50:110, 60:63] = 255
    image[107:110, 60:130] = 255
    image[80:83, 100:150] = 255
    return image


@pytest.mark.parametrize("quarter", [0, 1, 2, 3])
def test_search_finds_the_rotation_and_translation_of_a_group(quarter: int) -> None:
    before, after = make_target(square_of_ink(), 640), make_target(np.rot90(square_of_ink(), -quarter).copy(), 640)
    motion = find_motions(scene_of(after, np.ones(len(after))), before.points, before.direction, 24, 1)[0]
    gap, _ = cKDTree(after.points).query(motion.apply(before.points))
    assert np.mean(gap) < 3.0
    assert motion.angle == pytest.approx(np.pi / 2 * quarter, abs=0.14)


def test_registration_without_ink_or_nodes_moves_nothing() -> None:
    empty, ink = make_target(np.zeros((50, 50), np.uint8), 640), make_target(square_of_ink(), 640)
    nodes = gather([])
    assert register(source_of(nodes, np.zeros((0, 2)), ink), ink, np.zeros((0, 2))).shape == (0, 2)
    nodes = gather(bases_of(strokes_of(np.linspace((5, 5), (40, 40), 4), False), 4.0))
    rest = nodes.positions(np.linspace((5, 5), (40, 40), 4))
    np.testing.assert_array_equal(register(source_of(nodes, rest, empty), empty, rest), rest)


@pytest.mark.parametrize("aside", [-20.0, 0.0, 20.0, 60.0])
def test_a_stroke_beyond_the_reach_of_all_ink_stays(aside: float) -> None:
    page = np.zeros((640, 640), np.uint8)
    page[279:288, 302:305] = page[305:310, 302:305] = 255
    hook = np.array([[289.6, 396.0], [289.0, 370.0], [303.0, 378.0], [306.3, 429.0]])
    hook[:, 0] += aside
    nodes, ink = gather(bases_of(strokes_of(hook, False), 4.0)), make_target(page, 640)
    rest = nodes.positions(hook)
    assert register(source_of(nodes, rest, ink), ink, rest, (FINE,)) == pytest.approx(rest, abs=3.0)


def test_centre_lines_are_found_to_a_fraction_of_a_pixel() -> None:
    image = np.zeros((60, 60), np.uint8)
    image[20, 10:50], image[21:23, 10:50], image[23, 10:50] = 64, 255, 191
    target = make_target(image, 640)
    inside = (target.points[:, 0] > 15) & (target.points[:, 0] < 45)
    centre = (20.5 * 64 + 21.5 * 255 + 22.5 * 255 + 23.5 * 191) / (64 + 2 * 255 + 191)
    np.testing.assert_allclose(target.points[inside, 1], centre, atol=0.15)
    assert np.abs(target.direction[inside, 0]).min() > 0.99


def test_hairlines_have_a_skeleton() -> None:
    image = np.zeros((60, 60), np.uint8)
    image[30, 10:50] = 50
    assert len(make_target(image, 640)) > 35
