"""Limits of a design file that combine several keys, and their messages.

Limits of single keys are in `field_limits`. Here, the finished inputs of a file are checked:

- The normal of the rack, out of the tooth, must have a positive radial component on both flanks,
  tan(alpha) > sin|beta| tan|gamma|. Where it vanishes, the generating roll angle of Eq. 6 is infinite.
- The same holds along a parabolic flank, and the parabolic profile must not fold.
- The flank of the tool must reach at least 0.5 modules below its reference line before the tip round begins.
- On parallel axes the angles of both members must be opposite.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from .field_limits import LIMITS, MIN_FLANK_DEPTH_MODULES, Fault, base_pitch_fault
from .member import MODIFICATIONS, Member
from .model import NORMAL_MATCH_TOLERANCE, PARALLEL_AXES_SINE, Errors, MeshErrors, Pair
from .modification import kinds_of, length_of
from .written_numbers import IN_RADIANS, refused

MAX_OFFSET_ERROR_MODULES = 10.0
"""Largest offset error in a file, in modules; this is several times the tooth depth."""
MIN_TIP_HEIGHT_MODULES = 0.1
"""Least tip height (addendum plus tip alteration) of a member in a file, in modules."""
NORMAL_MARGIN_RAD = math.radians(1.0)
"""Least difference of the local pressure angle from the angle at which the radial normal vanishes, rad."""


def in_degrees(angle: Any) -> float:
    """Return an angle in deg for a message, without the rounding error of the conversion to rad and back."""
    return float(f"{math.degrees(angle):.6g}")


def outside(table: str, key: str, limit: str, value: object, cure: str) -> Fault:
    """Return the fault of a key whose value is outside its limit, such as 'be between 0 and 1 mm'."""
    return Fault(table, key, refused(limit, value, cure))


def parabola_limit(member: Member) -> float:
    """Return the largest magnitude of the parabola coefficient with which `member` can be cut, 1/mm.

    Let l0 be the distance of the apex from the reference line of the tool along the flank. Up to the height
    h = max(tip height, dedendum) m_n + |l0| cos(alpha) on both sides of the apex, the local pressure angle
    alpha - tau with tan(tau) = 2 a l must stay 1 deg above the angle at which the radial component of the
    normal of the rack vanishes, atan(sin|beta| tan|gamma|), and below 60 deg; the rack profile folds at 90
    deg. With l = tan(tau)/(2 a) and l cos(alpha) + a l^2 sin(alpha) = h, the coefficient is

        a = tan(tau) (cos(alpha) + tan(tau) sin(alpha)/2) / (2 h).

    The equations do not change if a, l and h change sign together, so that one limit holds for concave and
    convex flanks. The result is not positive if the cone is too steep for any tool of this pressure angle."""
    max_local_pressure_angle = math.radians(60.0)
    tool = member.tool
    alpha = float(tool.normal_pressure_angle)
    height = _tool_height(member) + abs(float(tool.parabola_apex)) * math.cos(alpha)
    lowest = math.atan(abs(math.sin(member.helix_angle) * math.tan(member.cone_angle))) + NORMAL_MARGIN_RAD
    low, high = (
        bend * (math.cos(alpha) + 0.5 * bend * math.sin(alpha)) / (2.0 * height)
        for bend in (math.tan(alpha - lowest), math.tan(alpha - max_local_pressure_angle))
    )
    return min(low, -high)


def _tool_height(member: Member) -> float:
    """Return the height of the profile of the tool above or below its reference line, the larger one, mm."""
    return float(member.tool.normal_module) * max(float(member.tip_height), float(member.tool.dedendum))


def tip_cone_radius_at_mid_face(member: Member) -> float:
    """Return the radius of the tip cone of a single member at mid-face, mm."""
    modules = 0.5 * member.teeth / math.cos(member.helix_angle) + member.profile_shift + member.tip_height
    return float(member.tool.normal_module * modules)


def member_faults(name: str, member: Member) -> Iterator[Fault]:
    """Yield faults of combinations of keys of one member."""
    tool, alpha = member.tool, float(member.tool.normal_pressure_angle)
    most, reach = parabola_limit(member), _tool_height(member) / math.cos(alpha)
    if most <= 0.0:
        steepest = in_degrees(
            math.atan(math.tan(alpha - NORMAL_MARGIN_RAD) / abs(math.sin(member.helix_angle)))
        )
        limit = f"be between -{steepest} and {steepest} deg at this helix and pressure angle"
        cure = "the tool cannot generate one of the flanks, increase the pressure angle"
        yield outside(name, "cone_angle_deg", limit, in_degrees(member.cone_angle), cure)
    elif abs(float(tool.parabola_apex)) > reach:
        cure = "measure it along the flank of the tool, from the reference line"
        limit = f"be between -{reach:.4g} and {reach:.4g} mm"
        yield outside(name, "parabola_apex", limit, tool.parabola_apex, cure)
    else:
        for key, parabola in tool.parabolas.items():
            if abs(float(parabola)) > most:
                cure = "a larger coefficient folds the rack profile, usual values are 0.0001 to 0.01"
                yield outside(name, key, f"be between -{most:.4g} and {most:.4g} 1/mm", parabola, cure)

    largest = (float(tool.dedendum) - MIN_FLANK_DEPTH_MODULES) / (1.0 - math.sin(alpha))
    if float(tool.tip_radius) > largest and float(tool.dedendum) < float(tool.addendum):
        least = MIN_FLANK_DEPTH_MODULES + float(tool.tip_radius) * (1.0 - math.sin(alpha))
        cure = f"it is less than the addendum, {float(tool.addendum):g}, usual is 1.25"
        limit = f"be at least {math.ceil(1e3 * least) / 1e3:g} with this tip_radius"
        yield outside(name, "dedendum", limit, tool.dedendum, cure)
    elif float(tool.tip_radius) > largest:
        cure = "a larger tip round leaves no flank, the unit is the normal module, not mm"
        yield outside(name, "tip_radius", f"be at most {largest:.4g} at this dedendum", tool.tip_radius, cure)
    if float(member.tip_height) < MIN_TIP_HEIGHT_MODULES:
        limit = f"leave the tip at least {MIN_TIP_HEIGHT_MODULES:g} modules above the shifted pitch cone"
        cure = f"increase it or the tip diameter, the addendum is {float(tool.addendum):g}"
        yield outside(name, "tip_alteration", limit, float(f"{member.tip_alteration:.6g}"), cure)
    taper = 0.5 * member.face_width * abs(math.tan(member.cone_angle))
    if (radius := tip_cone_radius_at_mid_face(member) - float(taper)) <= 0.0:
        limit = "leave a radius of the tip cone above 0 mm at the small end of the face"
        cure = "use a narrower face or a smaller cone angle"
        yield outside(name, "face_width", limit, float(f"{radius:.6g}"), cure)
    yield from modification_faults(name, member)


def modification_faults(name: str, member: Member) -> Iterator[Fault]:
    """Yield faults of amounts thicker than the tooth, and of lengths longer than the flank."""
    tool = member.tool
    thickness = 0.5e3 * math.pi * float(tool.normal_module)
    start = float(tool.dedendum) - float(tool.tip_radius) * (1.0 - math.sin(tool.normal_pressure_angle))
    depth = float(tool.normal_module) * (start + float(member.tip_height))
    longest = {"profile": depth / math.cos(tool.normal_pressure_angle), "face": float(member.face_width)}
    given = {flank: member.modification(flank) for flank in MODIFICATIONS}
    same = given["right"] == given["left"]
    for flank, one in given.items():
        if one is None or (same and flank == "left"):
            continue
        table = f"{name}.modification" + ("" if same else f".{flank}")
        for key, row in kinds_of(type(one)).items():
            if abs(amount := float(getattr(one, key))) > thickness:
                limit = f"be between {-thickness:.4g} and {thickness:.4g} um, the thickness of the tooth"
                yield outside(table, key, limit, amount, "give it in um")
            if not row.has_length or (length := getattr(one, length_of(key))) is None:
                continue
            direction = "face" if row.profile == "active" else "profile"
            if float(length) > longest[direction]:
                limit = (
                    f"be at most {longest[direction]:.4g} mm, the length of the flank along the {direction}"
                )
                yield outside(table, length_of(key), limit, length, "shorten it, or use a crowning")


def mesh_faults(pinion: Member, gear: Member) -> Iterator[Fault]:
    """Yield the fault of members with different base pitches."""
    relative_tolerance = 1e-9
    first, second = (m.tool.normal_module * math.cos(m.tool.normal_pressure_angle) for m in (pinion, gear))
    if fault := base_pitch_fault((first, second), relative_tolerance, "_deg", "gear", "[pinion]"):
        yield fault


def offset_error_faults(pinion: Member, errors: Errors) -> Iterator[Fault]:
    """Yield the fault of an offset error that separates the teeth."""
    yield from _distance_faults("offset", pinion, errors.offset, "it is added to the offset")


def _distance_faults(key: str, pinion: Member, error: Any, cure: str) -> Iterator[Fault]:
    """Yield the fault of an error of a distance above MAX_OFFSET_ERROR_MODULES."""
    if abs(float(error)) > (most := MAX_OFFSET_ERROR_MODULES * float(pinion.tool.normal_module)):
        limit = f"be between -{most:g} and {most:g} mm ({MAX_OFFSET_ERROR_MODULES:g} modules)"
        yield outside("errors", key, limit, error, f"{cure}, it does not replace it")


def parallel_faults(pinion: Member, gear: Member, pair: Pair) -> Iterator[Fault]:
    """Yield faults of members that do not fit each other on parallel axes.

    Flanks on parallel axes have a common normal only if the axial components of their normals are opposite,
    on right and on left flanks. Therefore sin(alpha) sin(gamma) and cos(alpha) sin(beta) cos(gamma) of both
    members must cancel. Conical gears, and helical gears with parabolas, also need equal pressure angles."""
    if abs(math.sin(pair.shaft_angle)) > PARALLEL_AXES_SINE:
        return
    alphas, cones, helices = (
        tuple(float(getattr(part, name)) for part in parts)
        for parts, name in (
            ((pinion.tool, gear.tool), "normal_pressure_angle"),
            ((pinion, gear), "cone_angle"),
            ((pinion, gear), "helix_angle"),
        )
    )
    parabolic_helical = any(member.tool.has_parabola for member in (pinion, gear)) and any(helices)
    if abs(alphas[0] - alphas[1]) > NORMAL_MATCH_TOLERANCE and (any(cones) or parabolic_helical):
        cure = "on parallel axes conical gears and helical gears with parabolas need equal pressure angles"
        limit = f"equal that of [pinion], {in_degrees(alphas[0])} deg"
        yield outside("gear", "normal_pressure_angle_deg", limit, in_degrees(alphas[1]), cure)
        return
    cone = -math.asin(math.sin(alphas[0]) * math.sin(cones[0]) / math.sin(alphas[1]))
    lean = math.cos(alphas[0]) * math.sin(helices[0]) * math.cos(cones[0])
    helix = -math.asin(lean / (math.cos(alphas[1]) * math.cos(cone)))
    requirements = (
        ("helix_angle_deg", helix, helices[1], "on parallel axes base helix angles must be opposite"),
        ("cone_angle_deg", cone, cones[1], "on parallel axes the cone angles must be opposite"),
    )
    for key, required, given, cure in requirements:
        if abs(required - given) > NORMAL_MATCH_TOLERANCE:
            limit = f"be {in_degrees(required)} deg, opposite to that of [pinion]"
            if key == "helix_angle_deg" and required * given < 0.0:
                cure = "on parallel axes the members must have opposite hands"
            yield outside("gear", key, limit, in_degrees(given), cure)


def given_at_mesh_faults(pinion: Member, pair: Pair, errors: MeshErrors) -> Iterator[Fault]:
    """Yield faults of errors at the mesh that separate the teeth or tilt the axes beyond parallel."""
    cure = "it is added to the centre distance"
    yield from _distance_faults("centre_distance", pinion, errors.centre_distance, cure)
    shaft = float(pair.shaft_angle)
    if shaft > 0.0 and float(errors.in_plane) < -shaft:
        cure = "a lower value turns the axes past parallel"
        yield outside(
            "errors",
            "in_plane_deg",
            f"be at least {-in_degrees(shaft)} deg",
            in_degrees(errors.in_plane),
            cure,
        )


def mesh_error_faults(pinion: Member, errors: Errors) -> Iterator[Fault]:
    """Yield faults of errors at the mesh whose equivalent `errors` about the common perpendicular are too
    large."""
    given = vars(errors)
    if any(math.isnan(value) for value in given.values()):
        nowhere = 'cannot be "mesh", as flanks without common normal have no pitch point: use "perpendicular"'
        yield Fault("errors", "at", nowhere)
        return
    faults = [*offset_error_faults(pinion, errors)]
    for name, limit in LIMITS["Errors"].items():
        angle = limit.unit == "deg"
        value = in_degrees(given[name]) if angle else float(f"{given[name]:.6g}")
        if text := limit.fault(value):
            faults.append(Fault("errors", f"{name}_deg" if angle else name, text))
    for fault in faults:
        key = f'with at = "mesh", the equivalent {fault.key} about the common perpendicular'
        yield Fault("errors", key, fault.text)


def radian_faults(pinion: Member, gear: Member, pair: Pair) -> Iterator[Fault]:
    """Yield faults of angles within their limits that fit together only if some were given in rad."""
    keys = (
        *(("pinion", "helix_angle_deg"), ("gear", "helix_angle_deg"), ("pair", "shaft_angle_deg")),
        *(("pinion", "cone_angle_deg"), ("gear", "cone_angle_deg")),
    )
    given = (
        *(float(pinion.helix_angle), float(gear.helix_angle), float(pair.shaft_angle)),
        *(float(pinion.cone_angle), float(gear.cone_angle)),
    )
    scale = 180.0 / math.pi
    # Factors of the angles in the order of `keys`; the first reading is the design as it is.
    readings = (
        *((1, 1, 1, 1, 1), (1, 1, scale, 1, 1), (scale, scale, 1, 1, 1), (scale, 1, 1, 1, 1)),
        *((1, scale, 1, 1, 1), (1, 1, 1, scale, scale)),
    )
    for factors in readings:
        first, second, shaft, *cones = (angle * factor for angle, factor in zip(given, factors, strict=True))
        # Shaft angle that fits the reference cones and tooth traces; the working ones are close to them.
        cosine = math.cos(cones[0]) * math.cos(cones[1]) * math.cos(first + second)
        fitting = math.acos(min(1.0, cosine - math.sin(cones[0]) * math.sin(cones[1])))
        tolerance = 0.2 if factors == readings[0] else 0.1
        if max(map(abs, (first, second, shaft, *cones))) < 1.6 and abs(shaft - fitting) < tolerance * fitting:
            for (table, key), angle, factor in zip(keys, given, factors, strict=True):
                if factor > 1.0 and angle != 0.0:
                    limit = f"be about {math.degrees(angle * factor):.3g} deg to fit the other angles"
                    yield outside(table, key, limit, in_degrees(angle), IN_RADIANS)
            return
