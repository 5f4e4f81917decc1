"""Helix and profile crowning for a given transmission error and a given length of the contact pattern.

The unknowns are the two crownings of one member. The helix crowning determines the length of the pattern, the
profile crowning the transmission error, which is the error at the hand-over to the next tooth pair. Both are
computed by the mesh cycle and by the pattern of the modified pair. The starting values are

    C_beta  = s (b / L)^2 / cos(beta_b)     depth s / cos(beta_b) at half the length L from mid-face
    C_alpha = e r_b eps^2                   depth C_alpha / eps^2 = e r_b, half a pitch from the middle

with the thickness s of the marking compound, the face width b, the transmission error e of the gear, its base
radius r_b and the contact ratio eps. 1 / L^2 is nearly proportional to the helix crowning and e to the
profile crowning, so that a few steps of Powell's hybrid method are sufficient.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray, flank_sign
from ...contact.ellipse import MARKING_SEPARATION_MM
from ...contact.path import path_of_contact
from ...design.arguments import require_numbers, require_single
from ...design.field_limits import DesignError
from ...design.model import Design
from ...gear.flank import base_cylinder
from ...operation.contact_pattern.motion import UnknownOperationError
from ...operation.contact_pattern.pattern import MemberPattern, contact_pattern
from ...operation.mesh_cycle import mesh_cycle
from ...support.argument import ArgumentError
from ...support.array_repr import short_repr
from .amounts import with_amounts


@dataclass(frozen=True, eq=False)
class Crowning:
    """Crownings of one flank of a member, the design with them, and its contact.

    Attributes
    ----------
    member, flank : str
        Modified flank.
    helix_crowning_um, profile_crowning_um : float
    design : Design
    transmission_error : float
        Peak-to-peak transmission error of all teeth, rad.
    length : float
        Extent of the contact pattern along the face of the member, mm.
    separation : float
        Thickness of the marking compound, mm.
    edge_share : float
        Share of the mesh cycle in which edges touch.
    """

    member: str
    flank: str
    helix_crowning_um: float
    profile_crowning_um: float
    design: Design
    transmission_error: float
    length: float
    separation: float
    edge_share: float

    __repr__ = short_repr


def fit_crowning(
    design: Design,
    transmission_error: float,
    length: float,
    flank: str = "right",
    *,
    member: str = "pinion",
    separation: float = MARKING_SEPARATION_MM,
) -> Crowning:
    """Compute the helix and profile crowning that give a transmission error and a length of the pattern.

    Parameters
    ----------
    design : Design
        A single design. Its other amounts of modification are kept; its crownings of this flank are replaced.
    transmission_error : float
        Peak-to-peak transmission error of all teeth, rad.
    length : float
        Extent of the contact pattern along the face of the modified member, mm.
    flank : {'right', 'left'}
        Driving flank.
    member : {'pinion', 'gear'}
        Member that is modified.
    separation : float
        Thickness of the marking compound, mm.

    Returns
    -------
    Crowning

    Raises
    ------
    ValueError
        For a batch, values that are not positive, a length that exceeds the face; or if no crownings that
        remove material give both values.

    References
    ----------
    Modifications: ISO 21771; method: beveloid_geom/analysis/README.md, Amounts of modification.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> crowned = bg.fit_crowning(bg.builtin_design("ni-2017"), 1e-5, 25.0)
    >>> round(crowned.helix_crowning_um), round(crowned.profile_crowning_um, 1)
    (27, 3.5)
    """
    require_single(design)
    flank_sign(flank)
    _check(design, transmission_error, length, member, separation)
    from scipy.optimize import root

    start = _starting_amounts(design, transmission_error, length, flank, member, separation)
    trial = _Trial(design, flank, member, separation, start)

    def residuals(x: FloatArray) -> FloatArray:
        error, trial_length, _ = trial.reached(np.maximum(x, 0.0))
        missed = np.array((error / transmission_error - 1.0, (length / max(trial_length, 1e-3)) ** 2 - 1.0))
        return missed[::-1] + np.minimum(x, 0.0)  # crownings below 0 are continued linearly

    # Largest number of mesh cycles and patterns; 8 to 11 are usual.
    max_evaluations = 25
    try:
        # Powell's hybrid method: one Jacobian by differences of 1 %, then updates by Broyden's formula.
        limits: Any = {"eps": 1e-4, "maxfev": max_evaluations}
        x = np.maximum(root(residuals, np.ones(2), tol=1e-3, options=limits).x, 0.0)
        error, reached_length, edges = trial.reached(x)
    except UnknownOperationError as unknown:
        raise ValueError(f"the contact could not be computed for some crownings: {unknown}") from None
    except DesignError:
        reason = "the length is too small, or the separation or transmission error is too large"
        raise ValueError(f"no crownings within their limits give both values: {reason}") from None
    # Largest relative difference of length and transmission error from their given values.
    residual = 1e-3
    if max(abs(error / transmission_error - 1.0), abs(reached_length / length - 1.0)) > residual:
        helix, profile = start * x
        wanted, nearest = (f"{np.degrees(3600.0 * x):.4g} arcsec" for x in (transmission_error, error))
        crownings = f"{helix:.3g} um of helix and {profile:.3g} um of profile crowning"
        raise ValueError(
            f"no crownings give a transmission error of {wanted} and a pattern length of {length:g} mm:"
            f" the nearest result is {nearest} and {reached_length:.4g} mm with {crownings}; change one of"
            " both values"
        )
    helix, profile = (start * x).tolist()
    return Crowning(member, flank, helix, profile, trial.crowned(x), error, reached_length, separation, edges)


def _starting_amounts(
    design: Design, transmission_error: float, length: float, flank: str, member: str, separation: float
) -> FloatArray:
    """Return helix and profile crowning (2), um, that give both values for a path along the profile."""
    one, path = getattr(design, member), path_of_contact(design, flank, 3)
    ratio = max(1.0, float(np.nan_to_num(path.ends.contact_ratio)))
    helix = separation / np.cos(float(base_cylinder(one, flank).helix_angle))
    profile = transmission_error * float(base_cylinder(design.gear, flank).radius)
    return 1e3 * np.array((helix * (float(one.face_width) / length) ** 2, profile * ratio**2))


@dataclass(frozen=True, eq=False)
class _Trial:
    """Design with crownings x (2) of a member, relative to the starting values `start` (2), um."""

    design: Design
    flank: str
    member: str
    separation: float
    start: FloatArray

    def crowned(self, x: FloatArray) -> Design:
        """Return the design with these crownings."""
        names = f"{self.member}.helix_crowning_um", f"{self.member}.profile_crowning_um"
        return with_amounts(self.design, self.flank, dict(zip(names, (self.start * x).tolist(), strict=True)))

    def reached(self, x: FloatArray) -> tuple[float, float, float]:
        """Return transmission error, rad, length, mm, and share on edges."""
        changed = self.crowned(x)
        cycle = mesh_cycle(changed, self.flank, 1)
        # Distance of the grid points of a pattern, mm: 80 steps along the face.
        resolution = float(getattr(self.design, self.member).face_width) / 80
        pattern = contact_pattern(changed, self.flank, self.separation, resolution=resolution)
        reached_length = pattern_length(getattr(pattern, self.member), self.separation)
        return float(cycle.peak_to_peak), reached_length, float(cycle.edge_share)


def pattern_length(side: MemberPattern, separation: float) -> float:
    """Return the extent of a pattern along the face, mm, with its border interpolated between grid points."""
    z, least = side.z, np.where(np.isfinite(side.least), side.least, np.inf)
    ends = []
    for rows, places in ((least, z), (least[:, ::-1], z[:, ::-1])):
        inside = rows <= separation
        first = inside.argmax(axis=1)
        row = np.flatnonzero(inside.any(axis=1))
        if not row.size:
            return 0.0
        k, before = first[row], np.maximum(first[row] - 1, 0)
        low, high = rows[row, k], rows[row, before]
        # At the end of the face, and next to points without a mate, the border is the grid point.
        crosses = np.isfinite(high) & (high > separation)
        rise = np.where(crosses, high - low, 1.0)
        share = np.where(crosses, (separation - low) / rise, 0.0)
        ends.append(places[row, k] + share * (places[row, before] - places[row, k]))
    return float(ends[1].max() - ends[0].min())


def _check(design: Design, transmission_error: float, length: float, member: str, separation: float) -> None:
    """Raise ValueError for values outside their limits."""
    if member not in ("pinion", "gear"):
        raise ValueError(f"member must be pinion or gear, got {member!r}")
    given = {"transmission_error": transmission_error, "length": length, "separation": separation}
    require_numbers(**given)
    for name, value in given.items():
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} must be positive and finite, got {value}")
    face = float(getattr(design, member).face_width)
    if length >= face:
        text = f"must be below the face width of the {member}, {face:g} mm, got {length:g}"
        raise ArgumentError("length", f"{text}: reduce it")
