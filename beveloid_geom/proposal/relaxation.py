"""Changes of a request without a proposal, one quantity at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias

from .request import Request

Change: TypeAlias = Callable[[float], Request]
"""Function that returns the request changed by a fraction of the largest change."""


def request_changes(request: Request) -> Iterator[Change]:
    """Yield the changes of the given quantities of a request, in both directions."""
    # Largest changes, mm, rad and modules.
    sizes = {
        "crossing": (request.crossing or 0.0) + math.radians(3.0),
        "helix_angle": math.radians(20.0),
        "offset": 0.25 * (request.offset or 0.0),
        "cone_angles": math.radians(6.0),
        "shifts": 0.5,
        "shaft_angle": 0.5 * request.shaft_angle,
    }
    for name, size in sizes.items():
        if getattr(request, name) is not None and size > 0.0:
            for sign in (1.0, -1.0):
                yield partial(_changed, request, name, sign * size)


def others_of(request: Request) -> Iterator[Request]:
    """Yield requests with fewer given quantities, if no single change helps.

    They are: parallel axes for a small shaft angle; without shifts, helix angle or offset; only with teeth
    and shaft angle; finally the same with a shaft angle of at least 12 deg."""
    # Shaft angle above which few pairs are sensitive to errors, rad.
    insensitive_shaft_angle = math.radians(12.0)
    # Shaft angle below which most pairs are sensitive to errors, rad; parallel axes are tried then.
    sensitive_shaft_angle = math.radians(2.0)
    if 0.0 < request.shaft_angle < sensitive_shaft_angle:
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
    yield replace(free, shaft_angle=max(request.shaft_angle, insensitive_shaft_angle))


def _changed(request: Request, name: str, size: float, share: float) -> Request:
    """Return the request with a fraction `share` of the change `size` added to a quantity."""
    value = getattr(request, name)
    several = isinstance(value, tuple)
    changed: Any = tuple(each + size * share for each in value) if several else value + size * share
    return replace(request, **{name: changed})


def rounded_request(request: Request, like: Request, digits: int) -> Request:
    """Return a request with the quantity that differs from `like` rounded to `digits` significant digits,
    angles in deg."""

    def short(value: float, unit: float) -> float:
        return float(f"{value / unit:.{digits}g}") * unit

    for name in ("crossing", "helix_angle", "offset", "cone_angles", "shifts", "shaft_angle"):
        value = getattr(request, name)
        if value == getattr(like, name):
            continue
        unit = 1.0 if name in ("offset", "shifts") else math.radians(1.0)
        several = isinstance(value, tuple)
        changed: Any = tuple(short(each, unit) for each in value) if several else short(value, unit)
        return replace(request, **{name: changed})
    return request
