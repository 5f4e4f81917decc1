"""Rounding of the quantities of a proposal within tolerances of layout and backlash."""

from __future__ import annotations

import math
from dataclasses import replace

from ..design.model import Design, Pair
from ..pair.zero_backlash import closing_of
from .candidates import given_of
from .closure_equations import GEAR_CONE, GEAR_HELIX, PINION_CONE, PINION_HELIX, VARIABLES
from .request import Request

DECIMALS = range(3, 10)
"""Numbers of decimals that are tried (deg, mm, modules)."""
LINE_DISTANCE_SHARE = 0.005
"""Largest distance of the lines of action of right and left flanks after rounding, relative to the narrower
face."""
BACKLASH_CHANGE_MODULES = 0.002
"""Largest change of the normal backlash by rounding."""


def rounded(request: Request, design: Design) -> Design:
    """Return a proposed design, rounded to the fewest decimals within the tolerances.

    Angles are rounded in degrees and the offset in mm; given values of the request are not changed. After
    rounding, the lines of action may pass each other at LINE_DISTANCE_SHARE, and the backlash may change by
    BACKLASH_CHANGE_MODULES. If no number of decimals is sufficient, the design is returned unchanged."""
    face = min(float(member.face_width) for member in design.members)
    module = float(design.pinion.tool.normal_module)
    backlash = closing_of(design).normal_backlash
    for decimals in DECIMALS:
        candidate = _rounded(request, design, decimals)
        closing = closing_of(candidate)
        near = abs(closing.normal_backlash - backlash) <= BACKLASH_CHANGE_MODULES * module
        if closing.gap <= LINE_DISTANCE_SHARE * face and near:
            return candidate
    return design


def _rounded(request: Request, design: Design, decimals: int) -> Design:
    """Return the design with the free quantities of the request rounded to this number of decimals."""
    given = set(given_of(request))
    if request.shaft_angle == 0.0:  # an angle that cancels a given angle is also given
        for both in ({PINION_CONE, GEAR_CONE}, {PINION_HELIX, GEAR_HELIX}):
            given |= both if both & given else set()
    members = {}
    for name in ("pinion", "gear"):
        member = getattr(design, name)
        values = {}
        for key, field in (("cone", "cone_angle"), ("helix", "helix_angle"), ("shift", "profile_shift")):
            if VARIABLES.index(f"{name}_{key}") in given:
                continue
            value, unit = float(getattr(member, field)), 1.0 if key == "shift" else math.radians(1.0)
            values[field] = round(value / unit, decimals) * unit
        members[name] = replace(member, **values)
    offset = float(design.pair.offset)
    offset = offset if request.offset is not None else round(offset, decimals)
    return replace(design, **members, pair=Pair(offset, design.pair.shaft_angle))
