"""Rounding of the quantities of a proposal within tolerances of layout and backlash."""

from __future__ import annotations

import math
from dataclasses import replace

from ..design.model import Design, Pair
from ..pair.zero_backlash import layout_deviation
from .candidates import given_of
from .closure_equations import Variable
from .request import Request


def rounded_design(request: Request, design: Design) -> Design:
    """Return a proposed design, rounded to the fewest decimals within the tolerances.

    Angles are rounded in degrees and the offset in mm. If no number of decimals is sufficient, the design is
    returned unchanged.

    Parameters
    ----------
    request : Request
        Its given values are not changed.
    design : Design
        A single design.

    Returns
    -------
    Design
    """
    face = min(float(member.face_width) for member in design.members)
    module = float(design.pinion.tool.normal_module)
    backlash = layout_deviation(design).normal_backlash
    # Largest distance of the lines of action of right and left flanks after rounding, relative to the
    # narrower face.
    line_distance_share = 0.005
    # Largest change of the normal backlash by rounding.
    backlash_change_modules = 0.002
    for decimals in range(3, 10):
        candidate = _rounded(request, design, decimals)
        deviation = layout_deviation(candidate)
        near = abs(deviation.normal_backlash - backlash) <= backlash_change_modules * module
        # A pair without backlash must not jam.
        near &= deviation.normal_backlash >= min(backlash, 0.0)
        if deviation.gap <= line_distance_share * face and near:
            return candidate
    return design


def _rounded(request: Request, design: Design, decimals: int) -> Design:
    """Return the design with the free quantities of the request rounded to this number of decimals."""
    given = set(given_of(request))
    if request.shaft_angle == 0.0:  # an angle that cancels a given angle is also given
        for both in (
            {Variable.PINION_CONE, Variable.GEAR_CONE},
            {Variable.PINION_HELIX, Variable.GEAR_HELIX},
        ):
            given |= both if both & given else set()
    members = {}
    for name in ("pinion", "gear"):
        member = getattr(design, name)
        values = {}
        for key, field in (("cone", "cone_angle"), ("helix", "helix_angle"), ("shift", "profile_shift")):
            if Variable[f"{name}_{key}".upper()] in given:
                continue
            value, unit = float(getattr(member, field)), 1.0 if key == "shift" else math.radians(1.0)
            values[field] = round(value / unit, decimals) * unit
        members[name] = replace(member, **values)
    offset = float(design.pair.offset)
    offset = offset if request.offset is not None else round(offset, decimals)
    return replace(design, **members, pair=Pair(offset, design.pair.shaft_angle))
