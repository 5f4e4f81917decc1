"""Random pairs in wide, valid batches: one Design whose quantities are arrays of one batch axis.

There are six kinds. 'fitted' pairs have no backlash: for a random working pressure angle, offset, shaft angle
and profile shift follow in closed form. 'strained' pairs are 'fitted' pairs under errors of all sizes.
'usual' pairs are as gears are made, under errors as they occur in assembly. 'touching' pairs are placed at a
random point of both flanks with a random angle between the generators and given mounting distances; n_x
vanishes with this angle. 'wild' layouts are unrelated to the gears. 'intersecting' pairs have no backlash at
offset 0, some with usual errors, others with errors of all sizes; half of the shaft angles are rounded.
Members have 1 to 300 teeth and modules of 0.3 to 10, with cone and helix angles of both signs up to the
limits of a design file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np

from beveloid_geom import Design, Errors, Member, Pair, Tool
from beveloid_geom.arrays import Flank, FloatArray
from beveloid_geom.design.member import unchecked
from beveloid_geom.pair.zero_backlash import ZeroBacklashLayout, closed_layout

from .five_residuals import Vector, cases_of, flank_at, mapped, rack_at

Kind = Literal["usual", "fitted", "strained", "touching", "wild", "intersecting"]
KINDS: tuple[Kind, ...] = get_args(Kind)
DEG = np.pi / 180.0


def spread(rng: np.random.Generator, low: float, high: float, size: int) -> FloatArray:
    """Return numbers of all magnitudes between two bounds."""
    return np.asarray(np.exp(rng.uniform(np.log(low), np.log(high), size)))


def signed(rng: np.random.Generator, low: float, high: float, size: int, zeros: float = 0.1) -> FloatArray:
    """Return numbers of both signs, and a share of exact zeros."""
    return np.asarray(
        spread(rng, low, high, size) * rng.choice([-1.0, 1.0], size) * (rng.random(size) >= zeros)
    )


def parabola_limits(member: Member) -> FloatArray:
    """Return the limits of `design.limits.parabola_limit` for arrays."""
    tool = member.tool
    alpha, height = tool.normal_pressure_angle, tool.normal_module * np.maximum(tool.addendum, tool.dedendum)
    lowest = np.arctan(np.abs(np.sin(member.helix_angle) * np.tan(member.cone_angle))) + DEG
    low, high = (
        bend * (np.cos(alpha) + 0.5 * bend * np.sin(alpha)) / (2.0 * height)
        for bend in (np.tan(alpha - lowest), np.tan(alpha - 60.0 * DEG))
    )
    return np.asarray(np.minimum(low, -high))


def random_members(rng: np.random.Generator, size: int) -> tuple[Member, Member]:
    """Return pinions and gears that share their base pitch, most with the same tool."""
    module = np.where(rng.random(size) < 0.9, spread(rng, 1.0, 8.0, size), spread(rng, 0.3, 10.0, size))
    alpha = DEG * np.where(rng.random(size) < 0.5, 20.0, rng.uniform(14.5, 30.0, size))
    other = np.where(rng.random(size) < 0.9, alpha, alpha + DEG * rng.uniform(-3.0, 3.0, size))
    steep, twisted = rng.random(size) < 0.15, rng.random(size) < 0.15
    members = []
    for pressure in (alpha, other):
        tool = Tool(
            normal_module=module * np.cos(alpha) / np.cos(pressure),
            normal_pressure_angle=pressure,
            addendum=np.where(rng.random(size) < 0.8, 1.0, rng.uniform(0.5, 1.4, size)),
            dedendum=np.where(rng.random(size) < 0.8, 1.25, rng.uniform(1.0, 1.8, size)),
            tip_radius=np.where(rng.random(size) < 0.8, 0.38, rng.uniform(0.0, 0.45, size)),
        )
        usual, wide = rng.uniform(-35.0, 35.0, size), rng.uniform(-70.0, 70.0, size)
        flat, cone = signed(rng, 0.01, 8.0, size), signed(rng, 0.1, 40.0, size)
        teeth = np.where(rng.random(size) < 0.85, rng.integers(12, 80, size), spread(rng, 1, 300, size))
        member = Member(
            tool=tool,
            teeth=np.floor(teeth),
            helix_angle=DEG * np.where(twisted, wide, usual) * (rng.random(size) >= 0.05),
            cone_angle=DEG * np.where(steep, cone, flat),
            profile_shift=np.where(rng.random(size) < 0.8, rng.uniform(-0.4, 0.6, size), 0.0),
            face_width=module * spread(rng, 1.0, 30.0, size),
            tip_alteration=np.zeros(size),
        )
        most = np.maximum(parabola_limits(member), 0.0)
        share = np.where(
            rng.random(size) < 0.2, signed(rng, 1e-9, 1.0, size), signed(rng, 1e-3, 0.6, size, 0.25)
        )
        members.append(replace(member, tool=replace(tool, parabola=share * most)))
    return members[0], members[1]


def narrow_radius(member: Member) -> FloatArray:
    """Return the tip radius at the narrow end of the face, mm."""
    height = 0.5 * member.teeth / np.cos(member.helix_angle) + member.profile_shift + member.tool.addendum
    taper = 0.5 * member.face_width * np.abs(np.tan(member.cone_angle))
    return np.asarray(member.tool.normal_module * height - taper)


def valid(design: Design) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which designs of the batch a design file could contain."""
    pair, errors = design.pair, design.errors
    good = np.abs(errors.offset) <= 10.0 * design.pinion.tool.normal_module
    for member in design.members:
        tool = member.tool
        round_limit = (tool.dedendum - 0.5) / (1.0 - np.sin(tool.normal_pressure_angle))
        good = good & (parabola_limits(member) > 0.0) & (tool.tip_radius <= round_limit)
        good = good & (np.abs(tool.parabola) <= parabola_limits(member)) & (narrow_radius(member) > 0.0)
        good = good & (np.abs(member.profile_shift) <= 3.0)
    good = good & (pair.offset >= 0.0) & (pair.offset <= 1e5)
    good = good & (pair.shaft_angle >= 0.5 * DEG) & (pair.shaft_angle <= 90.0 * DEG)
    good = good & (np.abs(errors.shaft_angle) <= 5.0 * DEG)
    good = good & (pair.shaft_angle + errors.shaft_angle >= 0.5 * DEG)
    for name in ("pinion", "gear"):
        good = good & (np.abs(getattr(errors, f"{name}_axial")) <= 1000.0)
        mounting = getattr(pair, f"{name}_mounting")
        good = good & (True if mounting is None else np.abs(mounting) <= 1e5)
    return np.asarray(good)


def usual_members(rng: np.random.Generator, size: int) -> tuple[Member, Member]:
    """Return pinions and gears as they are made, with parabolas of up to 0.004 modules."""
    module, alpha = rng.uniform(1.0, 8.0, size), DEG * rng.choice([17.5, 20.0, 22.5, 25.0], size)
    hand = rng.choice([-1.0, 1.0], size)
    members = []
    for low, high in ((12.0, 35.0), (2.0, 30.0)):
        member = Member(
            tool=Tool(module, alpha, *(np.full(size, ratio) for ratio in (1.0, 1.25, 0.38))),
            teeth=np.floor(spread(rng, 15, 120, size)),
            helix_angle=DEG * hand * rng.uniform(low, high, size),
            cone_angle=DEG * rng.uniform(-1.0, 5.0, size),
            profile_shift=rng.uniform(-0.2, 0.4, size),
            face_width=module * rng.uniform(5.0, 12.0, size),
            tip_alteration=np.zeros(size),
        )
        relief = module * signed(rng, 1e-5, 0.004, size, 0.25)
        members.append(replace(member, tool=replace(member.tool, parabola=relief / module**2)))
    return members[0], members[1]


def usual(rng: np.random.Generator, size: int) -> Design:
    """Return pairs as they are made and mounted."""
    return fitted(rng, size, usual_members(rng, size)).with_errors(usual_errors(rng, size))


def usual_errors(rng: np.random.Generator, size: int) -> Errors:
    """Return assembly errors as they occur, each absent in a third of the cases."""
    offset, pinion, gear = (signed(rng, 1e-4, 0.3, size, 0.33) for _ in range(3))
    return Errors(offset, DEG * signed(rng, 1e-4, 0.05, size, 0.33), pinion, gear)


def fitted(
    rng: np.random.Generator,
    size: int,
    members: tuple[Member, Member] | None = None,
    aw: FloatArray | None = None,
) -> Design:
    """Return pairs without backlash: the layout follows from a random working pressure angle, and the profile
    shift of the gear removes the backlash, in which it is linear."""
    pinion, gear = random_members(rng, size) if members is None else members
    if aw is None:
        aw = np.asarray(pinion.tool.normal_pressure_angle + DEG * rng.normal(0.0, 1.5, size))

    def laid_out(shift: float) -> ZeroBacklashLayout:
        thicker = unchecked(gear, profile_shift=gear.profile_shift + shift)
        return closed_layout(Design(pinion, thicker, Pair(1.0, 1.0)), aw)

    layout = laid_out(0.0)
    taken_up = layout.normal_backlash - laid_out(1.0).normal_backlash
    gear = unchecked(gear, profile_shift=gear.profile_shift + layout.normal_backlash / taken_up)
    pair = drawn_pair(offset=layout.offset, shaft_angle=layout.shaft_angle)
    return Design(pinion, gear, pair, no_errors(size))


def intersecting(rng: np.random.Generator, size: int) -> Design:
    """Return pairs on intersecting axes: with a random working pressure angle, the helix angle of the gear
    is such that both working helix angles cancel, and the shaft angle is the sum of the working cone
    angles."""
    half = size // 2
    parts = []
    for members, errors in (
        (usual_members(rng, half), usual_errors(rng, half)),
        (random_members(rng, size - half), random_errors(rng, size - half)),
    ):
        pinion, gear = members
        count = np.size(pinion.helix_angle)
        aw = np.asarray(pinion.tool.normal_pressure_angle) + DEG * rng.normal(0.0, 1.0, count)
        lean = []
        for member in members:
            alpha, gamma = member.tool.normal_pressure_angle, member.cone_angle
            working = np.arcsin(np.sin(alpha) * np.sin(gamma) / np.sin(aw))
            lean.append(np.cos(alpha) * np.cos(gamma) / np.cos(working))
        gear = unchecked(gear, helix_angle=-np.arcsin(np.sin(pinion.helix_angle) * lean[0] / lean[1]))
        design = fitted(rng, count, (pinion, gear), aw)
        angle = design.pair.shaft_angle
        angle = np.where(rng.random(count) < 0.5, DEG * np.round(angle / DEG, 2), angle)
        design = replace(design, pair=drawn_pair(offset=np.zeros(count), shaft_angle=angle), errors=errors)
        parts.append(cases_of(design, valid(design)))
    both: Design = mapped(_joined, *parts)
    mixed: Design = cases_of(both, rng.permutation(np.size(both.pair.offset)))
    return mixed


def drawn_pair(**values: FloatArray) -> Pair:
    """Return a random layout before `valid` selects: some are NaN or meaningless."""
    return unchecked(Pair(1.0, 1.0), **values)


def no_errors(size: int) -> Errors:
    """Return the assembly errors of a batch, all zero."""
    return Errors(*(np.zeros(size) for _ in range(4)))


def random_errors(rng: np.random.Generator, size: int) -> Errors:
    """Return assembly errors of all sizes, each absent in a third of the cases."""
    mm = (signed(rng, 1e-4, 50.0, size, 0.33) for _ in range(3))
    angle = DEG * signed(rng, 1e-4, 5.0, size, 0.33)
    offset, pinion, gear = mm
    return Errors(offset, angle, pinion, gear)


def strained(rng: np.random.Generator, size: int) -> Design:
    """Return fitted pairs under random errors; half of them are rounded as on a drawing."""
    design = fitted(rng, size)
    rounded = rng.random(size) < 0.5
    pair = drawn_pair(
        offset=np.where(rounded, np.round(design.pair.offset, 1), design.pair.offset),
        shaft_angle=np.where(
            rounded, DEG * np.round(design.pair.shaft_angle / DEG, 2), design.pair.shaft_angle
        ),
    )
    return replace(design, pair=pair, errors=random_errors(rng, size))


def touching(rng: np.random.Generator, size: int, flank: Flank = "right") -> Design:
    """Return pairs placed at a random point of both flanks, with given mounting distances.

    The pinion is fixed. The gear is placed with its point on that of the pinion, normal against normal, and
    rotated about the normal until the generators cross at a random angle. The common perpendicular of the
    axes follows. The sine of the angle is n_x sin(d)/(S1 S2): n_x vanishes with the angle."""
    members = random_members(rng, size)
    points, normals = [], []
    for member in members:
        l = member.tool.normal_module * rng.uniform(-0.9, 0.9, size)
        z = member.face_width * rng.uniform(-0.5, 0.5, size)
        rack = rack_at(member, flank, l[:, None])
        u = (z - rack.point[2][:, 0]) / rack.trace[2][:, 0]
        zero = np.zeros((size, 1))
        placed = [_stacked(v) for v in flank_at(member, flank, l[:, None], u[:, None], zero)]
        points.append(placed[0])
        normals.append(placed[1])
    angle = signed(rng, 1e-6, 0.5, size, 0.05)
    axis = np.array([0.0, 0.0, 1.0])
    frames = []
    for normal in normals:
        along = axis - normal[:, 2:] * normal
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        frames.append(np.stack((normal, along, np.cross(normal, along)), axis=-2))
    sin, cos = np.sin(angle), np.cos(angle)
    none = np.zeros(size)
    # Gear normal and both tangents in the frame of the pinion normal and tangents.
    turn = np.array([[none - 1.0, none, none], [none, cos, sin], [none, sin, -cos]]).transpose(2, 0, 1)
    rotation = np.swapaxes(frames[1], 1, 2) @ turn @ frames[0]
    second = axis @ rotation
    centre = points[0] - np.einsum("ij,ijk->ik", points[1], rotation)
    sin_d2 = 1.0 - second[:, 2] ** 2
    # Feet s1 k1 and centre + s2 k2 of the common perpendicular.
    on_first, on_second = centre[:, 2], np.einsum("ij,ij->i", centre, second)
    s1 = (on_first - second[:, 2] * on_second) / sin_d2
    s2 = (second[:, 2] * on_first - on_second) / sin_d2
    between = centre + s2[:, None] * second - s1[:, None] * axis
    offset = np.linalg.norm(between, axis=-1)
    signed_sin = -np.einsum("ij,ij->i", np.cross(axis, second), between) / offset
    hand = np.where(members[0].helix_angle + members[1].helix_angle < 0.0, -1.0, 1.0)
    shaft = np.where((signed_sin * hand > 0.0) & (offset < 1e4), np.arccos(second[:, 2]), np.nan)
    errors = random_errors(rng, size)
    errors = Errors(*(np.where(rng.random(size) < 0.5, value, 0.0) for value in vars(errors).values()))
    pair = drawn_pair(
        offset=offset - errors.offset,
        shaft_angle=shaft - errors.shaft_angle,
        pinion_mounting=-s1 - errors.pinion_axial,
        gear_mounting=-s2 - errors.gear_axial,
    )
    return Design(members[0], members[1], pair, errors)


def _stacked(vector: Vector) -> FloatArray:
    return np.stack([part[:, 0] for part in vector], axis=-1)


def wild(rng: np.random.Generator, size: int) -> Design:
    """Return layouts that are unrelated to the gears."""
    pinion, gear = random_members(rng, size)
    pair = Pair(spread(rng, 0.01, 2000.0, size), DEG * spread(rng, 0.5, 90.0, size))
    return Design(pinion, gear, pair, random_errors(rng, size))


MAKERS = {"usual": usual, "fitted": fitted, "strained": strained, "wild": wild, "intersecting": intersecting}


def _joined(*columns: Any) -> Any:
    """Join one quantity of several batches; a quantity that is not an array has one value in all of them."""
    if np.ndim(columns[0]):
        return np.concatenate(columns)
    (value,) = set(columns)
    return value


def random_designs(kind: Kind, size: int, seed: int, flank: Flank = "right") -> Design:
    """Return a batch of `size` valid designs; `flank` is the one on which 'touching' pairs touch."""
    rng, parts, found = np.random.default_rng((seed, KINDS.index(kind))), [], 0
    while found < size:
        with np.errstate(invalid="ignore", divide="ignore"):
            many = 2 * size + 64
            drawn = touching(rng, many, flank) if kind == "touching" else MAKERS[kind](rng, many)
            kept = np.flatnonzero(valid(drawn))
        parts.append(cases_of(drawn, kept))
        found += kept.size
    designs: Design = cases_of(mapped(_joined, *parts), slice(size))
    return designs
