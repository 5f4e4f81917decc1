"""Undercut and pointed teeth: whether, where along the face, and how much.

A flank is undercut where its regularity is not positive somewhere between the joint with the
tool's round and the tip. It folds back there, and the fillet, instead of running on into the
flank, passes through it: what is left of the flank starts where the two cross. Without parabola
and cone this is the condition every handbook has, N < 2 (h - x) / sin^2(alpha) for a spur gear,
with the height h of the joint below the tool's reference line (in modules).

The worst place is where the profile shift is least: for a positive cone angle the toe. The
paper does not treat undercut.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Mask, flank_sign
from ..design.limits import member_faults
from ..design.model import Member
from .fillet import fillet_point, tool_round
from .flank import (
    flank_patch,
    flank_point,
    highest_parameter,
    root_parameter,
    tip_parameter,
    tip_thickness,
    trace_parameter,
)

CURE = "take more teeth, more profile shift or a less deep tool"
STATIONS = 33
"""Planes along the face in which a flank is looked at."""
ROWS = 33
"""Points along the profile at which its regularity is taken."""
FINE = 1500
"""Points of the curves whose crossing is sought; it is found to better than a thousandth of a mm."""


@dataclass(frozen=True, eq=False)
class Undercut:
    """Undercut of one flank in the planes `z` (n,), mm from mid-face, toe first.

    `joint` is the flank parameter l (mm) where the tool's round begins; `start` (n,) the one
    where the flank really starts: `joint` where it is sound, NaN where no flank is left.
    `neck` (n,), mm, is how far the fillet reaches into the tooth behind the radial line through
    the flank's start: thickness lost on this side. `limits`: the ends (mm) of the undercut part
    of the face, NaN without undercut."""

    z: FloatArray
    joint: float
    start: FloatArray
    neck: FloatArray
    limits: tuple[float, float]

    @property
    def undercut(self) -> bool:
        """Whether any part of the face is undercut."""
        return not np.isnan(self.limits[0])

    @property
    def lost(self) -> FloatArray:
        """Flank lost above the joint (n,), mm of l; infinite where no flank is left."""
        return np.where(np.isnan(self.start), np.inf, self.start - self.joint)

    @property
    def worst(self) -> int:
        """Index of the plane that loses most."""
        return int(np.argmax(self.lost))


def cut_fault(member: Member) -> str | None:
    """Say why the tool cannot cut the active flanks of a single member, in a line; None if it can."""
    if not np.isnan(root_parameter(member)):
        return None
    return next(map(str, member_faults("", member)), "a quantity is not a number")


def require_cut(member: Member) -> None:
    """Raise ValueError for a single member whose active flanks the tool cannot cut."""
    if fault := cut_fault(member):
        raise ValueError(f"the flanks cannot be cut: {fault}")


def undercut_of(member: Member, flank: str, stations: int = STATIONS) -> Undercut:
    """Find the undercut of a flank of a single member. Raises ValueError where the tool cannot cut the flank
    or has no sound round."""
    require_cut(member)
    joint = tool_round(member.tool, flank).joint
    z = np.linspace(-0.5, 0.5, stations) * float(member.face_width)
    start, neck = np.full(stations, joint), np.zeros(stations)
    folded = _folded(member, flank, joint, z)
    for i in np.flatnonzero(folded):
        start[i], neck[i] = _crossing(member, flank, joint, float(z[i]))
    limits = _ends(z, folded, lambda z: _folded(member, flank, joint, z))
    return Undercut(z, joint, start, neck, limits)


def regular_start(member: Member, flank: str, z: FloatArray) -> FloatArray:
    """Find the flank parameter l (n,), mm, from which the surface of a single member's flank is regular up to
    its tip in the planes `z` (n,), mm: its root, or where the tool stops folding it, found by bisection.

    The tool's round need not fit; with one, the fillet may cross the flank above (`undercut_of`)."""
    root, tip = root_parameter(member), tip_parameter(member, flank, z)

    def regular(share: FloatArray) -> Mask:
        return _regularity(member, flank, root + share * (tip - root), z) > 0.0

    samples = np.linspace(0.0, 0.8, 81)[:, None] + np.zeros(z.shape)
    folded = np.where(regular(samples), 0, np.arange(1, 82)[:, None]).max(axis=0)
    low, high = np.maximum(folded - 1, 0) * 0.01, folded * 0.01
    for _ in range(40):
        middle = 0.5 * (low + high)
        good = regular(middle)
        low, high = np.where(good, low, middle), np.where(good, middle, high)
    return np.asarray(root + high * (tip - root))


def require_sound(member: Member) -> None:
    """Raise ValueError for a single member whose flanks are undercut or cannot be cut."""
    for flank in ("right", "left"):
        found = undercut_of(member, flank, 9)
        if found.undercut:
            raise ValueError(f"the {flank} flank is undercut {words_of(found)}: {CURE}")


def words_of(undercut: Undercut) -> str:
    """Say where and how much, for a message."""
    worst, (first, last) = undercut.worst, undercut.limits
    where = f"from z = {first:.4g} to {last:.4g} mm"
    if first == undercut.z[0] and last == undercut.z[-1]:
        where = "along the whole face"
    if np.isinf(undercut.lost[worst]):
        return f"{where}, at {undercut.z[worst]:.4g} mm nothing of it is left"
    lost, neck = undercut.lost[worst], undercut.neck.max()
    thickness = f" and {neck:.3g} mm of thickness" if neck > 0.0005 else ""
    return f"{where}, it loses up to {lost:.3g} mm of its height{thickness}"


def pointed_part(member: Member) -> tuple[float, float]:
    """Find ends (z, mm) of the part of the face of a single member on which its flanks cross below the
    tip cone; NaN where there is none."""
    z = np.linspace(-0.5, 0.5, STATIONS) * float(member.face_width)

    def pointed(z: FloatArray) -> Mask:
        return np.asarray(tip_thickness(member, z) <= 0.0)

    return _ends(z, pointed(z), pointed)


def _profile(member: Member, flank: str, joint: float, z: FloatArray, rows: int) -> FloatArray:
    """Find the flank parameters (rows, n) from the joint to the tip cone, or as far as a tip can be."""
    tip = tip_parameter(member, flank, z)
    tip = np.where(np.isnan(tip), highest_parameter(member), tip)
    return joint + np.linspace(0.0, 1.0, rows)[:, None] * (tip - joint)


def _regularity(member: Member, flank: str, l: FloatArray, z: FloatArray) -> FloatArray:
    return flank_patch(member, flank, l, trace_parameter(member, flank, l, z)).regularity


def _folded(member: Member, flank: str, joint: float, z: FloatArray) -> Mask:
    """Tell in which of the planes (n,) the flank folds back."""
    l = _profile(member, flank, joint, z, ROWS)
    return np.asarray(_regularity(member, flank, l, z).min(axis=0) <= 0.0)


def _ends(z: FloatArray, found: Mask, test: Callable[[FloatArray], Mask]) -> tuple[float, float]:
    """Find the least and greatest z at which `test` holds, from the samples `found` (n,), to 1e-6 of their
    step."""
    if not found.any():
        return np.nan, np.nan
    ends = []
    for inside, step in ((int(np.argmax(found)), -1), (len(z) - 1 - int(np.argmax(found[::-1])), 1)):
        good, bad = z[inside], z[min(max(inside + step, 0), len(z) - 1)]
        for _ in range(20 if good != bad else 0):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if test(np.array([middle]))[0] else (good, middle)
        ends.append(float(good))
    return ends[0], ends[1]


def _crossing(member: Member, flank: str, joint: float, z: float) -> tuple[float, float]:
    """Find where a folded flank starts in the plane `z` (l, mm) and how far the fillet reaches in behind
    it (mm); NaN where no flank is left.

    Below the start the tool leaves the curve that runs from the bottom land up the fillet and on
    along the part of the flank that is folded back, as far as it lies within the tooth."""
    at, sigma, steps = np.array([z]), flank_sign(flank), np.linspace(0.0, 1.0, FINE) ** 2
    l = _profile(member, flank, joint, at, FINE)[:, 0]
    tip = l[-1]
    for _ in range(2):  # the fold, to a millionth of the flank
        last = int(np.flatnonzero(_regularity(member, flank, l, at) <= 0.0)[-1])
        l = np.linspace(l[last], l[min(last + 1, FINE - 1)], FINE)
    edge, kept_l = l[0], l[0] + (tip - l[0]) * steps
    folded_l = edge - (edge - joint) * steps[::-1]
    angle = tool_round(member.tool, flank).angle
    fillet, _ = fillet_point(member, flank, angle + (0.5 * np.pi - angle) * steps[::-1] ** 2, z)
    kept, folded = (
        flank_point(member, flank, l, trace_parameter(member, flank, l, at)) for l in (kept_l, folded_l)
    )
    middle = np.arctan2(kept[0, 1], kept[0, 0])
    kept_r, kept_angle = _polar(kept, sigma, middle)
    low_r, low_angle = _polar(np.concatenate((fillet, folded)), sigma, middle)
    outside = low_angle - np.interp(low_r, kept_r, kept_angle)
    beside = low_r >= kept_r[0]
    within = beside & (outside < 0.0)
    if not within.any():
        return float(edge), 0.0
    first = int(np.argmax(within))
    leaves = first + int(np.argmax(beside[first:] & (outside[first:] >= 0.0)))
    if leaves == first or low_r[first:leaves].max() >= kept_r[-1]:
        return np.nan, np.nan
    share = outside[leaves - 1] / (outside[leaves - 1] - outside[leaves])
    radius = low_r[leaves - 1] + share * (low_r[leaves] - low_r[leaves - 1])
    start_angle = np.interp(radius, kept_r, kept_angle)
    neck = (start_angle - low_angle[:leaves]) * low_r[:leaves]
    return float(np.interp(radius, kept_r, kept_l)), max(float(neck.max()), 0.0)


def _polar(points: FloatArray, sigma: float, middle: float) -> tuple[FloatArray, FloatArray]:
    """Find radius (mm) and angle (rad) about the axis away from the metal, from `middle` (rad) and within
    half a turn of it, of points (n, 3)."""
    x, y = points[:, 0], points[:, 1]
    sin, cos = np.sin(middle), np.cos(middle)
    return np.hypot(x, y), sigma * np.arctan2(y * cos - x * sin, x * cos + y * sin)
