"""Members of many shapes, for the tests of sections and elements."""

from __future__ import annotations

from dataclasses import replace
from math import radians

from beveloid_geom import Member
from tests.oracle.table1 import table1

PINION, GEAR = table1().members
TOOL = PINION.tool
SPUR = replace(PINION, cone_angle=0.0, helix_angle=0.0, profile_shift=0.0)
MEMBERS = {
    "pinion": PINION,
    "gear": GEAR,
    "spur": SPUR,
    "12 teeth": replace(SPUR, teeth=12, profile_shift=0.4),
    "200 teeth": replace(PINION, teeth=200),
    "cone 20": replace(PINION, teeth=40, cone_angle=radians(20.0), helix_angle=0.1, face_width=20.0),
    "small fillet": replace(PINION, tool=replace(TOOL, tip_radius=0.1)),
    "sharp tool": replace(GEAR, tool=replace(TOOL, tip_radius=0.0)),
    "narrow tip": replace(SPUR, teeth=15, profile_shift=0.62),
    "narrow bottom": replace(PINION, tool=replace(TOOL, normal_pressure_angle=radians(25.0), tip_radius=0.3)),
    "concave": replace(PINION, tool=replace(TOOL, parabola=0.002)),
    "convex": replace(PINION, tool=replace(TOOL, parabola=-0.004)),
}
"""Those of sections and elements."""
OTHERS = {
    **{name: MEMBERS[name] for name in ("pinion", "gear", "spur", "sharp tool", "concave", "convex")},
    "left-hand": replace(PINION, helix_angle=radians(-25.0)),
    "cylindrical": replace(PINION, cone_angle=0.0),
    "spur cone": replace(PINION, helix_angle=0.0),
    "steep": replace(PINION, cone_angle=radians(10.0), face_width=20.0, profile_shift=0.3),
    "narrow": replace(PINION, tool=replace(TOOL, parabola=0.0079)),
    "steep helix": replace(PINION, helix_angle=radians(45.0)),
    "few teeth": Member(TOOL, 12, 0.1, 0.02, 0.6, 20.0),
    "many teeth": replace(PINION, teeth=110),
}
"""Those of solids and surfaces."""
