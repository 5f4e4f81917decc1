"""Random requests of all kinds, with and without solutions."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, radians
from typing import Any

import numpy as np

from beveloid_geom import Member, Tool
from beveloid_geom.proposal.request import Request

KINDS = ("cones", "cones at an offset", "crossing", "least cones", "intersecting", "gear held", "parallel")


def random_requests(count: int, seed: int) -> Iterator[Request]:
    """Yield requests of all KINDS in turn."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        yield random_request(rng, KINDS[k % len(KINDS)])


def random_request(rng: np.random.Generator, kind: str) -> Request:
    """Return a random request of one kind, with usual sizes and angles that may or may not fit each other."""
    module = float(rng.choice([1.5, 2.0, 3.0, 4.0, 6.0, 8.0]))
    first = int(rng.integers(14, 41))
    teeth = first, min(int(first * rng.uniform(1.0, 3.2)), 110)
    tool, shaft = (
        Tool(module, radians(20.0)),
        float(rng.uniform(2.0, 20.0) if kind == "intersecting" else rng.uniform(3.0, 40.0)),
    )
    helix = float(rng.uniform(-30.0, 30.0))
    reach = 0.5 * module * (teeth[0] / cos(radians(helix)) + teeth[1] / cos(radians(shaft - helix)))
    offset: float | None = float(reach * rng.uniform(0.85, 1.1))
    if kind == "parallel":
        return parallel_request(rng, tool, teeth, radians(helix))
    face = module * float(rng.uniform(6.0, 12.0))
    more: dict[str, Any] = {}
    cones = rng.uniform(-2.0, 7.0, 2)
    if kind == "cones":
        offset = None
        more = {"cone_angles": tuple(np.radians(cones).tolist())}
        if rng.random() < 0.5:
            more["helix_angle"] = radians(helix)
    elif kind == "cones at an offset":
        more = {"cone_angles": tuple(np.radians(cones).tolist())}
    elif kind == "crossing":
        more = {"helix_angle": radians(helix), "crossing": radians(shaft * float(rng.uniform(0.1, 0.6)))}
    elif kind == "least cones":
        more = {"least_cones": True}
        if rng.random() < 0.5:
            more["helix_angle"] = radians(helix)
    elif kind == "intersecting":
        offset, drawn = 0.0, rng.random()
        share = float(rng.uniform(-0.2, 1.2))
        if drawn < 0.4:
            more = {"cone_angles": (radians(share * shaft), radians((1.0 - share) * shaft))}
        else:
            more = {"helix_angle": radians(helix)} if drawn < 0.7 else {"least_cones": True}
    else:
        slant = radians(float(rng.uniform(-25.0, 25.0)))
        cone, shift = radians(float(rng.uniform(0.0, 6.0))), float(rng.uniform(-0.3, 0.3))
        more = {"gear": Member(tool, teeth[1], slant, cone, shift, face)}
        offset = 0.0 if rng.random() < 0.3 else offset
        shaft = min(shaft, 12.0) if offset == 0.0 else shaft
    if "gear" not in more and rng.random() < 0.4 and not (offset == 0.0 and "cone_angles" in more):
        more["shifts"] = tuple(rng.uniform(-0.1, 0.4, 2).tolist())
    backlash = module * float(rng.uniform(0.01, 0.08))
    flank = str(rng.choice(["right", "left"]))
    return Request(module, teeth, (face, face), radians(shaft), backlash, offset, flank, **more)


def parallel_request(rng: np.random.Generator, tool: Tool, teeth: tuple[int, int], helix: float) -> Request:
    """Return a request on parallel axes: opposite cones, least cones or a given gear, with an offset or
    without."""
    module, face, drawn = float(tool.normal_module), float(tool.normal_module) * 8.0, rng.random()
    cone, shift = radians(float(rng.uniform(0.0, 6.0))), float(rng.uniform(-0.3, 0.3))
    offset = 0.5 * module * sum(teeth) / cos(helix) * float(rng.uniform(0.97, 1.04))
    free = rng.random() < 0.5
    more: dict[str, Any] = {"least_cones": True}
    if drawn < 0.4:
        more = {"cone_angles": (cone, -cone)}
    elif drawn < 0.6:
        more = {"gear": Member(tool, teeth[1], -helix, -cone, shift, face)}
    if drawn < 0.2 or drawn > 0.8:
        more["helix_angle"] = helix
    backlash, flank = module * float(rng.uniform(0.01, 0.08)), str(rng.choice(["right", "left"]))
    return Request(module, teeth, (face, face), 0.0, backlash, None if free else offset, flank, **more)
