"""The load of a contact on a flank of hexahedra: Hertz's pressure as equivalent nodal forces.

A force F at the point x of a face does the work F.u(x) with u = sum N_i u_i, N_i the shape
functions of the face: its equivalent nodal forces are N_i F. They add up to F, and their
moment is that of F at x. The pressure on the ellipse of contact is many such forces, all along the
normal of the contact, on a grid that is symmetric about it and finer than the faces: their
resultant is the whole force at the contact, whatever the mesh. Where the ellipse is smaller than a
face, its nodes take it all.

An ellipse that reaches past the flank is cut at its edges, and as much on the opposite side, for
the resultant to stay where it is; the rest carries the force. It is the part on the flank of the
ellipse under a greater force: in the limit of a line contact that is Hertz's strip.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray, Indices, Mask
from ...contact.hertz import HertzEllipse, contact_modulus, hertz_ellipse
from ...shapes.elements import VolumeMesh, face_nodes, shape_functions
from .material import POISSON, YOUNG

CANDIDATES = 16
"""Faces, by their centres, among which that of a point is looked for."""
INSIDE = 1e-9
"""How far beyond its edges, in isoparametric coordinates, a face still holds a point."""
MOST_APART = 0.25
"""Distance of the point from the mesh that is taken as its faceting, in lengths of the face."""
PER_FACE, FEWEST, MOST = 6, 24, 256
"""Places of the grid along an axis of the ellipse: on each face it passes, at least and at most."""
FOUND = 1e-3
"""Relative precision of the force under which a cut ellipse is that of the contact."""


@dataclass(frozen=True, eq=False)
class ContactPlace:
    """A contact on a member: `point` (3,), mm, unit `normal` (3,) out of the metal, relative `curvature`
    (2,), 1/mm, smaller first, and its unit directions `direction` (2, 3)."""

    point: FloatArray
    normal: FloatArray
    curvature: FloatArray
    direction: FloatArray


@dataclass(frozen=True, eq=False)
class ContactLoad:
    """Equivalent nodal forces of a contact.

    `nodes` (n,), indices of points; `forces` (n, 3), N; `point` (3,): where their resultant acts, on the
    mesh, mm; `gap`: distance (mm) of the contact from there; `ellipse`: that of the pressure; `cut`:
    whether the flank's edges cut it, and the ellipse is that of a greater force."""

    nodes: Indices
    forces: FloatArray
    point: FloatArray
    gap: float
    ellipse: HertzEllipse
    cut: bool

    @property
    def total(self) -> FloatArray:
        """Sum (3,) of the nodal forces, N."""
        return np.asarray(self.forces.sum(axis=0))

    @property
    def told(self) -> str:
        """The load in words."""
        (a, b), cut = self.ellipse.semi_axes, ", cut at the flank's edges" if self.cut else ""
        size = f"{2.0 * a:.4g} by {2.0 * b:.3g} mm{cut}"
        return f"Hertz's pressure on an ellipse of {size}, {self.ellipse.pressure:.0f} MPa at most"


@dataclass(frozen=True, eq=False)
class _Sight:
    """A surface seen along the normal of a contact: `corners` (f, 4 or 8, 3) of its faces, mm, by the
    directions and the normal of the contact from there, and the `tree` of their centres."""

    corners: FloatArray
    tree: Any


@dataclass(frozen=True, eq=False)
class _Sample:
    """Forces (n,), N, of a pressure on places of the mesh: which `face` and where on it (n, 2)."""

    force: FloatArray
    face: Indices
    parameter: FloatArray
    cut: bool


def contact_load(mesh: VolumeMesh, surface: str, place: ContactPlace, force: float) -> ContactLoad:
    """Find the nodal forces of a `force` (N) against the normal of a contact, on the named surface of one
    tooth of steel pressed against another.

    Raises ValueError where the contact is not on that surface, where the flanks cut each other beside
    it, or where a number is not finite."""
    if not (np.isfinite(place.point).all() and np.isfinite(place.normal).all() and 0.0 < force < np.inf):
        raise ValueError(f"point and force must be finite, got {place.point} mm and {force} N")
    nodes = face_nodes(mesh, mesh.surfaces[surface])
    sight = _seen(mesh.points[nodes], place)
    gap = _gap(sight, surface, place)
    ellipse, sample = _pressed(sight, place.curvature, force)
    values, _ = shape_functions(nodes.shape[1], sample.parameter)
    own = values * (sample.force / sample.force.sum())[:, None]
    shares = np.bincount(nodes[sample.face].ravel(), own.ravel(), len(mesh.points))
    loaded = np.flatnonzero(shares)
    forces = np.multiply.outer(shares[loaded] / shares.sum(), -force * place.normal)
    return ContactLoad(loaded, forces, place.point + gap * place.normal, abs(gap), ellipse, sample.cut)


def _seen(corners: FloatArray, place: ContactPlace) -> _Sight:
    from scipy.spatial import cKDTree

    own = (corners - place.point) @ np.stack((*place.direction, place.normal), axis=-1)
    return _Sight(own, cKDTree(own[..., :2].mean(axis=1)))


def _gap(sight: _Sight, surface: str, place: ContactPlace) -> float:
    """Find the height (mm) of the mesh over the contact. Raises ValueError where it has no face there."""
    face, parameter = _located(sight, np.zeros((1, 2)))
    if face[0] >= 0:
        corners = sight.corners[face[0]]
        values, _ = shape_functions(len(corners), parameter[0])
        gap = float(values @ corners[:, 2])
        if abs(gap) <= MOST_APART * np.linalg.norm(corners[2] - corners[0]):
            return gap
    text = f"the {surface} has no face at the contact point ({', '.join(f'{x:.4f}' for x in place.point)}) mm"
    raise ValueError(f"{text}: does the mesh hold the tooth in contact?")


def _pressed(sight: _Sight, curvature: FloatArray, force: float) -> tuple[HertzEllipse, _Sample]:
    """Give the ellipse whose part on the surface carries the force, and the pressure there."""
    from scipy.optimize import brentq

    modulus = contact_modulus(YOUNG, POISSON)
    ellipse = hertz_ellipse(curvature, force, modulus)
    if not np.isfinite(ellipse.pressure):
        text = f"the flanks cut each other beside the contact (relative curvature {curvature[0]:.3g} 1/mm)"
        raise ValueError(f"{text}: there is no contact to load, take weaker parabolas")
    sample = _sampled(sight, ellipse, PER_FACE)
    if not sample.cut:
        return ellipse, sample

    def carried(log_force: float) -> float:
        ellipse = hertz_ellipse(curvature, np.exp(log_force), modulus)
        return float(np.log(_sampled(sight, ellipse, 1).force.sum() / force))

    low = high = float(np.log(force))
    while carried(high) < 0.0:
        high += 1.0
    ellipse = hertz_ellipse(curvature, np.exp(brentq(carried, low, high, xtol=FOUND)), modulus)
    return ellipse, _sampled(sight, ellipse, PER_FACE)


def _sampled(sight: _Sight, ellipse: HertzEllipse, per_face: int) -> _Sample:
    """Give the pressure on a grid of the places that are on the surface with those opposite."""
    half = np.minimum(ellipse.semi_axes, np.abs(sight.corners[..., :2]).max(axis=(0, 1)))
    step = np.ptp(sight.corners[..., :2], axis=1).min(axis=0)
    counts = np.clip(np.ceil(2.0 * half * per_face / step), FEWEST, MOST)
    x, y = (h / n * np.arange(1.0 - n, n, 2.0) for h, n in zip(half, counts, strict=True))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    square = 1.0 - ((places / ellipse.semi_axes) ** 2).sum(axis=-1)
    places, square = places[square > 0.0], square[square > 0.0]
    face, parameter = _located(sight, places)
    on = (face >= 0) & (face >= 0)[::-1]
    force = ellipse.pressure * np.sqrt(square) * float(np.prod(2.0 * half / counts))
    cut = not on.all() or bool((half < ellipse.semi_axes).any())
    return _Sample(force[on], face[on], parameter[on], cut)


def _located(sight: _Sight, places: FloatArray) -> tuple[Indices, FloatArray]:
    """Find which face (n,) is seen at each of the `places` (n, 2), -1 for none, and where on it (n, 2)."""
    count = min(CANDIDATES, len(sight.corners))
    _, near = sight.tree.query(places, k=np.arange(1, count + 1))
    face, parameter = np.full(len(places), -1), np.zeros((len(places), 2))
    for column in near.T:
        rest = np.flatnonzero(face < 0)
        found = _parameters(sight.corners[column[rest], :, :2], places[rest])
        holds: Mask = np.abs(found).max(axis=-1) <= 1.0 + INSIDE
        face[rest[holds]], parameter[rest[holds]] = column[rest[holds]], found[holds]
    return face, parameter


def _parameters(corners: FloatArray, places: FloatArray) -> FloatArray:
    """Find the isoparametric coordinates (k, 2) of places (k, 2) on faces (k, size, 2) of the plane, by
    Newton's method; of a face far from the place any that are outside, or NaN."""
    parameter = np.zeros_like(places)
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(20):
            values, slopes = shape_functions(corners.shape[1], parameter)
            way = places - np.einsum("kni,kn->ki", corners, values)
            (a, b), (c, d) = np.einsum("kni,knj->ijk", corners, slopes)
            step = np.stack((d * way[:, 0] - b * way[:, 1], a * way[:, 1] - c * way[:, 0]), axis=-1)
            step /= (a * d - b * c)[:, None]
            parameter = np.clip(parameter + step, -3.0, 3.0)
            if not np.nanmax(np.abs(step), initial=0.0) > 1e-13:
                break
    return parameter
