"""Limits of the active flank, and the tip cone.

The paper gives no limits. Here the tip cone is `addendum + tip_alteration` modules above the shifted pitch
cone, measured radially. The active profile starts at the fillet, where the tip round of the tool meets its
flank; on an undercut member it starts where flank and fillet intersect (`crossing`). Toe and heel are the
planes half a face width from mid-face.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, Mask
from ..design.member import Member
from .generation import flank_cut
from .rack import Rack, parameter_at_height, rack_at, rack_of, reference_radius


def tip_radius(member: Member, z: ArrayLike) -> FloatArray:
    """Return the radius of the tip cone in the plane `z` (mm from mid-face), mm.

    It is not the radius of the tip round of the tool, `Tool.tip_radius`.
    """
    tool = member.tool
    height = (member.profile_shift + member.tip_height) * tool.normal_module
    return np.asarray(reference_radius(member) + height + np.asarray(z) * np.tan(member.cone_angle))


def root_parameter(member: Member, flank: str) -> FloatArray:
    """Return the flank parameter `l` (mm) at which the active profile of a flank starts.

    NaN if the tool cannot cut the active flank (see `active_range`).
    """
    return active_range(member, flank)[0]


def highest_parameter(member: Member, flank: str) -> FloatArray:
    """Return an upper bound of `l` (mm) on an active flank.

    In the tilted rack, no point of the tip cone is higher than cos(gamma) times its height. NaN as in
    `root_parameter`.
    """
    return active_range(member, flank)[1]


def active_range(member: Member, flank: str) -> tuple[FloatArray, FloatArray]:
    """Return the lowest flank parameter of an active flank and an upper bound of the highest one.

    Both are NaN if the tool cannot cut the flank between them: if the profile of the rack folds, or if the
    normal of the rack, out of the tooth, has no positive radial component on this flank or on its mirror
    image. Eq. 6 gives a surface beyond such a place, but the tool does not produce it.

    Parameters
    ----------
    member : Member
        A single member or a batch.
    flank : {'right', 'left'}

    Returns
    -------
    lowest, bound : ndarray
        `l`, mm, batch shape.
    """
    tool = member.tool
    joint = tool.dedendum - tool.tip_radius * (1.0 - np.sin(tool.normal_pressure_angle))
    # The usual tip radius 0.38 is the rounded value of 0.37995, so that the round meets the flank 0.00003
    # modules above the depth of one addendum. If the distance is small, the active profile starts there.
    round_snap_modules = 1e-4
    start = np.where(np.abs(joint - tool.addendum) < round_snap_modules, tool.addendum, joint)
    with np.errstate(invalid="ignore", over="ignore"):
        low = parameter_at_height(tool, flank, -start * tool.normal_module)
        tip = member.tip_height * tool.normal_module * np.cos(member.cone_angle)
        high = parameter_at_height(tool, flank, tip)
        # The condition is linear in l, so that both ends decide.
        cut = _leans_outwards(member, flank, low) & _leans_outwards(member, flank, high)
    return np.where(cut, low, np.nan), np.where(cut, high, np.nan)


def _leans_outwards(member: Member, flank: str, l: FloatArray) -> Mask:
    """Return whether the normals of the rack lean out of the tooth at `l` of a flank and of its mirror image,
    before the fold.

    The condition is tan(alpha - tau) > sin|beta| tan|gamma| with tan(tau) = 2 a l.
    """
    tool, bend = member.tool, 2.0 * member.tool.parabola_of(flank) * l
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    across = np.abs(np.sin(member.helix_angle) * np.tan(member.cone_angle))
    return np.asarray(sin - bend * cos > (cos + bend * sin) * across)


def tip_parameter(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Return the flank parameter `l` (mm) at which the flank reaches the tip cone in the plane `z`.

    Newton's method from above, with the exact slope of the radius along the line of constant z, is kept
    by bisection between the start of the active profile and its highest point. NaN if the flank does not
    reach the tip cone. The solution is unique unless the flank is undercut.
    """
    z = np.asarray(z, dtype=float)
    rack, target = rack_of(member, flank), tip_radius(member, z)
    low, high = (end + 0.0 * z for end in active_range(member, flank))
    l = high
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(60):
            cut = flank_cut(rack, l, rack_at(rack, l), z)
            radius = np.sqrt(cut.square)
            # Newton step of the radius; bisect if it leaves the bracket.
            missing = target - radius
            low, high = np.where(missing > 0.0, l, low), np.where(missing > 0.0, high, l)
            moved = l + 2.0 * missing * radius / cut.square_s
            moved = np.where((moved >= low) & (moved <= high), moved, 0.5 * (low + high))
            step, l = np.abs(moved - l), moved
            if not np.any(step > 1e-13 * target):
                break
    return np.where((step <= 1e-9 * target) & (np.abs(missing) <= 1e-9 * target), l, np.nan)


def may_fold(member: Member, rack: Rack, low: FloatArray, high: FloatArray) -> Mask:
    """Return whether flanks may fold back at toe or heel. If False, they certainly do not.

    For each l the regularity is linear in z, so that toe and heel suffice. Samples begin slightly below the
    start of the active profile, because a parabola moves the joint with the fillet.

    Parameters
    ----------
    member : Member
        A single member, or members stacked as in `stacked`.
    rack : Rack
        The rack of the flanks.
    low, high : ndarray
        Ends of the active profile, mm of l (`active_range`).

    Returns
    -------
    ndarray of bool
        Shape of the member without its last axis.
    """
    # Modules below the start of the active profile, and number of samples along a parabolic profile, in the
    # check for folds.
    below_joint_modules, fold_samples = 0.02, 25
    low = low - below_joint_modules * np.asarray(member.tool.normal_module)
    z = np.multiply.outer((-0.5, 0.5), member.face_width * np.ones(1))
    if not np.any(rack.parabola):  # the regularity rises with l, so that the joint decides
        return np.asarray(~(_radial_slope(rack, low, z) > 0.0).all(axis=(0, -1)))
    # The slope is smooth in l. It has no zero if it exceeds its second differences at five points.
    slope = _radial_slope(rack, low + (high - low) * np.linspace(0.0, 1.0, 5), z)
    bend = np.abs(np.diff(slope, 2, axis=-1)).max(axis=-1, keepdims=True)
    folds = np.asarray(~(slope > bend).all(axis=(0, -1)))
    if folds.any():
        at = (slice(None), np.flatnonzero(folds.any(axis=0))) if folds.ndim else ()
        l = low[at] + (high - low)[at] * np.linspace(0.0, 1.0, fold_samples)
        folds[at] = ~(_radial_slope(rack.pick(at), l, z[(slice(None), *at)]) > 0.0).all(axis=(0, -1))
    return folds


def _radial_slope(rack: Rack, l: FloatArray, z: FloatArray) -> FloatArray:
    """Return half of d(r^2)/dl at flank parameters `l` in the planes `z`, both mm; its sign is that of the
    regularity of the flank."""
    return 0.5 * flank_cut(rack, l, rack_at(rack, l), z).square_s
