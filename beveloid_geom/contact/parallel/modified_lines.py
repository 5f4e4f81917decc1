"""Lines of contact of modified flanks on parallel axes.

- Flanks with reliefs only touch along the lines of the generated flanks where neither is relieved. Without
  parabolas l and z are linear along such a line, so that each relief cuts off one of its ends, or all of it.
- Teeth parallel to the axes touch, at each roll, along a line parallel to the axes, for any modification of
  the profile. It ends at the ends of the common face, or where a heel or toe relief begins.

Other lines of teeth with a helix or a cone are not computed: those of modifications that compensate each
other, and those of reliefs together with parabolas.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Codes, FloatArray
from ...design.model import Design
from ...gear.flank import modification_of
from ...gear.modification import Term
from ...status import Limit
from ..flank_pair import FlankPair

LINEAR = ("l1", "l2", "u1", "u2", "pinion_z", "gear_z", "point")
"""Quantities that are linear along a line of contact."""


@dataclass(frozen=True, eq=False)
class LineEnds:
    """Both ends of lines of contact, (..., lines, 2).

    `l1`, `l2`, `u1`, `u2`, `pinion_z` and `gear_z` in mm; `point` in mm, in S_f, with a last axis of 3;
    `limit`: codes of the `Limit` that ends the line.
    """

    l1: FloatArray
    l2: FloatArray
    u1: FloatArray
    u2: FloatArray
    pinion_z: FloatArray
    gear_z: FloatArray
    point: FloatArray
    limit: Codes

    @property
    def length(self) -> FloatArray:
        """Lengths (..., lines), mm."""
        return length_between(self.point)


def length_between(point: FloatArray) -> FloatArray:
    """Return the distances (...), mm, between two points (..., 2, 3)."""
    return np.asarray(np.linalg.norm(point[..., 1, :] - point[..., 0, :], axis=-1))


def has_reliefs_only(design: Design, flank: str) -> bool:
    """Return whether all modifications of both flanks are reliefs."""
    given = (modification_of(member, flank) for member in design.members)
    return all(part is None or len(part.reliefs) == len(part.terms) for part in given)


def across_the_face(pairing: FlankPair, contact: LineEnds) -> LineEnds:
    """Return lines parallel to the axes through contacts, from one end of the common face to the other.

    The arrays of `contact` are (..., lines, 1). The lines are NaN if the faces do not overlap.
    """
    # Positions of the ends of both faces along the axes, (2, cases, 1).
    ends = pairing.position - pairing.half_width, pairing.position + pairing.half_width
    place = np.concatenate((ends[0].max(axis=0), ends[1].min(axis=0)), axis=-1)
    place = np.where(place[:, :1] < place[:, 1:], place, np.nan)
    limit = np.concatenate(
        (Limit.PINION_TOE + ends[0].argmax(axis=0), Limit.PINION_HEEL + ends[1].argmin(axis=0)), axis=-1
    )
    batch, lines = contact.l1.shape[:-2], contact.l1.shape[-2]
    trace = pairing.rack.trace[2]

    def by_line(values: FloatArray) -> FloatArray:
        return np.broadcast_to(values.reshape(*batch, 1, -1), (*batch, lines, values.shape[-1]))

    move = by_line(place - pairing.position[0]) - contact.pinion_z
    still = np.zeros_like(move)
    return LineEnds(
        l1=contact.l1 + still,
        l2=contact.l2 + still,
        u1=contact.u1 + move / by_line(trace[0]),
        u2=contact.u2 + move / by_line(trace[1]),
        pinion_z=contact.pinion_z + move,
        gear_z=contact.gear_z + move,
        point=contact.point + np.stack((still, still, move), axis=-1),
        limit=by_line(limit).astype(np.int8),
    )


def without_reliefs(design: Design, flank: str, line: LineEnds, *, profile: bool = True) -> LineEnds:
    """Return the parts of lines that are on no relief; NaN where nothing remains.

    `limit` names the edge whose relief ends the line. Without `profile`, tip and root reliefs do not end it.
    """
    first, last = np.zeros(line.l1.shape[:-1]), np.ones(line.l1.shape[:-1])
    limit = line.limit.copy()
    for j, place in enumerate(((line.l1, line.pinion_z), (line.l2, line.gear_z))):
        modification = modification_of(design.members[j], flank)
        for term in () if modification is None else modification.reliefs:
            if term.relief == 0 and not profile:
                continue
            before, after = np.moveaxis(_past(term, *place), -1, 0)
            with np.errstate(invalid="ignore", divide="ignore"):
                crossing = before / (before - after)
            enters, leaves = (before > 0.0) & (crossing > first), (after > 0.0) & (crossing < last)
            first, last = np.where(enters, crossing, first), np.where(leaves, crossing, last)
            edge = _edge(term) + j
            limit[..., 0][enters], limit[..., 1][leaves] = edge, edge
            last = np.where((before > 0.0) & (after > 0.0), np.nan, last)
    share = np.stack((first, np.where(last > first, last, np.nan)), axis=-1)
    share = np.where(np.isnan(share[..., 1:]), np.nan, share)
    values = {name: _between(getattr(line, name), share) for name in LINEAR}
    return replace(line, **values, limit=np.where(np.isnan(share), np.int8(-1), limit))


def _past(term: Term, l: FloatArray, z: FloatArray) -> FloatArray:
    """Return the distance (mm) of points (..., lines, 2) past the beginning of a relief; negative where the
    amount of the relief is 0.
    """
    # The batch axes last, as those of the amounts and lengths.
    past = term.past(*(np.moveaxis(value, (-2, -1), (0, 1)) for value in (l, z)))
    past = np.where(np.asarray(term.scale) == 0.0, -1.0, past)
    return np.moveaxis(past, (0, 1), (-2, -1))


def _edge(term: Term) -> int:
    """Return the `Limit` of the pinion to which a relief extends."""
    assert term.relief is not None
    rises = bool(np.ravel(term.rate[term.relief])[0] > 0.0)
    if term.relief == 0:
        return Limit.PINION_TIP if rises else Limit.PINION_ROOT
    return Limit.PINION_HEEL if rises else Limit.PINION_TOE


def _between(ends: FloatArray, share: FloatArray) -> FloatArray:
    """Return values of linear functions at shares (..., lines, 2) of lines, given at both ends."""
    if ends.ndim > share.ndim:  # points: each component by itself
        return np.stack([_between(part, share) for part in np.moveaxis(ends, -1, 0)], axis=-1)
    first, last = ends[..., :1], ends[..., 1:]
    return np.asarray(first + share * (last - first))
