"""Tubes have no more triangles than their shape needs, stay on their lines, and do not replace each other."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from beveloid_viz.rendering.polylines import dashed, simplified
from beveloid_viz.rendering.scene import TUBE_SIDES, Arrow, Item, Tube, add_items, tube_meshes

from .pages import distances

TURN = np.linspace(0.0, 2.0 * np.pi, 401)
CIRCLE = np.stack((10.0 * np.cos(TURN), 10.0 * np.sin(TURN), 0.0 * TURN), axis=-1)


def test_a_simplified_line_stays_within_its_tolerance() -> None:
    for tolerance in (0.3, 0.03, 0.003):
        fewer = simplified(CIRCLE, tolerance)
        assert 0.2 * tolerance < distances(CIRCLE, fewer).max() <= tolerance
        # A chord with the sagitta `tolerance`: no more than twice as many as a circle needs.
        needed = np.pi / np.arccos(1.0 - tolerance / 10.0)
        assert needed <= len(fewer) - 1 < 2.0 * needed + 4.0


def test_a_straight_line_needs_two_points() -> None:
    line = np.linspace(0.0, 1.0, 50)[:, None] * np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(simplified(line, 1e-9), line[[0, -1]])
    np.testing.assert_array_equal(simplified(line[:1], 1e-9), line[:1])


def test_a_tube_has_few_triangles() -> None:
    """A tube of 0.5 mm along a quarter of a circle of 10 mm has 17 rings instead of 101."""
    mesh = next(tube_meshes([CIRCLE[:101]], 0.5)).triangulate()
    caps = 2 * (TUBE_SIDES - 2)
    assert mesh.n_cells - caps == 2 * TUBE_SIDES * 16
    around = np.hypot(np.hypot(mesh.points[:, 0], mesh.points[:, 1]) - 10.0, mesh.points[:, 2])
    np.testing.assert_allclose(around, 0.5, rtol=0.06)
    assert isinstance(mesh, pv.PolyData)


def test_lines_of_a_colour_are_one_actor() -> None:
    """Tubes, balls and arrows of one colour are drawn as one actor and keep their triangles."""
    items: list[Item] = [
        Tube(CIRCLE[:101], "red", 0.5),
        Tube(CIRCLE[101:] + 1.0, "red", 0.5),
        Tube(CIRCLE[:1], "red", 0.4),
        Arrow(np.zeros(3), np.ones(3), "red", 0.1),
        Tube(CIRCLE, "blue", 0.5),
    ]
    plotter = pv.Plotter(off_screen=True)
    together = add_items(plotter, items)
    assert len(plotter.renderer.actors) == 2
    assert together == sum([add_items(plotter, [item]) for item in items])
    plotter.close()


def test_dashes_have_the_lengths_of_the_pattern() -> None:
    line = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0]])
    ends = [(piece[0, 0], piece[-1, 0]) for piece in dashed(line, (12.0, 3.0, 2.0, 3.0))]
    np.testing.assert_allclose(ends[:3], [(0.0, 12.0), (15.0, 17.0), (20.0, 32.0)])
    np.testing.assert_allclose(ends[-1], (95.0, 97.0))
    assert [len(piece) for piece in dashed(line, ())] == [2]


def test_no_item_replaces_another() -> None:
    """Each item has its own name in the plotter. With the names that PyVista 0.45 gives, 22 of 300 balls
    disappear."""
    plotter = pv.Plotter(off_screen=True)
    add_items(plotter, [Tube(np.array([[float(k), 0.0, 0.0]]), f"#{k:06x}", 0.4) for k in range(30)])
    assert set(plotter.renderer.actors) == {f"item {k}" for k in range(30)}
    plotter.close()
