"""Cameras in parallel projection or perspective. Lengths are mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from .polylines import FloatArray

Size: TypeAlias = tuple[int, int]
"""Width and height, pixels."""

VIEW_ANGLE_DEG = 20.0
"""Angle of view of pictures in perspective, over their height: that of a long lens."""


@dataclass(frozen=True, eq=False)
class Camera:
    """Parallel projection, or perspective.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        Viewing direction.
    up : ndarray, shape (3,)
        Upward direction in the picture.
    focal_point : ndarray, shape (3,)
        Point at the centre of the picture, mm.
    half_height : float
        Distance from the centre to the upper edge of the picture, mm, at the depth of the focal point.
    perspective : bool
        True for the perspective of `VIEW_ANGLE_DEG`, with ambient occlusion: for solids.
    """

    direction: FloatArray
    up: FloatArray
    focal_point: FloatArray
    half_height: float
    perspective: bool = False

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, upwards and towards the viewer, as rows (3, 3)."""
        back = -np.asarray(self.direction, dtype=float)
        back = back / np.linalg.norm(back)
        right = np.cross(self.up, back)
        right = right / np.linalg.norm(right)
        return np.stack((right, np.cross(back, right), back))

    @property
    def distance(self) -> float:
        """Distance of the viewer from the focal point, mm. In parallel projection it does not change the
        picture."""
        if not self.perspective:
            return 20.0 * self.half_height
        return float(self.half_height / np.tan(0.5 * np.radians(VIEW_ANGLE_DEG)))

    def seen(self, points: ArrayLike) -> FloatArray:
        """Return points (..., 3) as seen (..., 2): mm to the right and upwards in the plane through the focal
        point."""
        offset = (np.asarray(points, dtype=float) - self.focal_point) @ self.axes.T
        if not self.perspective:
            return np.asarray(offset[..., :2])
        return np.asarray(offset[..., :2] / (1.0 - offset[..., 2:] / self.distance))

    def mm_per_px(self, size_px: Size) -> float:
        """Return the size of a pixel, mm, in a picture of this size."""
        return float(2.0 * self.half_height / size_px[1])


def fit_camera(
    points: ArrayLike,
    direction: ArrayLike,
    up: ArrayLike,
    size_px: Size,
    margin: float = 0.05,
    perspective: bool = False,
) -> Camera:
    """Return a camera that shows all points.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        Points that must be visible, mm.
    direction, up : array_like, shape (3,)
        Viewing direction and upward direction.
    size_px : tuple of int
        Width and height of the picture, pixels.
    margin : float
        Margin on each side, as a fraction of the picture.
    perspective : bool
        True for a perspective picture.

    Returns
    -------
    Camera
        Camera with its focal point at the centre of the points.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    direction, up = np.asarray(direction, dtype=float), np.asarray(up, dtype=float)
    axes = Camera(direction, up, np.zeros(3), 1.0).axes
    inside = points @ axes.T
    low, high = inside.min(axis=0), inside.max(axis=0)
    focus, half_height = (low + high) / 2.0 @ axes, float(np.linalg.norm(high - low)) + 1e-9
    # In perspective, the centre of the picture depends on the distance: each step gains about a digit.
    for _ in range(8 if perspective else 1):
        camera = Camera(direction, axes[1], focus, half_height, perspective)
        seen = camera.seen(points)
        first, last = seen.min(axis=0), seen.max(axis=0)
        half = (last - first) / (2.0 * (1.0 - 2.0 * margin))
        focus = focus + (first + last) / 2.0 @ axes[:2]
        half_height = max(float(half[1]), float(half[0]) * size_px[1] / size_px[0], 1e-9)
    return Camera(direction, axes[1], focus, half_height, perspective)
