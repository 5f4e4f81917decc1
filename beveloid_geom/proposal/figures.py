"""What is known of pairs that close, many at once: the figures by which one is chosen.

The measure is a chain's, as strong as its weakest link. Each of what `check` warns of has a reserve, 0 where
the warning begins and 1 where nothing is left to be said:

    contact ratio of either flank      1 ... 1.5
    tooth tip at its thinnest          0 ... 0.4 modules
    tip clearance                      0.05 ... 0.15 modules, about, where it is least
    margin of undercut                 0 ... 0.2, the least regularity of a flank over its greatest
    shift of the path on its flank     0.25 ... 0.1 of it, under 0.05 mm of offset, 0.01 deg of shaft angle
    flank left below the tips          0 ... 0.1 modules (`tips`)

and the least of them, over both flanks and both members, is the reserve of the pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..analysis.sensitivity import path_sensitivity
from ..arrays import FLANK_SIGN, FloatArray, Mask
from ..contact.path import path_of_contact
from ..design.model import Design, Member, Pair
from ..findings.path import SENSITIVE, shares_of_flank, usual_sizes
from ..gear.fillet import root_radius
from ..gear.flank import tip_radius, tip_thickness, undercut_margin
from ..pair.closing import ClosedLayout
from ..pair.crossing import closed_normal
from .conditions import pair_at
from .request import Request
from .tips import left_below_tips

AMPLE_CLEARANCE = 0.1
"""Modules of tip clearance over which its reserve rises from 0 to 1, beginning at half of this, by which the
estimate may be too great."""
FLANKS = tuple(FLANK_SIGN)
AMPLE_RATIO, AMPLE_TIP, AMPLE_MARGIN, AMPLE_DEPTH = 0.5, 0.4, 0.2, 0.1
"""Where a reserve is 1: contact ratio above 1, modules, margin of undercut, modules."""


@dataclass(frozen=True, eq=False)
class Figures:
    """Figures of n pairs: `contact_ratio` (NaN where paths are not looked at yet), `crossing` (rad) and
    `normal_x` of right and left flanks (2, n); `margin` of undercut of pinion and gear (2, n); `reserve`
    (n,), -inf where a link of it is not known, and whether it is `possible` that nothing is warned of (n,):
    tips that go deeper than the flank may still pass the fillet."""

    contact_ratio: FloatArray
    crossing: FloatArray
    normal_x: FloatArray
    margin: FloatArray
    reserve: FloatArray
    possible: Mask

    def take(self, rows: list[int] | NDArray[np.intp]) -> Figures:
        """Give those of some pairs."""
        return Figures(**{name: values[..., rows] for name, values in vars(self).items()})


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


def teeth_of(request: Request, values: FloatArray) -> Figures:
    """Find what figures of pairs (7, n) there are without their paths."""
    design, layout = pair_at(request.members, values)
    module, members = float(request.members[0].tool.normal_module), design.members
    sense = np.broadcast_to(design.sense, values.shape[1:])
    normal_x, crossing = np.stack([closed_normal(layout, flank, sense) for flank in FLANKS], axis=1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        tip = np.stack([_thinnest(member) for member in members])
        margin = np.stack([np.minimum(*(undercut_margin(m, flank) for flank in FLANKS)) for m in members])
        left = np.stack(
            [left_below_tips(design, layout, *each) for each in zip(FLANKS, normal_x, strict=True)]
        )
    radius, cosine = layout.working_radius, np.cos(layout.cone_angle)
    height = np.stack([tip_radius(member, 0.0) for member in members]) - radius
    depth = radius - np.stack([root_radius(member, 0.0) for member in members])
    clearance = (depth * cosine)[::-1] - height * cosine - np.abs(_lean(request, values, layout))
    links = tip / (AMPLE_TIP * module), clearance / (AMPLE_CLEARANCE * module) - 0.5, margin / AMPLE_MARGIN
    sound = _least(links)
    reserve = np.minimum(sound, _least([left.min(axis=0) / (AMPLE_DEPTH * module)]))
    return Figures(np.full_like(crossing, np.nan), crossing, normal_x, margin, reserve, sound > 0.0)


def _lean(request: Request, values: FloatArray, layout: ClosedLayout) -> FloatArray:
    """Find by how much (n,), mm, tips stand nearer to bottom lands at the thick end of the face than in its
    middle, as reference cones are not the working ones; farther at the thin end. Negative the other way."""
    half = 0.5 * min(float(member.face_width) for member in request.members)
    steeper = (np.tan(values[:2]) - np.tan(layout.cone_angle)).sum(axis=0)
    return np.asarray(half * steeper * np.sign(values[:2].sum(axis=0)))


def figures_of(request: Request, values: FloatArray, teeth: Figures) -> Figures:
    """Find the figures of pairs (7, n), of which those of the `teeth` are known, as they close."""
    design, layout = pair_at(request.members, values)
    offset = np.zeros_like(layout.offset) if request.offset == 0.0 else layout.offset
    design = replace(design, pair=Pair(offset, layout.shaft_angle))
    (warned, _), (noted, _) = SENSITIVE
    if request.shaft_angle > 0.0:
        found = [path_sensitivity(design, flank) for flank in FLANKS]
        ratio = np.stack([one.contact_ratio for one in found])
        with np.errstate(invalid="ignore"):
            share = np.stack([_greatest(shares_of_flank(design, one, usual_sizes())) for one in found])
    else:  # no shift along lines
        ratio = np.stack([path_of_contact(design, flank, 2).ends.contact_ratio for flank in FLANKS])
        share = np.zeros_like(ratio)
    path = _least(((ratio - 1.0) / AMPLE_RATIO, (warned - share) / (warned - noted)))
    reserve, possible = np.minimum(teeth.reserve, path), teeth.possible & (path > 0.0)
    return replace(teeth, contact_ratio=ratio, reserve=reserve, possible=possible)


def _least(links: Sequence[FloatArray]) -> FloatArray:
    """Find the least (n,) of links (..., n), at most 1, -inf where one is not known."""
    least = [np.where(np.isnan(link), -np.inf, link).min(axis=0) for link in links]
    return np.asarray(np.minimum(np.min(least, axis=0), 1.0))


def _thinnest(member: Member) -> FloatArray:
    """Find the thickness (n,), mm, of the tooth tip where it is least, at toe or heel."""
    return np.minimum(*(tip_thickness(member, end * np.asarray(member.face_width)) for end in (-0.5, 0.5)))


def _greatest(shares: FloatArray) -> FloatArray:
    """Find the greatest (n,) of shares (n, place, member, error), infinity where none is known."""
    greatest = np.where(np.isnan(shares), -np.inf, shares).max(axis=(-3, -2, -1))
    return np.where(np.isinf(greatest), np.inf, greatest)
