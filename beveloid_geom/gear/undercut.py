"""Undercut and pointed teeth: whether, where along the face, and how much.

A flank is undercut where its regularity (`flank.FlankPatch`: positive on a sound flank, negative where it
folds back) is not positive between the joint with the tool round and the tip. The fillet intersects the
generated flank above this part, and the remaining flank starts at the intersection. Without parabola and
cone the condition is the usual one: for a spur gear, N < 2 (h - x) / sin^2(alpha), with the height h of the
joint below the reference line of the tool in modules.

Undercut is greatest where the profile shift is least, for a positive cone angle at the toe. The paper
does not treat undercut.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray, Mask
from ..design.limits import member_faults
from ..design.member import Member
from .crossing import intersections
from .flank import flank_patch, tip_thickness
from .flank_limits import highest_parameter, root_parameter, tip_parameter, tip_radius
from .tooth_side import ToothSurface, angle_of, cut_at, surface_of

CURE = "use more teeth, more profile shift or a smaller dedendum"
FACE_PLANES = 33
"""Number of planes along the face in which a flank is checked."""


@dataclass(frozen=True, eq=False)
class Undercut:
    """Undercut of one flank in the planes `z` (n,), mm from mid-face, toe first.

    `joint` (mm) is the flank parameter l where the tool round begins. `start` (n,), mm, is the l where the
    remaining flank starts: `joint` in sound planes, NaN where no flank is left. `neck` (n,), mm, is the
    thickness lost on this side: how far the fillet reaches into the tooth behind the radial line through
    the start of the flank. `limits` (mm) are the ends of the undercut part of the face, NaN without
    undercut.
    """

    z: FloatArray
    joint: float
    start: FloatArray
    neck: FloatArray
    limits: tuple[float, float]

    @property
    def undercut(self) -> bool:
        """Whether a part of the face is undercut."""
        return not np.isnan(self.limits[0])

    @property
    def lost(self) -> FloatArray:
        """Length of flank lost above the joint (n,), mm of l; infinite where no flank is left."""
        return np.where(np.isnan(self.start), np.inf, self.start - self.joint)

    @property
    def worst(self) -> int:
        """Index of the plane with the largest loss."""
        return int(np.argmax(self.lost))


def cut_fault(member: Member) -> str | None:
    """Return the reason why the tool cannot cut the active flanks of a single member, None if it can."""
    if not any(np.isnan(root_parameter(member, flank)) for flank in FLANK_SIGN):
        return None
    return next(map(str, member_faults("", member)), "a value is not a number")


def require_cut(member: Member) -> None:
    """Raise ValueError for a single member whose active flanks the tool cannot cut."""
    if fault := cut_fault(member):
        raise ValueError(f"the flanks cannot be cut: {fault}")


def undercut_of(member: Member, flank: str, stations: int = FACE_PLANES) -> Undercut:
    """Return the undercut of a flank of a single member.

    Parameters
    ----------
    member : Member
    flank : {'right', 'left'}
    stations : int
        Number of planes along the face.

    Returns
    -------
    Undercut

    Raises
    ------
    ValueError
        If the tool cannot cut the flank or its tip rounds overlap.
    """
    require_cut(member)
    surface = surface_of(member, flank)
    z = np.linspace(-0.5, 0.5, stations) * float(member.face_width)
    start, neck = np.full(stations, surface.joint), np.zeros(stations)
    # Folded planes start where the flank intersects the fillet.
    folded = _folded(member, flank, surface.joint, z)
    if surface.crossing is not None:
        start[folded] = surface.flank_start(z[folded])
        neck[folded] = _neck(surface, z[folded], surface.fillet_end(z[folded]))
    elif folded.any():  # no flank is left in a part of the face, so that planes are solved one by one
        start[folded], end, _ = intersections(surface, z[folded])
        neck[folded] = np.nan_to_num(_neck(surface, z[folded], end))
    limits = _ends(z, folded, lambda z: _folded(member, flank, surface.joint, z))
    return Undercut(z, surface.joint, start, neck, limits)


def regular_start(member: Member, flank: str, z: FloatArray) -> FloatArray:
    """Return the flank parameter l (n,), mm, above which the flank of a single member is regular up to its
    tip.

    It is the root of the flank in the planes `z` (n,), mm, or where the flank ceases to fold back, found by
    bisection. The tool round is not used; with it, the fillet can cut the flank higher up (`undercut_of`).
    """
    root, tip = root_parameter(member, flank), tip_parameter(member, flank, z)

    def regular(share: FloatArray) -> Mask:
        return _regularity(member, flank, root + share * (tip - root), z) > 0.0

    # Bracket the end of the fold, then bisect.
    samples = np.linspace(0.0, 0.8, 81)[:, None] + np.zeros(z.shape)
    folded = np.where(regular(samples), 0, np.arange(1, 82)[:, None]).max(axis=0)
    low, high = np.maximum(folded - 1, 0) * 0.01, folded * 0.01
    for _ in range(40):
        middle = 0.5 * (low + high)
        good = regular(middle)
        low, high = np.where(good, low, middle), np.where(good, middle, high)
    return np.asarray(root + high * (tip - root))


def undercut_margin(member: Member, flank: str) -> FloatArray:
    """Return the least regularity on the rim of the active flank, relative to its largest one (batch shape).

    It is not positive if the active flank is undercut. On flanks that are sound inside, the regularity is
    least on the rim.
    """
    half = 0.5 * np.asarray(member.face_width, dtype=float)
    half, low, _ = np.broadcast_arrays(half, root_parameter(member, flank), tip_radius(member, 0.0))
    z = np.multiply.outer(np.linspace(-1.0, 1.0, 9), half)
    high = tip_parameter(member, flank, z)
    l = np.stack((low + 0.0 * z, 0.5 * (low + high), high))
    regularity = _regularity(member, flank, l, z)
    return np.asarray(regularity.min(axis=(0, 1)) / np.abs(regularity).max(axis=(0, 1)))


def require_flanks(member: Member) -> None:
    """Raise ValueError for a single member whose flanks cannot be cut, or have a part of the face on which
    undercut leaves no flank.
    """
    require_cut(member)
    for flank in ("right", "left"):
        if surface_of(member, flank).lost:
            raise ValueError(
                f"the {flank} flank is undercut {undercut_text(undercut_of(member, flank))}: {CURE}"
            )


def undercut_text(undercut: Undercut) -> str:
    """Return the place and amount of undercut as text for a message."""
    worst, where = undercut.worst, part_text(undercut.limits, float(undercut.z[-1]))
    if np.isinf(undercut.lost[worst]):
        return f"{where}, and removed completely at z = {undercut.z[worst]:.4g} mm"
    lost, neck = undercut.lost[worst], undercut.neck.max()
    thickness = f" and {neck:.3g} mm of thickness" if neck > 0.0005 else ""
    return f"{where}, it loses up to {lost:.3g} mm of its length along the profile{thickness}"


def part_text(ends: tuple[float, float], half: float) -> str:
    """Return the part of the face between two ends (z, mm) as text; `half`: half of the face width, mm."""
    return (
        "along the complete face" if ends == (-half, half) else "from z = {:.4g} to {:.4g} mm".format(*ends)
    )


def pointed_part(member: Member) -> tuple[float, float]:
    """Return the ends (z, mm) of the part of the face of a single member on which its flanks intersect below
    the tip cone; NaN if there is none.
    """
    z = np.linspace(-0.5, 0.5, FACE_PLANES) * float(member.face_width)

    def pointed(z: FloatArray) -> Mask:
        return np.asarray(tip_thickness(member, z) <= 0.0)

    return _ends(z, pointed(z), pointed)


def _profile(member: Member, flank: str, joint: float, z: FloatArray, rows: int) -> FloatArray:
    """Return the flank parameters (rows, n) from the joint to the tip cone, or to the bound of the tip."""
    tip = tip_parameter(member, flank, z)
    tip = np.where(np.isnan(tip), highest_parameter(member, flank), tip)
    return joint + np.linspace(0.0, 1.0, rows)[:, None] * (tip - joint)


def _regularity(member: Member, flank: str, l: FloatArray, z: FloatArray) -> FloatArray:
    return flank_patch(member, flank, l, z=z).regularity


def _folded(member: Member, flank: str, joint: float, z: FloatArray) -> Mask:
    """Return whether the flank folds back in each of the planes (n,)."""
    # Number of points along the profile at which the regularity is computed.
    profile_points = 33
    l = _profile(member, flank, joint, z, profile_points)
    return np.asarray(_regularity(member, flank, l, z).min(axis=0) <= 0.0)


def _ends(z: FloatArray, result: Mask, test: Callable[[FloatArray], Mask]) -> tuple[float, float]:
    """Return the least and greatest z at which `test` holds, from the samples `result` (n,), to 1e-6 of their
    distance.
    """
    if not result.any():
        return np.nan, np.nan
    ends = []
    # Bisect between the outermost sample at which the test holds and its outer neighbour.
    for inside, step in ((int(np.argmax(result)), -1), (len(z) - 1 - int(np.argmax(result[::-1])), 1)):
        good, bad = z[inside], z[min(max(inside + step, 0), len(z) - 1)]
        for _ in range(20 if good != bad else 0):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if test(np.array([middle]))[0] else (good, middle)
        ends.append(float(good))
    return ends[0], ends[1]


def _neck(surface: ToothSurface, z: FloatArray, end: FloatArray) -> FloatArray:
    """Return how far (mm) the fillet reaches into the tooth behind the radial line through its `end` (n,),
    mm, where the flank starts, in the planes `z` (n,).
    """
    # Number of points of a fillet at which its reach into the tooth is computed.
    fillet_points = 200
    # Largest distance of the fillet behind the radial line.
    fillet = cut_at(
        surface, surface.bottom + (end - surface.bottom) * np.linspace(0.0, 1.0, fillet_points)[:, None], z
    )
    behind = surface.sigma * (angle_of(cut_at(surface, end, z)) - angle_of(fillet)) * np.sqrt(fillet.square)
    return np.asarray(np.maximum(behind.max(axis=0), 0.0))
