"""Random pairs on parallel and nearly parallel axes, and contact ratios of ISO 21771 in closed form."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from math import acos, atan, cos, pi, radians, sin, sqrt, tan

import numpy as np
from scipy.optimize import brentq

from beveloid_geom import Design, Errors, Member, Pair, Tool
from beveloid_geom.gear.tooth_side import surface_of

FLANKS = ("right", "left")


def pair_of(
    module: float,
    teeth: tuple[int, int],
    helix_deg: float,
    offset: float,
    shift: tuple[float, float] = (0.0, 0.0),
    face: tuple[float, float] = (30.0, 30.0),
    cone_deg: float = 0.0,
    pressure_deg: float = 20.0,
    tip_radius: float = 0.38,
) -> Design:
    """Return members with opposite helix and cone angles on parallel axes."""
    tool = Tool(module, radians(pressure_deg), tip_radius=tip_radius)
    pinion, gear = (
        Member(tool, teeth[k], side * radians(helix_deg), side * radians(cone_deg), shift[k], face[k])
        for k, side in enumerate((1.0, -1.0))
    )
    return Design(pinion, gear, Pair(offset, 0.0))


HELICAL = pair_of(3.0, (25, 50), 15.0, 116.6)


def involute(angle: float) -> float:
    return tan(angle) - angle


def sized(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number of any magnitude and either sign."""
    return float(rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn(rng: np.random.Generator) -> Design | None:
    """Return a random pair of spur gears, helical gears, or helical gears with opposite cones, with up to
    0.08 modules more offset than without backlash, half of them with errors that leave the axes parallel;
    None if there is none."""
    kind, module = rng.integers(3), float(np.exp(rng.uniform(0.0, 2.3)))
    pressure_deg = float(rng.choice([14.5, 17.5, 20.0, 20.0, 22.5, 25.0]))
    first, second = (int(number) for number in np.exp(rng.uniform(np.log(14), np.log(120), 2)))
    helix_deg = 0.0 if kind == 0 else sized(rng, 3.0, 35.0)
    cone_deg = float(rng.uniform(-4.0, 4.0)) if kind == 2 else 0.0
    shift = rng.uniform(-0.2, 0.5, 2).tolist()
    pressure, helix = radians(pressure_deg), radians(helix_deg)
    transverse = atan(tan(pressure) / cos(helix))
    working = involute(transverse) + 2.0 * sum(shift) * tan(pressure) / (first + second)
    if working < 1e-4:
        return None
    angle = brentq(lambda a: involute(a) - working, 1e-3, 1.2)
    offset = 0.5 * module * (first + second) / cos(helix) * cos(transverse) / cos(angle)
    offset += module * float(rng.uniform(0.0, 0.08))
    face = module * float(rng.uniform(3.0, 15.0)), module * float(rng.uniform(3.0, 15.0))
    design = pair_of(module, (first, second), helix_deg, offset, shift, face, cone_deg, pressure_deg)
    errors = Errors(
        module * float(rng.uniform(0.0, 0.02)), 0.0, *(module * rng.uniform(-0.1, 0.1, 2)).tolist()
    )
    return design.with_errors(errors if rng.random() < 0.5 else Errors())


def sound(design: Design) -> bool:
    """Return whether the tool has a fillet and undercuts no flank."""
    try:
        return all(
            surface_of(member, flank).crossing is None for member in design.members for flank in FLANKS
        )
    except ValueError:
        return False


def sound_pairs(rng: np.random.Generator) -> Iterator[Design]:
    """Draw unmodified pairs on parallel axes whose flanks are sound, without end."""
    while True:
        design = drawn(rng)
        if design is not None and sound(design):
            yield design


def parallel_pairs(number: int, seed: int) -> Iterator[Design]:
    """Draw unmodified pairs on parallel axes."""
    return islice(sound_pairs(np.random.default_rng((seed, 21771))), number)


def nearly_parallel_pairs(number: int, seed: int) -> Iterator[Design]:
    """Draw pairs on parallel axes with and without parabolas, most of them tilted by 1e-9 to 2e-3 rad."""
    rng = np.random.default_rng((seed, 10064))
    for design in islice(sound_pairs(rng), number):
        module = float(design.pinion.tool.normal_module)
        bends = [sized(rng, 1e-6, 4e-3) / module * float(rng.random() < 0.45) for _ in range(2)]
        tilt = sized(rng, 1e-9, 2e-3) * float(rng.random() < 0.7)
        yield design.with_parabola(*bends).with_errors(replace(design.errors, shaft_angle=tilt))


def ratios_of_iso(design: Design) -> tuple[float, float]:
    """Return eps_alpha and eps_beta of a cylindrical pair with errors of offset and axial position. Flanks
    reach from the tip down to the joint with the fillet."""
    module, pressure = (
        float(v) for v in (design.pinion.tool.normal_module, design.pinion.tool.normal_pressure_angle)
    )
    helix = abs(float(design.pinion.helix_angle))
    transverse, offset = (
        atan(tan(pressure) / cos(helix)),
        float(design.pair.offset) + float(design.errors.offset),
    )
    radii = [0.5 * module * float(member.teeth) / cos(helix) for member in design.members]
    base = [radius * cos(transverse) for radius in radii]
    length = offset * sin(acos(sum(base) / offset))
    reach = []
    for member, radius, inner in zip(design.members, radii, base, strict=True):
        shift, addendum = module * float(member.profile_shift), module * float(member.tool.addendum)
        altered = module * float(member.tip_alteration)
        outer = sqrt((radius + shift + addendum + altered) ** 2 - inner**2)
        joint = float(member.tool.dedendum - member.tool.tip_radius * (1.0 - sin(pressure)))
        # A tip radius of 0.38 modules is rounded: its joint lies at the depth of the addendum.
        depth = addendum if abs(joint - float(member.tool.addendum)) < 1e-4 else module * joint
        lowest = radius * sin(transverse) - (depth - shift) / sin(transverse)
        reach.append((lowest, outer))
    start, stop = max(reach[0][0], length - reach[1][1]), min(reach[0][1], length - reach[1][0])
    half = [0.5 * float(member.face_width) for member in design.members]
    position = float(design.errors.pinion_axial), float(design.errors.gear_axial)
    width = min(p + h for p, h in zip(position, half, strict=True))
    width -= max(p - h for p, h in zip(position, half, strict=True))
    pitch = 2.0 * pi * base[0] / float(design.pinion.teeth)
    return (stop - start) / pitch, width * tan(helix) * cos(transverse) / pitch
