"""The span measurement over k teeth of a cylindrical gear (base tangent length).

Two parallel planes touch the right flank of one tooth and the left flank of another, k - 1 teeth further.
Their common normal is tangent to the base cylinder at the base helix angle beta_b, so that the span is k - 1
normal base pitches and one normal base thickness,

    W_k = m_n cos(alpha_n) [(k - 1/2) pi + N inv(alpha_t)] + 2 x m_n sin(alpha_n) + A cos(alpha_n),

with A the change of the normal thickness. The planes touch at the diameter d_M,
d_M^2 = d_b^2 + (W_k cos(beta_b))^2, and the points of contact are W_k sin(beta_b) apart along the axis.
Source: DIN 21773, ISO 21771. If k is not given, it is the number, 2 or more, whose W_k is nearest to the span
with contact on the V-cylinder d_V = d + 2 x m_n, which is sqrt(d_V^2 - d_b^2) / cos(beta_b).

Beveloids have no span: the base helix angles of their right and left flanks differ, so that no two parallel
planes touch both. Flanks with a parabola or a modification are not involutes; no span is computed for them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FLANK_SIGN, Codes, FloatArray
from ..design.arguments import require_integers, require_member
from ..design.field_limits import float64_of
from ..design.member import Member
from ..gear.flank import base_cylinder
from ..gear.flank_limits import tip_radius
from ..gear.rack import reference_radius
from ..status import SpanStatus
from ..support.array_repr import short_repr
from .tooth_data import tooth_data


@dataclass(frozen=True, eq=False)
class Span:
    """Span measurement.

    Attributes
    ----------
    teeth : int
        Number of teeth in the span; 0 if a span is not defined.
    change : array (k,)
        Changes of the normal thickness, mm.
    dimension : array (k,)
        Span, mm; NaN unless MEASURED.
    contact_diameter : array (k,)
        Diameter on which the planes touch, mm; NaN if a span is not defined.
    status : array (k,)
        Codes of `SpanStatus`.
    """

    __repr__ = short_repr

    teeth: int
    change: FloatArray
    dimension: FloatArray
    contact_diameter: FloatArray
    status: Codes


def span_measurement(member: Member, teeth: int | None = None, change: ArrayLike = 0.0) -> Span:
    """Compute the span measurement of a single cylindrical member.

    Parameters
    ----------
    member : Member
    teeth : int, optional
        Number of teeth in the span. By default, the number, 2 or more, whose span is nearest to that with
        contact on the V-cylinder.
    change : float or array (k,)
        Change of the normal thickness, mm; negative for a thinner tooth.

    Returns
    -------
    Span

    Raises
    ------
    ValueError
        For a number of teeth below 1 or above that of the gear minus 1, and as `tooth_data`.

    References
    ----------
    DIN 21773 and ISO 21771.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> tool = bg.from_degrees(bg.Tool, normal_module=2.0, normal_pressure_angle_deg=20.0)
    >>> spur = bg.Member(tool, 20, helix_angle=0.0, cone_angle=0.0, profile_shift=0.0, face_width=20.0)
    >>> span = bg.span_measurement(spur)
    >>> span.teeth, span.dimension.round(4)
    (3, array([15.3209]))
    """
    require_member(member)
    require_integers(teeth=teeth)
    # Smallest default number of teeth in a span. Over one tooth, the planes touch too deep.
    min_default_teeth = 2
    change = np.atleast_1d(float64_of("change", change))
    total = int(member.teeth)
    if teeth is not None and not 1 <= teeth < total:
        raise ValueError(f"the number of teeth in a span must be between 1 and {total - 1}, got {teeth}")
    none = np.full(change.shape, np.nan)
    if (missing := _missing(member)) is not None:
        return Span(0, change, none, none, np.full(change.shape, np.int8(missing)))
    tool, base = member.tool, base_cylinder(member, "right")
    module, alpha = float(tool.normal_module), float(tool.normal_pressure_angle)
    radius, helix = float(base.radius), abs(float(base.helix_angle))
    pitch = np.pi * module * np.cos(alpha)
    transverse = np.arctan(np.tan(alpha) / np.cos(float(member.helix_angle)))
    one = 0.5 * pitch + module * np.cos(alpha) * total * (np.tan(transverse) - transverse)
    one += 2.0 * float(member.profile_shift) * module * np.sin(alpha)
    if teeth is None:
        shifted = float(reference_radius(member)) + float(member.profile_shift) * module
        through_v = 2.0 * np.sqrt(max(shifted**2 - radius**2, 0.0)) / np.cos(helix)
        least = min(min_default_teeth, total - 1)
        teeth = int(np.clip(np.rint((through_v - one) / pitch) + 1, least, total - 1))
    # Thickness adds A cos(alpha_n) along the normal.
    dimension = one + (teeth - 1) * pitch + change * np.cos(alpha)
    contact = np.hypot(2.0 * radius, dimension * np.cos(helix))
    low = tooth_data(member).form_diameter.max()
    on = (contact >= low) & (contact <= 2.0 * tip_radius(member, 0.0))
    cases = ~on, dimension * np.sin(helix) > float(member.face_width)
    codes = SpanStatus.OFF_FLANK, SpanStatus.FACE_TOO_NARROW
    status = np.select(cases, codes, SpanStatus.MEASURED).astype(np.int8)
    return Span(teeth, change, np.where(status == SpanStatus.MEASURED, dimension, np.nan), contact, status)


def _missing(member: Member) -> SpanStatus | None:
    """Return the reason why a member has no span, None if it has one."""
    if float(member.cone_angle) != 0.0:
        return SpanStatus.CONE
    modified = member.tool.has_parabola or any(map(member.modification, FLANK_SIGN))
    return SpanStatus.PARABOLA if modified else None
