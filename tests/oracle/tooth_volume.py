"""Exact volumes of gears: sections by flank, fillet and lands, integrated along outline and face."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any, TypeAlias

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.legendre import leggauss

from beveloid_geom import Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.fillet import bottom_point, fillet_point, tool_round
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.gear.flank_limits import tip_parameter, tip_radius

Exact: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Points and normals of a surface at its parameter and z."""


def exact_places(member: Member, flank: str) -> dict[str, tuple[Exact, Callable[[Any], tuple[Any, Any]]]]:
    """Return flank and fillet of tooth 0, and the ends of their parameters, the end with the smallest
    radius first."""
    rounding = tool_round(member.tool, flank)

    def on_flank(l: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        patch = flank_patch(member, flank, l, z=z)
        return patch.point, patch.normal

    def on_fillet(angle: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return fillet_point(member, flank, angle, z)

    return {
        "flank": (on_flank, lambda z: (rounding.joint, tip_parameter(member, flank, z))),
        "fillet": (on_fillet, lambda z: (0.5 * pi, rounding.angle)),
    }


def section_area(member: Member, z: float) -> float:
    """Return the area of one tooth with its space, down to the axis: half the integral of x dy - y dx."""
    nodes, weights = leggauss(60)
    area, angles = 0.0, {}
    for flank, sense in (("right", -1.0), ("left", 1.0)):
        for part, (surface, limits) in exact_places(member, flank).items():
            low, high = limits(z)

            def place(s: FloatArray, axis: int, on: Any = surface, low: Any = low, high: Any = high) -> Any:
                return on(low + 0.5 * (1.0 + s) * (high - low), z + 0.0 * s)[0][..., axis]

            x, y = (Chebyshev.interpolate(place, 50, args=(axis,)) for axis in (0, 1))
            area += sense * 0.5 * weights @ (x(nodes) * y.deriv()(nodes) - y(nodes) * x.deriv()(nodes))
            angles[flank, part] = [float(np.arctan2(y(end), x(end))) for end in (-1.0, 1.0)]
    tip = angles["right", "flank"][1] - angles["left", "flank"][1]
    root = 2.0 * pi / float(member.teeth) - angles["right", "fillet"][0] + angles["left", "fillet"][0]
    lowest = bottom_point(member, "right", 0.0, z)[0]
    return float(area + 0.5 * tip * tip_radius(member, z) ** 2 + 0.5 * root * lowest[:2] @ lowest[:2])


def exact_volume(member: Member, teeth: int, bore: float) -> float:
    """Return the volume (mm^3) of some teeth with their spaces, by Gauss points along the face and the
    section."""
    nodes, weights = leggauss(12)
    half = 0.5 * float(member.face_width)
    areas = np.array([section_area(member, half * node) for node in nodes])
    return float(teeth * half * weights @ (areas - pi / float(member.teeth) * bore**2))
