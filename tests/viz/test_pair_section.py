"""The section in Fig. 1: both members cut by one plane that holds the common normal, without overlap."""

from __future__ import annotations

import numpy as np
from matplotlib.path import Path

from beveloid_geom import path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_viz.figures.paper import fig_01_pair as fig_pair

from ..oracle.table1 import table1


def depth(point: FloatArray, outline: FloatArray) -> float:
    """Distance of a point from a closed outline."""
    start, way = outline[:-1], np.diff(outline, axis=0)
    share = ((point - start) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-30)
    return float(np.linalg.norm(start + np.clip(share, 0.0, 1.0)[:, None] * way - point, axis=1).min())


def test_one_plane_cuts_both_members_and_they_touch_in_one_place() -> None:
    design = table1()
    data = fig_pair.compute(design)
    normal = path_of_contact(design, "right", 3).normal[1]
    np.testing.assert_allclose(data.axes @ normal, [0.0, -1.0], atol=1e-12)
    flat = []
    for found in data.sections:
        outline = max(found, key=len) - data.pair.contact
        np.testing.assert_array_equal(outline[0], outline[-1])
        np.testing.assert_allclose(outline @ np.cross(*data.axes), 0.0, atol=1e-4)
        flat.append(outline @ data.axes.T)
    for own, other in (flat, flat[::-1]):
        near = own[np.linalg.norm(own, axis=1) < 20.0]
        assert len(near) > 50
        inside = near[Path(other).contains_points(near)]
        assert all(depth(point, other) < 0.05 for point in inside)  # what the meshes are exact to
        assert np.linalg.norm(near, axis=1).min() < 1.0
