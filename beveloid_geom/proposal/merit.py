"""Criteria by which pairs are compared, for many pairs at once.

Each criterion has a reserve: 0 at the limit of a warning of `check`, 1 at a sufficient value.

    contact ratio of each flank        1 ... 1.5
    smallest tip thickness             0.1 ... 0.4 modules
    tip clearance (estimate)           0.05 ... 0.15 modules
    undercut margin                    0 ... 0.2, smallest regularity of a flank over the largest one; the
                                       regularity is 0 on the edge of regression (`gear.flank`)
    shift of the path on its flank     0.25 ... 0.1, relative, for 0.05 mm of offset and 0.01 deg of
                                       shaft angle
    flank that remains below the tips  0 ... 0.1 modules (`pair.tips`)

The reserve of a pair is the smallest reserve over all criteria, both flanks and both members. Tips that reach
below the flank of the mate away from the path of contact give a negative reserve; a certificate then shows
whether they touch anything. On parallel axes the flanks are in contact there, and such a pair is not
proposed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..analysis.sensitivity import path_sensitivity
from ..arrays import FLANKS, FloatArray, Mask
from ..contact.path import path_of_contact
from ..design.member import Member
from ..design.model import Design, Pair
from ..findings.diagnostics import LEAST_TIP_THICKNESS_MODULES
from ..findings.path import SENSITIVE, shares_of_flank, usual_sizes
from ..gear.fillet import root_radius
from ..gear.flank import tip_thickness
from ..gear.flank_limits import tip_radius
from ..gear.undercut import undercut_margin
from ..pair.frames import layout_at
from ..pair.generator_angle import closed_normal
from ..pair.tips import CLEAR_DEPTH_MODULES, depth_below_tips
from ..pair.zero_backlash import ZeroBacklashLayout
from .closure_equations import pair_at
from .request import Request

CRITERIA = ("tip thickness", "tip clearance", "undercut", "depth of tips", "contact ratio", "shift by errors")
"""Criteria of the reserve. The last two need the paths of contact."""
DEPTH = CRITERIA.index("depth of tips")


@dataclass(frozen=True, eq=False)
class PairCriteria:
    """Values of the criteria of n pairs.

    Attributes
    ----------
    contact_ratio : ndarray
        Of right and left flanks (2, n); NaN before paths are computed.
    crossing, normal_x : ndarray
        Angle between the generators, rad, and n_x, of right and left flanks (2, n).
    margin : ndarray
        Undercut margin of pinion and gear (2, n).
    depth : ndarray
        Smallest depth of active flank that remains below the tips of the mate (n,), mm; negative if the tips
        reach below the active flank.
    reserves : ndarray
        Reserve of each criterion (CRITERIA, n), at most 1. It is -inf if it is unknown. The reserves of the
        last two criteria are 1 before paths are computed.
    possible : ndarray
        False for pairs (n,) whose criteria indicate a warning of `check`. In point contact, tips that reach
        below the flank of the mate do not make it False, because they may still miss the fillet.
    """

    contact_ratio: FloatArray
    crossing: FloatArray
    normal_x: FloatArray
    margin: FloatArray
    depth: FloatArray
    reserves: FloatArray
    possible: Mask

    @property
    def reserve(self) -> FloatArray:
        """Least reserve (n,) of all criteria."""
        return np.asarray(self.reserves.min(axis=0))

    @property
    def weakest(self) -> NDArray[np.intp]:
        """Index (n,) in CRITERIA of the criterion with the least reserve."""
        return np.asarray(self.reserves.argmin(axis=0))

    def take(self, rows: list[int] | NDArray[np.intp]) -> PairCriteria:
        """Return the criteria of some pairs."""
        return PairCriteria(**{name: values[..., rows] for name, values in vars(self).items()})


def design_of(request: Request, values: FloatArray) -> Design:
    """Return one pair (7,) as a design."""
    numbers = [map(float, values[j:6:2]) for j in (0, 1)]
    members = [
        replace(member, cone_angle=cone, helix_angle=helix, profile_shift=shift)
        for member, (cone, helix, shift) in zip(request.members, numbers, strict=True)
    ]
    offset = request.offset
    if offset is None:
        offset = float(pair_at(request.members, values)[1].offset)
    return Design(members[0], members[1], Pair(offset, request.shaft_angle))


def tooth_criteria(request: Request, values: FloatArray) -> PairCriteria:
    """Return the criteria of pairs (7, n) that do not need their paths of contact."""
    # Range of the tip clearance in which its reserve rises from 0 to 1: 0.05 to 0.15 modules. It does not
    # begin at 0, the limit of `check`, because the estimate may be too large by up to 0.05 modules.
    clearance_range_modules = 0.1
    design, layout = pair_at(request.members, values)
    module, members = float(request.members[0].tool.normal_module), design.members
    sense = np.broadcast_to(design.sense, values.shape[1:])
    normal_x, crossing = np.stack([closed_normal(layout, flank, sense) for flank in FLANKS], axis=1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        tip = np.stack([_thinnest(member) for member in members])
        margin = np.stack([np.minimum(*(undercut_margin(m, flank) for flank in FLANKS)) for m in members])
        axes = layout_at(layout.offset, design.sense * layout.shaft_angle, design.sense)
        left = np.stack(
            [
                depth_below_tips(design, axes, layout.mounting, *each)
                for each in zip(FLANKS, normal_x, strict=True)
            ]
        ).min(axis=(0, 1))
    radius, cosine = layout.working_radius, np.cos(layout.cone_angle)
    height = np.stack([tip_radius(member, 0.0) for member in members]) - radius
    depth = radius - np.stack([root_radius(member, 0.0) for member in members])
    clearance = (depth * cosine)[::-1] - height * cosine - np.abs(_taper_difference(request, values, layout))
    # Values with a reserve of 1.
    ample_tip_modules = 0.4
    ample_undercut_margin = 0.2
    ample_depth_modules = 0.1
    reserves = _reserves(
        (tip / module - LEAST_TIP_THICKNESS_MODULES) / (ample_tip_modules - LEAST_TIP_THICKNESS_MODULES),
        clearance / (clearance_range_modules * module) - 0.5,
        margin / ample_undercut_margin,
        left / (ample_depth_modules * module),
        np.ones_like(crossing),
        np.ones_like(crossing),
    )
    needed = np.zeros((len(CRITERIA), 1))
    # In point contact, tips that reach deeper than the flank may pass the fillet. On parallel axes they must
    # stay clear of it.
    needed[DEPTH] = CLEAR_DEPTH_MODULES / ample_depth_modules if request.shaft_angle == 0.0 else -np.inf
    possible = np.asarray((reserves > needed).all(axis=0))
    return PairCriteria(np.full_like(crossing, np.nan), crossing, normal_x, margin, left, reserves, possible)


def _taper_difference(request: Request, values: FloatArray, layout: ZeroBacklashLayout) -> FloatArray:
    """Return the decrease of the tip clearance from mid-face to the thick end of the face, mm (n,).

    The clearance is not constant because the reference cones differ from the working cones."""
    half = 0.5 * min(float(member.face_width) for member in request.members)
    steeper = (np.tan(values[:2]) - np.tan(layout.cone_angle)).sum(axis=0)
    return np.asarray(half * steeper * np.sign(values[:2].sum(axis=0)))


def criteria_of(request: Request, values: FloatArray, teeth: PairCriteria) -> PairCriteria:
    """Return all criteria of pairs (7, n) in their layout, from the criteria of the `teeth`."""
    design, layout = pair_at(request.members, values)
    offset = np.zeros_like(layout.offset) if request.offset == 0.0 else layout.offset
    design = replace(design, pair=Pair(offset, layout.shaft_angle))
    (warned, _), (noted, _) = SENSITIVE
    if request.shaft_angle > 0.0:
        results = [path_sensitivity(design, flank) for flank in FLANKS]
        ratio = np.stack([result.contact_ratio for result in results])
        with np.errstate(invalid="ignore"):
            share = np.stack([_greatest(shares_of_flank(design, each, usual_sizes())) for each in results])
    else:  # line contact has no shift
        ratio = np.stack([path_of_contact(design, flank, 2).ends.contact_ratio for flank in FLANKS])
        share = np.zeros_like(ratio)
    # Value with a reserve of 1.
    ample_ratio_above_1 = 0.5
    path = _reserves((ratio - 1.0) / ample_ratio_above_1, (warned - share) / (warned - noted))
    possible = teeth.possible & (path > 0.0).all(axis=0)
    reserves = np.concatenate((teeth.reserves[: -len(path)], path))
    return replace(teeth, contact_ratio=ratio, reserves=reserves, possible=possible)


def _reserves(*reserves: FloatArray) -> FloatArray:
    """Return the smallest reserve of each criterion (..., n) as (criteria, n), at most 1, and -inf if it is
    unknown."""
    known = [np.where(np.isnan(reserve), -np.inf, reserve) for reserve in reserves]
    least = np.stack([reserve.min(axis=tuple(range(reserve.ndim - 1))) for reserve in known])
    return np.asarray(np.minimum(least, 1.0))


def _thinnest(member: Member) -> FloatArray:
    """Return the least tip thickness (n,), mm, at both ends of the face."""
    return np.minimum(*(tip_thickness(member, end * np.asarray(member.face_width)) for end in (-0.5, 0.5)))


def _greatest(shares: FloatArray) -> FloatArray:
    """Return the largest (n,) of shares (n, place, member, error), infinity if none is known."""
    greatest = np.where(np.isnan(shares), -np.inf, shares).max(axis=(-3, -2, -1))
    return np.where(np.isinf(greatest), np.inf, greatest)
