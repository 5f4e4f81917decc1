"""The pair of Table 1 of Ni et al. (2017), written out by hand."""

from __future__ import annotations

from math import radians

from beveloid_geom import Design, Errors, Member, Pair, Tool


def table1(parabola: tuple[float, float] = (0.0, 0.0), errors: Errors | None = None) -> Design:
    """Return Table 1 with parabola coefficients (pinion, gear) in 1/mm and assembly errors."""
    pinion_tool, gear_tool = (
        Tool(normal_module=6.0, normal_pressure_angle=radians(20.0), parabola=coefficient)
        for coefficient in parabola
    )
    return Design(
        pinion=Member(
            tool=pinion_tool,
            teeth=29,
            helix_angle=radians(25.0),
            cone_angle=radians(3.0),
            profile_shift=0.17,
            face_width=50.0,
        ),
        gear=Member(
            tool=gear_tool,
            teeth=45,
            helix_angle=radians(-10.57),
            cone_angle=radians(0.8),
            profile_shift=0.2181,
            face_width=60.0,
        ),
        pair=Pair(offset=229.0, shaft_angle=radians(15.0)),
        errors=Errors() if errors is None else errors,
    )
