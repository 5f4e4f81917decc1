"""How a request may be changed to one that works, one number at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias

from .request import Request

Change: TypeAlias = Callable[[float], Request]
"""Gives the request changed by a share of the greatest change that is tried."""
OFFSET, SHAFT, CROSSING = 0.25, 0.5, 1.0
"""Greatest changes over the value itself."""
LINES = math.radians(3.0)
"""Greatest change of a crossing angle, beyond that, from line contact on."""
WIDE = math.radians(12.0)
"""Shaft angle (rad) from which on few pairs are sensitive to errors."""
NEARLY = math.radians(2.0)
"""Shaft angle (rad) up to which most pairs are, so that parallel axes are tried."""
HELIX, CONES, SHIFTS = math.radians(20.0), math.radians(6.0), 0.5
"""Greatest changes, rad and modules."""


def changes_of(request: Request) -> Iterator[Change]:
    """Give the changes of what a request gives, up and down."""
    sizes = {
        "crossing": CROSSING * (request.crossing or 0.0) + LINES,
        "helix_angle": HELIX,
        "offset": OFFSET * (request.offset or 0.0),
        "cone_angles": CONES,
        "shifts": SHIFTS,
        "shaft_angle": SHAFT * request.shaft_angle,
    }
    for name, size in sizes.items():
        if getattr(request, name) is not None and size > 0.0:
            for way in (1.0, -1.0):
                yield partial(_changed, request, name, way * size)


def others_of(request: Request) -> Iterator[Request]:
    """Give requests that give less, for where no number alone can be changed: parallel axes for those that
    nearly are; without what is given of the shifts, of the helix angle, of the offset; at last with nothing
    given but teeth and angle of the axes."""
    if 0.0 < request.shaft_angle < NEARLY:
        yield replace(request, shaft_angle=0.0)
    if request.shifts is not None:
        yield replace(request, shifts=None)
    if request.helix_angle is not None and request.crossing is None and request.offset != 0.0:
        yield replace(request, helix_angle=None)
    if request.cone_angles is not None and request.offset:
        yield replace(request, offset=None)
    alone = replace(request, cone_angles=None, crossing=None, gear=None, shifts=None, least_cones=True)
    yield alone
    yield replace(alone, helix_angle=None)
    free = replace(alone, helix_angle=None, offset=None)
    yield free
    yield replace(free, shaft_angle=max(request.shaft_angle, WIDE))


def _changed(request: Request, name: str, size: float, share: float) -> Request:
    value = getattr(request, name)
    several = isinstance(value, tuple)
    changed: Any = tuple(one + size * share for one in value) if several else value + size * share
    return replace(request, **{name: changed})


def rounded(request: Request, like: Request, digits: int) -> Request:
    """Give a request with what is not as in `like` in so many significant digits, angles in deg."""

    def short(value: float, unit: float) -> float:
        return float(f"{value / unit:.{digits}g}") * unit

    for name in ("crossing", "helix_angle", "offset", "cone_angles", "shifts", "shaft_angle"):
        value = getattr(request, name)
        if value == getattr(like, name):
            continue
        unit = 1.0 if name in ("offset", "shifts") else math.radians(1.0)
        several = isinstance(value, tuple)
        changed: Any = tuple(short(one, unit) for one in value) if several else short(value, unit)
        return replace(request, **{name: changed})
    return request
