"""Cameras: points are where they are drawn, and pictures show all points."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_viz.rendering.scene import Paint, Scene, Surface, Tube, divided, fit_camera, render

SIZE = (240, 180)
CORNERS = np.stack(np.meshgrid((0.0, 60.0), (-20.0, 20.0), (0.0, 90.0)), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("perspective", [False, True])
def test_points_are_where_they_are_drawn(perspective: bool) -> None:
    """The centre of a ball in the image is at its projected pixel, near and far from the viewer."""
    camera = fit_camera(CORNERS, (-0.5, 0.52, 0.7), (0.0, -1.0, 0.0), SIZE, 0.1, perspective)
    balls = dict(zip(("red", "lime", "blue"), CORNERS[[0, 3, 6]], strict=True))
    picture = render(Scene([Tube(point[None], hue, 3.0) for hue, point in balls.items()], camera), SIZE)
    for channel, point in enumerate(balls.values()):
        rest = np.delete(picture.image, channel, axis=-1).max(axis=-1)
        y, x = np.nonzero(picture.image[..., channel] > rest.astype(int) + 60)
        centre = np.array([x.mean(), y.mean()]) + 0.5
        np.testing.assert_allclose(centre, picture.project(point), atol=0.7)


@pytest.mark.parametrize("perspective", [False, True])
def test_all_points_are_in_the_picture(perspective: bool) -> None:
    """The points are centred in the picture. They leave exactly the margin in one direction, and at least the
    margin in the other."""
    camera = fit_camera(CORNERS, (-0.5, 0.52, 0.7), (0.0, -1.0, 0.0), SIZE, 0.1, perspective)
    half = camera.half_height * np.array([SIZE[0] / SIZE[1], 1.0])
    seen = camera.seen(CORNERS) / half
    np.testing.assert_allclose(seen.min(axis=0), -seen.max(axis=0), atol=1e-4)
    assert seen.max() == pytest.approx(0.8, abs=1e-4)


def test_near_things_are_larger_in_perspective() -> None:
    camera = fit_camera(CORNERS, (0.0, 0.0, 1.0), (0.0, -1.0, 0.0), SIZE, perspective=True)
    near, far = (np.ptp(camera.seen(CORNERS[CORNERS[:, 2] == z]), axis=0) for z in (0.0, 90.0))
    way = camera.distance + np.array([-45.0, 45.0])  # the focal point is in the middle
    np.testing.assert_allclose(near / far, way[1] / way[0])


def test_a_surface_is_divided_along_a_level_line() -> None:
    """A square of two triangles is divided along the diagonal x + y = 0.5 into areas of 1/8 and 7/8."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    level = points[:, :2].sum(axis=1) - 0.5
    paint = Paint(points[:, 0], ("black", "white"), (0.0, 1.0))
    whole = Surface(points, np.array([[0, 1, 3], [1, 2, 3]]), paint=paint)
    for part, area in zip(divided(whole, level), (7.0 / 8.0, 1.0 / 8.0), strict=True):
        a, b, c = part.points[part.faces].swapaxes(0, 1)
        sizes = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        assert sizes.sum() == pytest.approx(area)
        assert part.paint is not None
        np.testing.assert_allclose(part.paint.values, part.points[:, 0])
