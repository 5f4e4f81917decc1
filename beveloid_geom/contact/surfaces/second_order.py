"""Tangents and curvatures of modified flanks at the positions of a path, and the direction of the path."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, Integers
from ...design.member import Member
from ...gear.flank import turned
from ...gear.rack import rack_of, rack_point, rack_tangent
from ...gear.tooth_side import flank_surface
from ...pair.frames import layout_by_case, member_frame, normals_to_fixed
from ..flank_pair import generated_pairing
from ..path import ContactPath
from .problems import by_members, problems_of
from .tangency import Contacts, contacts_at, jet_at, normals_of


def tangents_and_turns(path: ContactPath) -> tuple[tuple[FloatArray, FloatArray], ...]:
    """Return tangents by l and u of pinion and gear, and the derivatives of the outward unit normals, in S_f.

    Each is (n, 3, 2) for n contacts.
    """
    design, count = path.design, path.l1.shape[-1]
    cases = max(1, int(np.prod(path.l1.shape[:-1])))
    result = np.empty((2, 2, cases, count, 3, 2))
    layout = layout_by_case(design)
    rows = ((path.l1, path.pinion_z, path.pinion_roll), (path.l2, path.gear_z, path.gear_roll))
    for single, index in by_members(design):
        for j, member in enumerate(single.members):
            l, z, roll = (np.reshape(values, (cases, count))[index] for values in rows[j])
            phi, pairs = _steps_and_turns(member, path.flank, l.ravel(), z.ravel())
            frame = member_frame(layout, j, 0.0, 0.0)[0]
            frame = np.broadcast_to(frame, (cases, 1, 3, 3))[index]
            angle = roll + phi.reshape(l.shape)
            cos, sin = np.cos(angle), np.sin(angle)
            for k, pair in enumerate(pairs):
                for column, vector in enumerate(pair):
                    x, y, height = vector.reshape(3, *l.shape)
                    fixed = np.stack((cos * x - sin * y, sin * x + cos * y, height), axis=-1)
                    result[j, k, index, :, :, column] = normals_to_fixed((frame, fixed), fixed)
    flat = result.reshape(2, 2, -1, 3, 2)
    return tuple((flat[j, 0], flat[j, 1]) for j in (0, 1))


def modified_normal_rates(
    member: Member, flank: str, l: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the result of `gear.flank.normal_rates` for a modified flank of a single member, with the
    modification."""
    l, u = np.broadcast_arrays(l, u)
    rack = rack_of(member, flank)
    z = rack_point(rack, l)[2] + u * rack.trace[2]
    phi, (_, turns) = _steps_and_turns(member, flank, l.ravel(), z.ravel())
    by_l, by_u = (turned(phi, *turn).reshape(*l.shape, 3) for turn in turns)
    return by_l, by_u


def _steps_and_turns(
    member: Member, flank: str, l: FloatArray, z: FloatArray
) -> tuple[FloatArray, tuple[tuple[FloatArray, FloatArray], ...]]:
    """Return the rotation phi (rad) of flank points (n,), and before this rotation their tangents by l and u
    and the derivatives of the outward unit normal, each (3, n)."""
    surface, rack = flank_surface(member, flank), rack_of(member, flank)
    jet = jet_at(surface, l, z)
    by_s, by_z = np.array((*jet.plane[1], np.zeros_like(l))), np.array((*jet.plane[2], np.ones_like(l)))
    normal, normal_s, normal_z = normals_of(jet)
    size = np.sqrt((normal * normal).sum(axis=0))
    unit = normal / size
    turn_s, turn_z = (
        -surface.sigma * (rate - unit * (unit * rate).sum(axis=0)) / size for rate in (normal_s, normal_z)
    )
    # z = z0(l) + u t_z
    along, steep = rack_tangent(rack, l)[2], float(rack.trace[2])
    pairs = (by_s, by_z), (turn_s, turn_z)
    return jet.phi, tuple((first + along * second, steep * second) for first, second in pairs)


def contacts_on(path: ContactPath) -> list[tuple[Integers, FloatArray, Contacts]]:
    """Return the contacts of all positions, for each pair of different members.

    Each entry has the numbers of the cases, cosine and sine of the shaft angle (2, n), and n contacts.
    """
    design, count = path.design, path.l1.shape[-1]
    cases, pairing = max(1, int(np.prod(path.l1.shape[:-1]))), generated_pairing(design, path.flank)
    rows = (path.l1, path.pinion_z, path.pinion_roll, path.l2)
    result = []
    for _, index, problem in problems_of(design, path.flank, pairing):
        state = np.array([np.reshape(values, (cases, count))[index].ravel() for values in rows])
        placed = problem.placed.take(np.repeat(np.arange(index.size), count))
        met = contacts_at(problem.surfaces, placed, state)
        result.append((index, np.array((placed.cos, placed.sin)), met))
    return result


def path_tangents(path: ContactPath) -> FloatArray:
    """Return tangents (cases, positions, 3) of the path in S_f, of any length and sense."""
    count = path.l1.shape[-1]
    result = np.empty((max(1, int(np.prod(path.l1.shape[:-1]))), count, 3))
    for index, (cos, sin), met in contacts_on(path):
        x, y, z = (met.moves * met.tangent).sum(axis=1)
        fixed = np.stack((-x, sin * z - cos * y, sin * y + cos * z), axis=-1)
        result[index] = fixed.reshape(index.size, count, 3)
    return result


def least_rates(path: ContactPath) -> FloatArray:
    """Return the least singular value (...), 1/mm, of the equations of tangency at the positions of a path:
    change of the angle between the flanks per distance.
    """
    result = np.empty((max(1, int(np.prod(path.l1.shape[:-1]))), path.l1.shape[-1]))
    for index, _, met in contacts_on(path):
        steps = np.sqrt((met.moves * met.moves).sum(axis=0))
        normal = np.sqrt((normals_of(met.jets[1])[0] ** 2).sum(axis=0))
        rows = np.moveaxis(met.gradient / (steps[:2, None] * steps * normal), -1, 0)
        result[index] = least_singular_value(rows).reshape(index.size, -1)
    return result.reshape(path.l1.shape)


def least_singular_value(jacobian: FloatArray) -> FloatArray:
    """Return the least singular value of Jacobians (..., equations, unknowns), NaN where these are NaN."""
    known = np.asarray(np.isfinite(jacobian).all(axis=(-1, -2)))
    least = np.linalg.svd(np.where(known[..., None, None], jacobian, 0.0), compute_uv=False)[..., -1]
    return np.where(known, least, np.nan)
