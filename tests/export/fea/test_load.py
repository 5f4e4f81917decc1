"""Nodal forces of a contact: resultant and Hertz's pressure."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.hertz import contact_modulus, hertz_ellipse
from beveloid_geom.export.fea.abaqus import fixed_nodes
from beveloid_geom.export.fea.load import ContactPlace, contact_load
from beveloid_geom.shapes.hexahedral_mesh import shape_functions
from tests.export.fea.test_volumes import SIZE, block, case_of, place_at
from tests.shapes.test_hexahedral_mesh import reference_nodes


@pytest.mark.slow
@pytest.mark.parametrize("nodes", [8, 20])
@settings(max_examples=8, deadline=None)
@given(
    place=st.tuples(st.floats(3.0, 37.0), st.floats(3.0, 17.0)),
    force=st.sampled_from([0.1, 950.0, 5e4]),
    curvature=st.sampled_from([(0.002, 0.04), (0.04, 0.04), (1e-7, 0.04), (0.0, 0.04)]),
    turn=st.floats(0.0, 3.0),
)
def test_the_resultant_is_the_force_at_the_contact(
    nodes: int, place: tuple[float, float], force: float, curvature: tuple[float, float], turn: float
) -> None:
    """The sum is the force along the normal, and its moment about the contact is zero.

    This holds for an ellipse that is smaller than a face, larger than many faces, or cut by the edges of the
    flank."""
    mesh, contact = block(nodes), place_at(*place, curvature, turn)
    load = contact_load(mesh, "right flank", contact, force)
    assert load.gap < {8: 0.06, 20: 1e-9}[nodes]  # 20 nodes hold the parabola, 8 its chords
    np.testing.assert_allclose(load.total, -force * contact.normal, rtol=0, atol=1e-13 * force)
    arms = mesh.points[load.nodes] - contact.point
    moment = np.cross(arms, load.forces).sum(axis=0) / force
    np.testing.assert_allclose(moment, 0.0, rtol=0, atol=1e-11)
    assert np.linalg.norm(np.cross(load.point - contact.point, contact.normal)) < 1e-12
    assert set(load.nodes) <= set(mesh.node_sets["right flank"])


def on_plane(at: tuple[float, float], curvature: tuple[float, float], axes: FloatArray) -> ContactPlace:
    """Return a contact on the right flank of a block with plane sides."""
    normal = np.array([1.0, 0.0, 0.0])
    return ContactPlace(np.array([SIZE[0], *at]), normal, np.array(curvature), axes)


def test_an_ellipse_within_a_face_loads_that_face() -> None:
    """For a very small ellipse, the shares are the shape functions at the contact."""
    flat = block(20, shape=lambda points: points)
    contact = on_plane((23.0, 11.0), (0.04, 0.04), np.eye(3)[1:])
    load = contact_load(flat, "right flank", contact, 1e-6)
    assert not load.cut
    assert len(load.nodes) == 8
    corners = flat.points[load.nodes]
    low = corners.min(axis=0)
    at = (contact.point - low)[1:] / np.ptp(corners, axis=0)[1:] * 2.0 - 1.0
    places = (corners - low)[:, 1:] / np.ptp(corners, axis=0)[1:] * 2.0 - 1.0
    order = [int(np.argmin(np.abs(places - node).sum(axis=1))) for node in reference_nodes(8)]
    shares = load.forces[order, 0] / -1e-6
    np.testing.assert_allclose(shares, shape_functions(8, at)[0], rtol=0, atol=1e-6)


def test_the_pressure_is_that_of_hertz() -> None:
    """The second moments about the axes of the ellipse are a^2 / 5 and b^2 / 5.

    Faces with 8 nodes represent them exactly, because their shape functions are quadratic."""
    flat = block(20, (3, 8, 6), shape=np.array)
    contact = on_plane((21.0, 9.0), (0.001, 0.02), np.eye(3)[1:])
    load = contact_load(flat, "right flank", contact, 3000.0)
    assert not load.cut
    expected = hertz_ellipse(contact.curvature, 3000.0, contact_modulus(206000.0, 0.3))
    np.testing.assert_array_equal(load.ellipse.semi_axes, expected.semi_axes)
    arms = (flat.points[load.nodes] - contact.point)[:, 1:]
    second = (load.forces[:, 0] / -3000.0) @ arms**2
    np.testing.assert_allclose(second, expected.semi_axes**2 / 5.0, rtol=3e-3)
    assert f"{2 * expected.semi_axes[0]:.4g} by {2 * expected.semi_axes[1]:.3g} mm, " in load.description


def test_a_line_contact_is_the_strip_on_the_flank() -> None:
    """The half-width is that of two cylinders along z on a face 20 mm wide, b^2 = 4 F R / (pi L E*), and the
    complete strip is loaded."""
    flat = block(20, (3, 8, 6), shape=np.array)
    contact = on_plane((21.0, 10.0), (0.0, 0.02), np.eye(3)[[2, 1]])
    load = contact_load(flat, "right flank", contact, 3000.0)
    assert load.cut
    assert "cut at the flank's edges" in load.description
    b = np.sqrt(4.0 * 3000.0 / (0.02 * np.pi * SIZE[2] * contact_modulus(206000.0, 0.3)))
    assert load.ellipse.semi_axes[1] == pytest.approx(b, rel=0.02)
    along = (flat.points[load.nodes] - contact.point)[:, 2]
    assert (load.forces[:, 0] / -3000.0) @ along**2 == pytest.approx(SIZE[2] ** 2 / 12.0, rel=2e-3)


def test_a_line_of_known_ends_is_loaded_evenly_between_them() -> None:
    """12 mm of a face 20 mm wide carry q = F / 12 mm. Rounding makes the curvature along the line
    negative."""
    flat = block(20, (3, 8, 20), shape=np.array)
    contact = replace(on_plane((21.0, 9.0), (-5e-21, 0.02), np.eye(3)[[2, 1]]), length=12.0)
    load = contact_load(flat, "right flank", contact, 3000.0)
    modulus = contact_modulus(206000.0, 0.3)
    assert load.ellipse.pressure == pytest.approx(np.sqrt(250.0 * modulus * 0.02 / np.pi), rel=1e-12)
    assert load.ellipse.semi_axes.tolist() == pytest.approx([6.0, 500.0 / np.pi / load.ellipse.pressure])
    np.testing.assert_allclose(load.total, (-3000.0, 0.0, 0.0), rtol=0, atol=1e-9)
    along = (flat.points[load.nodes] - contact.point)[:, 2]
    share = load.forces[:, 0] / -3000.0
    assert share @ along == pytest.approx(0.0, abs=1e-9)
    assert share @ along**2 == pytest.approx(12.0, rel=1e-2)
    assert np.abs(along).max() < 6.0 + SIZE[2] / 20
    assert load.description.startswith("Hertz's pressure on a strip of 12 by ")


@pytest.mark.parametrize(
    ("change", "force", "words"),
    [
        ({"point": np.array([30.0, 60.0, 10.0])}, 1.0, "no face at the contact point (30.0000, 60.0000"),
        ({"point": np.array([60.0, 20.0, 10.0])}, 1.0, "no face at the contact point"),
        ({"point": np.array([30.0, 20.0, np.nan])}, 1.0, "must be finite"),
        ({}, np.inf, "must be finite"),
        ({"curvature": np.array([-1e-4, 0.04])}, 1.0, "the flanks penetrate next to the contact"),
    ],
)
def test_contacts_without_a_face_are_rejected(change: dict[str, Any], force: float, words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        contact_load(block(20), "right flank", replace(place_at(20.0, 10.0), **change), force)


def test_a_load_on_held_nodes_is_rejected() -> None:
    mesh = block(20, (1, 1, 1))
    with pytest.raises(ValueError, match="acts on nodes that are held"):
        fixed_nodes(mesh, case_of(mesh))
