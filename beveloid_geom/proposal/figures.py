"""What is known of pairs that close, many at once: the figures by which one is chosen.

The measure is a chain's, as strong as its weakest link. Each of what `check` warns of has a reserve, 0 where
the warning begins and 1 where nothing is left to be said:

    contact ratio of either flank      1 ... 1.5
    tooth tip at its thinnest          0 ... 0.4 modules
    tip clearance                      0.05 ... 0.15 modules, about, where it is least
    margin of undercut                 0 ... 0.2, the least regularity of a flank over its greatest
    shift of the path on its flank     0.25 ... 0.1 of it, under 0.05 mm of offset, 0.01 deg of shaft angle
    flank left below the path          0 ... 0.05 modules, at its ends: a tip that goes deeper meets a fillet
    tips deeper at the thin end        0.03 ... 0 modules, where working cones are steeper than those cut

and the least of them, over both flanks and both members, is the reserve of the pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..analysis.sensitivity import path_sensitivity
from ..arrays import FLANK_SIGN, FloatArray, Mask, Quantity
from ..design.model import Design, Member, Pair
from ..findings.path import SENSITIVE, shares_of_flank, usual_sizes
from ..gear.fillet import root_radius
from ..gear.flank import root_parameter, tip_radius, tip_thickness, undercut_margin
from ..pair.closing import ClosedLayout
from ..pair.crossing import closed_normal
from .conditions import pair_at
from .request import Request

THIN_END = 0.03
"""Modules by which tips may be deeper at the thin end of the face."""
AMPLE_CLEARANCE = 0.1
"""Modules of tip clearance over which its reserve rises from 0 to 1, beginning at half of this, by which the
estimate may be too great."""
FLANKS = tuple(FLANK_SIGN)
AMPLE_RATIO, AMPLE_TIP, AMPLE_MARGIN, AMPLE_DEPTH = 0.5, 0.4, 0.2, 0.05
"""Where a reserve is 1: contact ratio above 1, modules, margin of undercut, modules."""


@dataclass(frozen=True, eq=False)
class Figures:
    """Figures of n pairs: `contact_ratio`, `crossing` (rad), `normal_x` and `share` (greatest shift of the
    path on its flank, over its size) of right and left flanks (2, n); least `clearance` of the tips of pinion
    and gear where they are deepest, mm, thinnest `tip`, mm, and `margin` of undercut (2, n); `reserve`
    (n,), and whether it is `possible` that nothing is warned of (n,), whatever the last link says."""

    contact_ratio: FloatArray
    crossing: FloatArray
    normal_x: FloatArray
    share: FloatArray
    clearance: FloatArray
    tip: FloatArray
    margin: FloatArray
    reserve: FloatArray
    possible: Mask

    def take(self, rows: list[int]) -> Figures:
        """Give those of some pairs."""
        return Figures(**{name: values[..., rows] for name, values in vars(self).items()})


def laid_out(
    request: Request, values: FloatArray, offset: Quantity | None, shaft_angle: Quantity
) -> tuple[Design, ClosedLayout]:
    """Give the pairs (7, n) of VARIABLES in the layouts in which they close; the shaft angle, and the offset
    if there is one, are those that are asked for."""
    design, layout = pair_at(request.members, values)
    offset = layout.offset if offset is None else np.broadcast_to(offset, layout.offset.shape)
    return Design(design.pinion, design.gear, Pair(offset, shaft_angle)), layout


def design_of(request: Request, values: FloatArray) -> Design:
    """Give one pair (7,) as a design."""
    numbers = [map(float, values[j:6:2]) for j in (0, 1)]
    members = [
        replace(member, cone_angle=cone, helix_angle=helix, profile_shift=shift)
        for member, (cone, helix, shift) in zip(request.members, numbers, strict=True)
    ]
    offset = request.offset
    if offset is None:
        offset = float(pair_at(request.members, values)[1].offset)
    return Design(members[0], members[1], Pair(offset, request.shaft_angle))


class Teeth(NamedTuple):
    """Of pinion and gear (2, n): least clearance of the tips where they are deepest, mm, thinnest `tip`, mm,
    and `margin` of undercut; the `reserve` that they leave (n,), -inf where one is not known."""

    clearance: FloatArray
    tip: FloatArray
    margin: FloatArray
    reserve: FloatArray

    def take(self, rows: Mask) -> Teeth:
        """Give those of some pairs."""
        return Teeth(*(values[..., rows] for values in self))


def teeth_of(request: Request, values: FloatArray) -> Teeth:
    """Find what is known of the teeth of pairs (7, n) without their paths."""
    design, layout = pair_at(request.members, values)
    module, members = float(request.members[0].tool.normal_module), design.members
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        tip = np.stack([_thinnest(member) for member in members])
        margin = np.stack([np.minimum(*(undercut_margin(m, flank) for flank in FLANKS)) for m in members])
    radius, cosine = layout.working_radius, np.cos(layout.cone_angle)
    height = np.stack([tip_radius(member, 0.0) for member in members]) - radius
    depth = radius - np.stack([root_radius(member, 0.0) for member in members])
    clearance = (depth * cosine)[::-1] - height * cosine - np.abs(_lean(request, values, layout))
    links = tip / (AMPLE_TIP * module), clearance / (AMPLE_CLEARANCE * module) - 0.5, margin / AMPLE_MARGIN
    return Teeth(clearance, tip, margin, _least(links))


def _lean(request: Request, values: FloatArray, layout: ClosedLayout) -> FloatArray:
    """Find by how much (n,), mm, tips stand nearer to bottom lands at the thick end of the face than in its
    middle, as reference cones are not the working ones; farther at the thin end. Negative the other way."""
    half = 0.5 * min(float(member.face_width) for member in request.members)
    steeper = (np.tan(values[:2]) - np.tan(layout.cone_angle)).sum(axis=0)
    return np.asarray(half * steeper * np.sign(values[:2].sum(axis=0)))


def figures_of(
    request: Request,
    values: FloatArray,
    teeth: Teeth,
    offset: Quantity | None,
    shaft_angle: Quantity,
) -> Figures:
    """Find the figures of pairs (7, n), whose `teeth` are known, on the members of a request, in its layout
    or in others: the offset (mm, None as it closes) and the shaft angle (rad)."""
    design, layout = laid_out(request, values, offset, shaft_angle)
    module, members = float(request.members[0].tool.normal_module), design.members
    sense = np.broadcast_to(design.sense, values.shape[1:])
    normals = [closed_normal(layout, flank, sense) for flank in FLANKS]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        found = [path_sensitivity(design, flank) for flank in FLANKS]
        shares = [
            np.nanmax(_filled(shares_of_flank(design, one, usual_sizes())), axis=(-3, -2, -1))
            for one in found
        ]
    lean = _lean(request, values, layout)
    ratio, share = np.stack([one.contact_ratio for one in found]), np.stack(shares)
    roots = np.stack([root_parameter(member) for member in members], axis=-1)
    left = np.stack([one.l[:, ::2] - roots[..., None, :] for one in found])
    (warned, _), (noted, _) = SENSITIVE
    links = (
        (ratio - 1.0) / AMPLE_RATIO,
        teeth.reserve[None],
        left.min(axis=(-2, -1)) / (AMPLE_DEPTH * module),
        np.where(layout.shaft_angle > 0.0, (warned - share) / (warned - noted), 1.0),  # no shift along lines
    )
    thin_end = 1.0 - np.maximum(-lean, 0.0) / (THIN_END * module)
    possible = _least(links) > 0.0
    reserve = np.minimum(_least(links), thin_end)
    normal_x, crossing = (np.stack([one[k] for one in normals]) for k in (0, 1))
    return Figures(ratio, crossing, normal_x, share, *teeth[:3], reserve, possible)


def _least(links: Sequence[FloatArray]) -> FloatArray:
    """Find the least (n,) of links (..., n), -inf where one is not known."""
    return np.asarray(np.min([np.where(np.isnan(link), -np.inf, link).min(axis=0) for link in links], axis=0))


def _thinnest(member: Member) -> FloatArray:
    """Find the thickness (n,), mm, of the tooth tip where it is least, at toe or heel."""
    return np.minimum(*(tip_thickness(member, end * np.asarray(member.face_width)) for end in (-0.5, 0.5)))


def _filled(shares: FloatArray) -> FloatArray:
    """Give shares with infinity in place of a path of which none is known."""
    lost = np.isnan(shares).all(axis=(-3, -2, -1), keepdims=True)
    return np.where(lost, np.inf, shares)
