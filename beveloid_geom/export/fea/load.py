"""Load of a contact on a flank of hexahedra: Hertz's pressure as equivalent nodal forces.

A force F at the point x of a face does the work F.u(x) with u = sum N_i u_i, where N_i are the shape
functions of the face. Its equivalent nodal forces are N_i F. Their sum is F, and their moment is that of F at
x. The pressure on the contact ellipse is represented by many such forces along the normal of the contact, on
a grid that is symmetric about the contact and finer than the faces. Their resultant is the complete force at
the contact for any mesh. If the ellipse is smaller than a face, the nodes of this face take all of it.

An ellipse that exceeds the flank is cut at the edges of the flank, and by the same amount on the opposite
side, so that the resultant stays at the contact. The remaining part has to carry the given force. Therefore
the ellipse and its pressure are those of a larger force, of which the remaining part carries the given one.
In the limit of a line contact this is Hertz's strip.

A line of contact with known ends is loaded by a strip of this length, with constant pressure along the line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import FloatArray, Indices, Mask
from ...contact.hertz import HertzEllipse, contact_modulus, hertz_ellipse, hertz_strip
from ...shapes.hexahedral_mesh import VolumeMesh, face_nodes, shape_functions
from .material import POISSON_RATIO, YOUNG_MPA


@dataclass(frozen=True, eq=False)
class ContactPlace:
    """Contact on a member.

    Attributes
    ----------
    point : array (3,)
        Contact point, mm.
    normal : array (3,)
        Unit normal out of the metal.
    curvature : array (2,)
        Relative curvatures, 1/mm, the smaller one first.
    direction : array (2, 3)
        Unit vectors of the directions of these curvatures.
    length : float, optional
        Length (mm) of a line of contact along the first direction, with the point in its middle. None for an
        ellipse.
    """

    point: FloatArray
    normal: FloatArray
    curvature: FloatArray
    direction: FloatArray
    length: float | None = None


@dataclass(frozen=True, eq=False)
class ContactLoad:
    """Equivalent nodal forces of a contact.

    Attributes
    ----------
    nodes : array (n,)
        Indices of the loaded points.
    forces : array (n, 3)
        Forces, N.
    point : array (3,)
        Point of the mesh where their resultant acts, mm.
    gap : float
        Distance of the contact from this point, mm.
    ellipse : HertzEllipse
        Ellipse of the pressure. For a line of contact the semi-axes are half its length and half the width of
        the strip.
    cut : bool
        Whether the edges of the flank cut the ellipse, so that it is the ellipse of a larger force.
    strip : bool
        Whether the contact is a line.
    """

    nodes: Indices
    forces: FloatArray
    point: FloatArray
    gap: float
    ellipse: HertzEllipse
    cut: bool
    strip: bool = False

    @property
    def total(self) -> FloatArray:
        """Sum (3,) of the nodal forces, N."""
        return np.asarray(self.forces.sum(axis=0))

    @property
    def description(self) -> str:
        """Shape, size and largest pressure of the load."""
        (a, b), cut = self.ellipse.semi_axes, ", cut at the flank's edges" if self.cut else ""
        size = f"{2.0 * a:.4g} by {2.0 * b:.3g} mm{cut}"
        shape = "a strip" if self.strip else "an ellipse"
        return f"Hertz's pressure on {shape} of {size}, {self.ellipse.pressure:.0f} MPa at most"


@dataclass(frozen=True, eq=False)
class _View:
    """A surface in the frame of a contact, seen along its normal.

    `corners` (f, 4 or 8, 3): nodes of its faces, mm, along the directions and the normal of the contact;
    `tree`: search tree of the face centres."""

    corners: FloatArray
    tree: Any


@dataclass(frozen=True, eq=False)
class _Sample:
    """Forces (n,), N, of a pressure: `face` and isoparametric coordinates (n, 2) of their points."""

    force: FloatArray
    face: Indices
    parameter: FloatArray
    cut: bool


def contact_load(mesh: VolumeMesh, surface: str, place: ContactPlace, force: float) -> ContactLoad:
    """Return the nodal forces of a steel tooth that is pressed against another one.

    Parameters
    ----------
    mesh : VolumeMesh
        Mesh of the tooth.
    surface : str
        Name of the loaded surface.
    place : ContactPlace
        Contact on this surface.
    force : float
        Force against the normal of the contact, N.

    Returns
    -------
    ContactLoad

    Raises
    ------
    ValueError
        If the contact is not on the surface, the flanks intersect next to it, a number is not finite, or the
        force is not above 0.
    """
    if not (np.isfinite(place.point).all() and np.isfinite(place.normal).all() and 0.0 < force < np.inf):
        text = "point and normal must be finite, the force finite and above 0"
        raise ValueError(f"{text}, got {place.point} mm, {place.normal} and {force} N")
    nodes = face_nodes(mesh, mesh.surfaces[surface])
    view = _view(mesh.points[nodes], place)
    gap = _gap(view, surface, place)
    ellipse, sample = _pressed(view, place, force)
    # Distribute each force to the nodes of its face by the shape functions, and scale the sum to the force.
    values, _ = shape_functions(nodes.shape[1], sample.parameter)
    weights = values * (sample.force / sample.force.sum())[:, None]
    shares = np.bincount(nodes[sample.face].ravel(), weights.ravel(), len(mesh.points))
    loaded = np.flatnonzero(shares)
    forces = np.multiply.outer(shares[loaded] / shares.sum(), -force * place.normal)
    resultant, strip = place.point + gap * place.normal, place.length is not None
    return ContactLoad(loaded, forces, resultant, abs(gap), ellipse, sample.cut, strip)


def _view(corners: FloatArray, place: ContactPlace) -> _View:
    from scipy.spatial import cKDTree

    local = (corners - place.point) @ np.stack((*place.direction, place.normal), axis=-1)
    return _View(local, cKDTree(local[..., :2].mean(axis=1)))


def _gap(view: _View, surface: str, place: ContactPlace) -> float:
    """Return the height (mm) of the mesh over the contact. Raises ValueError if there is no face."""
    face, parameter = _located(view, np.zeros((1, 2)))
    if face[0] >= 0:
        corners = view.corners[face[0]]
        values, _ = shape_functions(len(corners), parameter[0])
        gap = float(values @ corners[:, 2])
        # A larger distance is not due to the facets of the mesh.
        if abs(gap) <= 0.25 * np.linalg.norm(corners[2] - corners[0]):
            return gap
    text = f"the {surface} has no face at the contact point ({', '.join(f'{x:.4f}' for x in place.point)}) mm"
    raise ValueError(f"{text}: does the mesh contain the tooth in contact?")


def _pressed(view: _View, place: ContactPlace, force: float) -> tuple[HertzEllipse, _Sample]:
    """Return the ellipse or strip whose part on the surface carries the force, and its pressure there."""
    # Grid points of the pressure per face, along each axis of the ellipse.
    grid_per_face = 6
    from scipy.optimize import brentq

    modulus, curvature = contact_modulus(YOUNG_MPA, POISSON_RATIO), place.curvature
    if place.length is not None:
        half_width, pressure = hertz_strip(curvature[1], force / place.length, modulus)
        axes = np.array((0.5 * place.length, float(half_width)))
        strip = HertzEllipse(np.asarray(force), axes, pressure)
        # Parts of the strip beyond the faceted edges of the mesh are omitted; the caller scales the sample.
        return strip, replace(_sampled(view, strip, grid_per_face, strip=True), cut=False)
    ellipse = hertz_ellipse(curvature, force, modulus)
    if not np.isfinite(ellipse.pressure):
        text = f"the flanks penetrate next to the contact (relative curvature {curvature[0]:.3g} 1/mm)"
        raise ValueError(f"{text}: no load can be applied, use smaller parabola coefficients")
    sample = _sampled(view, ellipse, grid_per_face)
    if not sample.cut:
        return ellipse, sample

    # Solve for the larger force under which the part on the flank carries the given one.
    def excess(log_force: float) -> float:
        ellipse = hertz_ellipse(curvature, np.exp(log_force), modulus)
        return float(np.log(_sampled(view, ellipse, 1).force.sum() / force))

    low = high = float(np.log(force))
    while excess(high) < 0.0:
        high += 1.0
    log_force = brentq(excess, low, high, xtol=1e-3)
    ellipse = hertz_ellipse(curvature, np.exp(log_force), modulus)
    return ellipse, _sampled(view, ellipse, grid_per_face)


def _sampled(view: _View, ellipse: HertzEllipse, per_face: int, strip: bool = False) -> _Sample:
    """Return the pressure on a grid of points that are on the surface together with their opposite points.

    The pressure of a `strip` is constant along its length."""
    half = np.minimum(ellipse.semi_axes, np.abs(view.corners[..., :2]).max(axis=(0, 1)))
    step = np.ptp(view.corners[..., :2], axis=1).min(axis=0)
    counts = np.clip(np.ceil(2.0 * half * per_face / step), 24, 256)
    x, y = (h / n * np.arange(1.0 - n, n, 2.0) for h, n in zip(half, counts, strict=True))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    axes = (np.inf, ellipse.semi_axes[1]) if strip else ellipse.semi_axes
    square = 1.0 - ((places / axes) ** 2).sum(axis=-1)
    places, square = places[square > 0.0], square[square > 0.0]
    face, parameter = _located(view, places)
    on = (face >= 0) & (face >= 0)[::-1]  # the reversed grid holds the opposite points
    force = ellipse.pressure * np.sqrt(square) * float(np.prod(2.0 * half / counts))
    cut = not on.all() or bool((half < ellipse.semi_axes).any())
    return _Sample(force[on], face[on], parameter[on], cut)


def _located(view: _View, places: FloatArray) -> tuple[Indices, FloatArray]:
    """Return the face (n,) at each of the `places` (n, 2), -1 for none, and the coordinates (n, 2) on it."""
    count = min(16, len(view.corners))  # faces with the nearest centres are tested
    _, near = view.tree.query(places, k=np.arange(1, count + 1))
    face, parameter = np.full(len(places), -1), np.zeros((len(places), 2))
    for column in near.T:
        open_places = np.flatnonzero(face < 0)
        trial = _parameters(view.corners[column[open_places], :, :2], places[open_places])
        inside: Mask = np.abs(trial).max(axis=-1) <= 1.0 + 1e-9
        located = open_places[inside]
        face[located], parameter[located] = column[located], trial[inside]
    return face, parameter


def _parameters(corners: FloatArray, places: FloatArray) -> FloatArray:
    """Return the isoparametric coordinates (k, 2) of places (k, 2) on plane faces (k, size, 2) by Newton.

    For a face far from the place they are any coordinates outside the face, or NaN."""
    parameter = np.zeros_like(places)
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(20):
            values, slopes = shape_functions(corners.shape[1], parameter)
            residual = places - np.einsum("kni,kn->ki", corners, values)
            (a, b), (c, d) = np.einsum("kni,knj->ijk", corners, slopes)
            step = np.stack(
                (d * residual[:, 0] - b * residual[:, 1], a * residual[:, 1] - c * residual[:, 0]), axis=-1
            )
            step /= (a * d - b * c)[:, None]
            parameter = np.clip(parameter + step, -3.0, 3.0)
            if not np.nanmax(np.abs(step), initial=0.0) > 1e-13:
                break
    return parameter
