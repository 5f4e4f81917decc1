"""Normals at first contacts, and the motion of their points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, Mask
from ..design.model import Design
from ..gear.tooth_side import cut_at, surface_of
from ..status import Limit
from .angular_clearance import axes_of, pitch_shift
from .first_contact import FirstContact


def contact_normals(design: Design, flank: str, first: FirstContact) -> FloatArray:
    """Compute the unit normals along which first contacts separate.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}
    first : FirstContact

    Returns
    -------
    ndarray, shape (..., positions, 3)
        In S_f, directed out of the gear's tooth, except for an edge on an edge:
        surface or edge of the pinion on the gear's surface: normal of the gear's surface;
        only edges of the gear touch: normal of the pinion's surface, reversed;
        edge on edge: perpendicular to both edges, in either sense;
        undercut edge on an edge (`touches_undercut_edge`): normal of the gear's surface, because the
        direction of the undercut edge is not computed.
    """
    limit, edge = first.limit, first.limit >= 0
    of_gear = edge[..., 0] & (~edge | (limit % 2 == 1)).all(axis=-1)
    both = _edge_on_edge(first) & ~touches_undercut_edge(first)
    pinion, gear = _surface_normals(design, flank, first)
    normal = np.where(of_gear[..., None], pinion, gear)
    if not both.any():
        return normal
    across = np.cross(*_edge_tangents(design, first, (pinion, gear)))
    with np.errstate(invalid="ignore", divide="ignore"):  # parallel edges
        across /= np.linalg.norm(across, axis=-1, keepdims=True)
    return np.where(both[..., None], across, normal)


def _edge_on_edge(first: FirstContact) -> Mask:
    """Return where (..., positions) an edge of the pinion touches an edge of the gear."""
    limit = first.limit
    return np.asarray((limit >= 0).all(axis=-1) & (limit[..., 0] % 2 != limit[..., 1] % 2))


def touches_undercut_edge(first: FirstContact) -> Mask:
    """Return where an undercut edge touches an edge.

    Parameters
    ----------
    first : FirstContact

    Returns
    -------
    ndarray of bool, shape (..., positions)
    """
    root = (first.limit == Limit.PINION_ROOT) | (first.limit == Limit.GEAR_ROOT)
    return np.asarray(_edge_on_edge(first) & root.any(axis=-1))


def _edge_tangents(
    design: Design, first: FirstContact, normals: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return the directions (..., positions, 3) in S_f of the touching edges of pinion and gear: the
    intersection of the tooth surface, given by its `normals`, with the tip cone or the end
    face."""
    axes, (x, y, z) = axes_of(design), np.moveaxis(first.point, -1, 0)
    offset, sin, cos = (value[..., None] for value in (axes.offset, axes.sin, axes.cos))
    zero, tangents = np.zeros_like(x), []
    for member, (normal, axis) in enumerate(zip(normals, ((0.0, 0.0, 1.0), (0.0, sin, cos)), strict=True)):
        direction = np.stack([zero + value for value in axis], axis=-1)
        arm = np.stack((x - member * offset, y, z), axis=-1)
        radial = arm - (arm * direction).sum(axis=-1, keepdims=True) * direction
        radial /= np.linalg.norm(radial, axis=-1, keepdims=True)
        tip = (first.limit == (Limit.PINION_TIP, Limit.GEAR_TIP)[member]).any(axis=-1)[..., None]
        cone = radial - np.tan(design.members[member].cone_angle) * direction  # r = r_tip + z tan(cone angle)
        tangents.append(np.cross(normal, np.where(tip, cone, direction)))
    return tangents[0], tangents[1]


def with_tangencies(design: Design, flank: str, first: FirstContact) -> FirstContact:
    """Return the first contacts with `limit` set to -1 (no edge) where both surfaces have the same normal.

    If flanks touch along a line, every point of the line is a first contact, including its ends on edges.
    The contact at such an end is a tangency, not an edge contact.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}
    first : FirstContact

    Returns
    -------
    FirstContact
    """
    pinion, gear = _surface_normals(design, flank, first)
    with np.errstate(invalid="ignore"):
        tangent = np.linalg.norm(pinion - gear, axis=-1) <= 1e-6
    return replace(first, limit=np.where(tangent[..., None], np.int8(-1), first.limit))


def _surface_normals(design: Design, flank: str, first: FirstContact) -> tuple[FloatArray, FloatArray]:
    """Return the unit normals (..., positions, 3) of both surfaces in S_f, the pinion's reversed."""
    axes, turns, normals = axes_of(design), pitch_shift(design, first.pair), []
    places = (first.pinion_roll, first.l1, first.z1), (first.gear_roll, first.l2, first.z2)
    for member, turn, (roll, l, z) in zip(design.members, turns, places, strict=True):
        with np.errstate(invalid="ignore"):
            cut = cut_at(surface_of(member, flank), l, z)
        cos, sin = np.cos(cut.phi + roll + turn), np.sin(cut.phi + roll + turn)
        normals.append((cos * cut.nx - sin * cut.ny, sin * cut.nx + cos * cut.ny, cut.nz))
    (px, py, pz), (gx, gy, gz) = normals
    sin, cos = axes.sin[..., None], axes.cos[..., None]
    turned = -gx, sin * gz - cos * gy, sin * gy + cos * gz
    return np.stack((-px, -py, -pz), axis=-1), np.stack(turned, axis=-1)


def moved_by_gear(design: Design, point: FloatArray) -> FloatArray:
    """Compute the velocity of points of the gear per rad of gear roll.

    Parameters
    ----------
    design : Design
    point : ndarray, shape (..., positions, 3)
        Points in S_f, mm.

    Returns
    -------
    ndarray, shape (..., positions, 3)
        mm/rad.
    """
    axes = axes_of(design)
    offset, sin, cos = (value[..., None] for value in (axes.offset, axes.sin, axes.cos))
    x, y, z = np.moveaxis(point, -1, 0)
    return np.stack((sin * z - cos * y, cos * (x - offset), -sin * (x - offset)), axis=-1)
