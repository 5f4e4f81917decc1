"""Single elements: shape functions, scaled Jacobians, mid-side nodes, distorted elements."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import Any

import numpy as np
import pytest
import pyvista as pv

from beveloid_geom import Member, Tool, tooth_hexahedra
from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.hexahedral_mesh import EDGES, VolumeMesh, element_shapes, shape_functions
from tests.members import MEMBERS, PINION
from tests.shapes.test_hexahedra import few


def reference_nodes(size: int) -> FloatArray:
    """Return isoparametric coordinates of the nodes of faces with 4 or 8 nodes."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
    return np.concatenate((square, 0.5 * (square + np.roll(square, -1, axis=0))))[:size]


def element_nodes(size: int) -> FloatArray:
    corners = np.array([(*xy, z) for z in (-1.0, 1.0) for xy in reference_nodes(4)])
    return np.concatenate((corners, [0.5 * (corners[a] + corners[b]) for a, b in EDGES]))[:size]


@pytest.mark.parametrize(
    "nodes", [reference_nodes(4), reference_nodes(8), element_nodes(8), element_nodes(20)], ids=len
)
def test_shape_functions_are_one_at_their_node_and_reproduce_polynomials(nodes: FloatArray) -> None:
    """Shape functions are 1 at their node. They reproduce polynomials up to x y z, with mid-side nodes up to
    x^2 y z; derivatives equal complex steps."""
    size, axes = nodes.shape
    np.testing.assert_allclose(shape_functions(size, nodes)[0], np.eye(size), rtol=0, atol=1e-15)
    at = np.random.default_rng(2).uniform(-1.0, 1.0, (60, axes))
    values, slopes = shape_functions(size, at)
    square = 2 if size > 2**axes else 1
    for powers in ((1, 0, 0), (1, 1, 0), (1, 1, 1), (square, 0, 0), (square, 1, 0), (square, 1, 1)):
        of_nodes, exact = (np.prod(x ** powers[:axes], axis=-1) for x in (nodes, at))
        np.testing.assert_allclose(values @ of_nodes, exact, rtol=0, atol=2e-14)
    for axis, step in enumerate(1e-30j * np.eye(axes)):
        shifted: Any = shape_functions(size, at + step)[0]  # polynomials take complex numbers
        np.testing.assert_allclose(slopes[..., axis], shifted.imag / 1e-30, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", ["pinion", "cone 20"])
def test_scaled_jacobian_agrees_with_verdict(name: str) -> None:
    mesh = few(MEMBERS[name], "C3D8")
    shift = np.random.default_rng(1).normal(0.0, 0.4, mesh.points.shape)
    for size, inverted in ((0.0, False), (1.0, True)):
        bent = replace(mesh, points=mesh.points + size * shift)
        grid = pv.UnstructuredGrid({pv.CellType.HEXAHEDRON: mesh.hexahedra}, bent.points)
        expected = grid.cell_quality("scaled_jacobian").cell_data["scaled_jacobian"]
        assert (expected.min() < 0.0) == inverted
        np.testing.assert_allclose(element_shapes(bent)[0], expected, rtol=1e-9, atol=1e-12)


def test_mid_side_nodes_affect_the_shape() -> None:
    """A mid-side node of a box is moved by d. At both corners of its edge the tangent changes by 2 d
    relative to half the length of the edge."""
    points = element_nodes(20)
    box = VolumeMesh(points, np.arange(20)[None], {}, {}, {})
    assert np.array(element_shapes(box)).ravel() == pytest.approx((1.0, 1.0), abs=1e-14)
    points[8] += (0.0, 0.2, 0.0)
    scaled, ratio = element_shapes(box)
    assert scaled[0] <= 1.0 / np.sqrt(1.0 + 0.4**2) + 1e-12  # both corners of that edge
    assert ratio[0] < 0.91


NEXT_TO_UNDERCUT = replace(
    PINION,
    teeth=31,
    cone_angle=0.17040353,
    helix_angle=0.01422685,
    profile_shift=0.102787976,
    face_width=41.45772,
    tool=replace(PINION.tool, tip_radius=0.354412242, parabola=-0.001),
)
"""A random member for which mid-side nodes at the middle parameter gave a ratio of determinants of 0.13."""


def test_mid_side_nodes_are_over_the_middle_of_their_edges() -> None:
    mesh = tooth_hexahedra(NEXT_TO_UNDERCUT, tolerance=0.2)
    scaled, ratio = element_shapes(mesh)
    assert scaled.min() > 0.6
    assert ratio.min() > 0.3
    x = mesh.points[mesh.hexahedra]
    a, b = (x[:, [ends[k] for ends in EDGES]] for k in (0, 1))
    share = np.einsum("mei,mei->me", x[:, 8:] - a, b - a) / np.einsum("mei,mei->me", b - a, b - a)
    np.testing.assert_allclose(share[:, :8], 0.5, rtol=0, atol=0.01)


def test_distorted_elements_are_rejected() -> None:
    """The mesh of a tooth that is undercut by 1.7 modules is rejected, because its elements are too
    distorted."""
    tool = Tool(1.5, radians(20.0), tip_radius=0.25)
    member = Member(tool, 8, radians(10.35), radians(4.49), -0.2455, 11.94)
    with pytest.raises(ValueError, match=r"too distorted \(scaled Jacobian 0\.1\d, "):
        tooth_hexahedra(member, tolerance=0.0125)
