"""Pairs on intersecting axes with a positive backlash that is limited by the contact of two edges."""

from __future__ import annotations

from dataclasses import replace
from math import radians

from beveloid_geom import Design, Errors, Member, Pair, Tool


def edge_pair(number: int) -> Design:
    """Return a pair: the first has parabolas of both signs and errors, the second a gear without a cone."""
    if number == 0:
        module, addendum, clearance = 3.892223912938121, 0.9181876571851364, 0.25
        members = (
            (35, 30.27955912481109, 4.6401521054946855, 0.11312724681799063, 27.14, 0.002268571536390815),
            (41, -30.28551961369588, 5.7795118492029705, 0.30786060018728795, 11.82, -0.00021788834633206552),
        )
        angle, errors = 9.897240220570724, Errors(0.001438558578886313, 0.0, -0.0056611830309270484, 0.014)
    else:
        module, addendum, clearance = 1.0103702564733241, 1.0, 0.25
        members = (
            (35, -5.7273454881099966, 6.772938952608187, 0.03809842542865832, 10.889, 0.03554654817170872),
            (70, 5.723704402966868, 0.0, 0.2838167309862793, 4.116, 0.002504677067562972),
        )
        angle, errors = 6.459860999181511, Errors()
    tool = Tool(module, radians(20.0), addendum, addendum + clearance, 0.38)
    pinion, gear = (
        Member(replace(tool, parabola=parabola), teeth, radians(helix), radians(cone), shift, width)
        for teeth, helix, cone, shift, width, parabola in members
    )
    return Design(pinion, gear, Pair(0.0, radians(angle)), errors)
