"""Teeth computed from the section of the tool, and first contacts by sampling.

It shares no code with the package, except the layout of the pair and the spline of measured deviations. Flank
and fillet are points of the tool that cut in planes z (Eqs. 4-6). The smallest angle by which the gear may
turn is found on a grid over flank and fillet, which is narrowed around its lowest points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from beveloid_geom import Design, Member
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.pair.mounting import mounting_of

from .bracketed import EPSILON, roots_between
from .modified_flank import base_radius, depth

ZOOMS, NARROWER = 24, 0.35
"""Number of times that a grid is moved or narrowed, and the factor by which it is narrowed."""
CUT_AWAY = 1e-12
"""rad that a point may lie above the material left by the tool and count as part of the tooth."""


@dataclass(frozen=True)
class Tooth:
    """Flank with its fillet, not undercut; `sign` 1 for the right side. Profile coordinate w: 0 to 1 along
    the fillet, then flank parameter in mm."""

    member: Member
    sign: float

    @cached_property
    def joint(self) -> float:
        """Return the flank parameter of the joint with the fillet."""
        tool = self.member.tool
        alpha, a, m = tool.normal_pressure_angle, tool.parabola, float(tool.normal_module)

        def apart(l: float) -> float:
            up = l * np.cos(alpha) + a * l * l * np.sin(alpha) + tool.dedendum * m
            return float(up - tool.tip_radius * m * (1.0 - np.sin(alpha - np.arctan(2.0 * a * l))))

        return float(brentq(apart, -1.5 * m, -0.3 * m, xtol=1e-15))

    def _section(self, w: FloatArray) -> tuple[FloatArray, ...]:
        """Return points of the tool's normal section and the angles of their normals."""
        tool = self.member.tool
        alpha, a, m = tool.normal_pressure_angle, tool.parabola, tool.normal_module

        def flank(l: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            x = l * np.cos(alpha) + a * l * l * np.sin(alpha)
            y = a * l * l * np.cos(alpha) - l * np.sin(alpha) + 0.25 * np.pi * m
            return x, y, alpha - np.arctan(2.0 * a * l)

        x, y, angle = flank(self.joint + np.maximum(w - 1.0, 0.0))
        x0, y0, angle0 = flank(np.asarray(self.joint))
        radius, turned = tool.tip_radius * m, 0.5 * np.pi + (angle0 - 0.5 * np.pi) * np.minimum(w, 1.0)
        x_round = x0 + radius * (np.sin(angle0) - np.sin(turned))
        y_round = y0 + radius * (np.cos(angle0) - np.cos(turned))
        low = w < 1.0
        return np.where(low, x_round, x), np.where(low, y_round, y), np.where(low, turned, angle)

    @cached_property
    def _placed(self) -> FloatArray:
        """Return the rotation of the tool by helix and cone angle."""
        beta, gamma = self.member.helix_angle, self.member.cone_angle
        turn = np.array([[1, 0, 0], [0, np.cos(beta), np.sin(beta)], [0, -np.sin(beta), np.cos(beta)]])
        tilt = np.array([[np.cos(gamma), 0, np.sin(gamma)], [0, 1, 0], [-np.sin(gamma), 0, np.cos(gamma)]])
        return np.asarray(tilt @ turn)

    def _in_plane(self, w: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return points of the tool in the planes z, and the slopes of their normals."""
        x, y, angle = self._section(w)
        turned, zero = self._placed, 0.0 * x
        point = np.tensordot(turned, np.stack((x, self.sign * y, zero)), 1)
        normal = np.tensordot(turned[:2], np.stack((np.sin(angle), self.sign * np.cos(angle), zero)), 1)
        along = (z - point[2]) / turned[2, 2]
        shift = self.member.profile_shift * self.member.tool.normal_module
        return point[0] + along * turned[0, 2] + shift, point[1] + along * turned[1, 2], normal[1] / normal[0]

    @property
    def _pitch_radius(self) -> FloatArray:
        return 0.5 * self.member.tool.normal_module * self.member.teeth / np.cos(self.member.helix_angle)

    def radius(self, w: FloatArray, z: FloatArray) -> FloatArray:
        """Return the distance from the axis in the planes z."""
        x, _, slope = self._in_plane(w, z)
        return np.hypot(self._pitch_radius + x, slope * x)

    def polar(self, w: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return radius and angle about the axis in the planes z (Eqs. 4-6)."""
        (x, y, slope), pitch_radius = self._in_plane(w, z), self._pitch_radius
        phi = (y - slope * x) / pitch_radius
        generated = phi + np.arctan2(slope * x, pitch_radius + x)
        return np.hypot(pitch_radius + x, slope * x), generated - self.sign * self._removed(w, z)

    def _removed(self, w: FloatArray, z: FloatArray) -> FloatArray:
        """Return the rotation by the modification: depth over base radius."""
        member = self.member
        given = member.modification_right if self.sign > 0.0 else member.modification_left
        if given is None:
            return 0.0 * (w + z)
        l = self.joint + np.maximum(w - 1.0, 0.0)
        removed = depth(member, self.sign, l, z) / base_radius(member, self.sign)
        if given.deviations is None:
            return np.asarray(removed)
        tool, flank = member.tool, "right" if self.sign > 0.0 else "left"
        lever = 0.5 * tool.normal_module * member.teeth * np.cos(tool.normal_pressure_angle)
        return np.asarray(removed - 1e-3 * given.deviations.shape(flank)(l, z)[0] / lever)

    def tip(self, z: FloatArray) -> FloatArray:
        """Return the radius of the tip cone."""
        tool, member = self.member.tool, self.member
        height = member.profile_shift + tool.addendum + member.tip_alteration
        return np.asarray(self._pitch_radius + height * tool.normal_module + z * np.tan(member.cone_angle))

    def lowest(self, z: FloatArray) -> FloatArray:
        """Return w at the lowest point of the flank."""
        return np.ones_like(z)

    def profile(self, radius: FloatArray, z: FloatArray) -> FloatArray:
        """Return w at a radius; NaN without a point."""
        low = np.zeros_like(radius)
        high = np.full_like(radius, 1.0 + 2.4 * float(self.member.tool.normal_module))
        return roots_between(lambda w: self.radius(w, z) - radius, low, high, EPSILON * radius)

    def angle_at(self, radius: FloatArray, z: FloatArray) -> FloatArray:
        """Return the angle of the tooth at radii."""
        return self.polar(self.profile(radius, z), z)[1]

    def remains(self, radius: FloatArray, angle: FloatArray, z: FloatArray, spare: float) -> Mask:
        """Return the mask of points of flank or fillet that are part of the tooth."""
        return np.ones(radius.shape, dtype=bool)


@dataclass(frozen=True)
class CutTooth(Tooth):
    """Tooth without parabola, undercut or not: at a radius, flank or fillet, whichever cuts deeper."""

    def _slopes(self, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x of the joint in the planes z, the slope of the normal, and x per mm of w."""
        start, _, slope = self._in_plane(np.ones_like(z), z)
        return start, slope, self._in_plane(np.full_like(z, 2.0), z)[0] - start

    def lowest(self, z: FloatArray) -> FloatArray:
        """Return w of the joint, or where the radius no longer decreases along the flank."""
        start, slope, rate = self._slopes(z)
        return np.maximum(1.0 + (-self._pitch_radius / (1.0 + slope * slope) - start) / rate, 1.0)

    def profile(self, radius: FloatArray, z: FloatArray) -> FloatArray:
        """Return w of the flank at a radius, outside the base cylinder; NaN inside."""
        (start, slope, rate), r = self._slopes(z), self._pitch_radius
        spread = 1.0 + slope * slope
        with np.errstate(invalid="ignore"):
            x = (np.sqrt(r * r - spread * (r * r - radius * radius)) - r) / spread
        return np.asarray(1.0 + (x - start) / rate)

    def angle_at(self, radius: FloatArray, z: FloatArray) -> FloatArray:
        """Return the angle of the tooth at radii."""
        on_flank = self.profile(radius, z)
        flank = np.where(on_flank >= 1.0, self.polar(on_flank, z)[1], np.nan)
        low, high = np.zeros_like(z), np.ones_like(z)
        on_fillet = roots_between(lambda w: self.radius(w, z) - radius, low, high, EPSILON * radius)
        return np.asarray(self.sign * np.fmin(self.sign * flank, self.sign * self.polar(on_fillet, z)[1]))

    def remains(self, radius: FloatArray, angle: FloatArray, z: FloatArray, spare: float) -> Mask:
        """Return the mask of points that the tool does not cut away."""
        return np.asarray(self.sign * (angle - self.angle_at(radius, z)) <= spare)


def seen_from_gear(
    design: Design, radius: FloatArray, angle: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y, z in the fixed frame of the gear, from mid-face, of points of the rolled pinion."""
    errors, distance = design.errors, mounting_of(design).distance
    hand = np.sign(design.pinion.helix_angle + design.gear.helix_angle) or np.sign(design.pinion.helix_angle)
    turn = hand * (design.pair.shaft_angle + errors.shaft_angle)
    y, along = radius * np.sin(angle), z + distance[0] + errors.pinion_axial
    # The gear's axis (0, sin, cos), and k2 x (-x).
    return (
        design.pair.offset + errors.offset - radius * np.cos(angle),
        np.sin(turn) * along - np.cos(turn) * y,
        np.sin(turn) * y + np.cos(turn) * along - distance[1] - errors.gear_axial,
    )


def clearance(
    design: Design,
    flank: str,
    w: FloatArray,
    z: FloatArray,
    rolls: tuple[float, float],
    kind: type[Tooth] = Tooth,
    spare: float = CUT_AWAY,
) -> FloatArray:
    """Return the rotation (rad) of the gear until it touches points (w, z) of the pinion, infinite without
    a point within its limits, and where the tool cuts the points away by more than `spare`, rad."""
    sign = 1.0 if flank == "right" else -1.0
    pinion, gear = (kind(member, sign) for member in design.members)
    radius, theta = pinion.polar(w, z)
    x, y, height = seen_from_gear(design, radius, theta + rolls[0], z)
    reach = np.hypot(x, y)
    slack = max(1e-9, 2.5e-10 * float(gear.member.tool.normal_module))
    inside = (np.abs(height) <= 0.5 * gear.member.face_width + slack) & (reach <= gear.tip(height) + slack)
    inside[inside] = pinion.remains(radius[inside], theta[inside], z[inside], spare)
    gap = np.full(reach.shape, np.inf)
    turn = np.arctan2(y, x)[inside] - gear.angle_at(reach[inside], height[inside]) - rolls[1]
    gap[inside] = sign * (np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi)
    return np.where(np.isnan(gap), np.inf, gap)


def least_turn(
    design: Design, flank: str, rolls: tuple[float, float], count: tuple[int, int], kind: type[Tooth] = Tooth
) -> float:
    """Return the least angle (rad) by which the gear may turn towards the pinion, over flank and fillet, from
    a grid that is narrowed around its lowest points."""
    pinion = kind(design.pinion, 1.0 if flank == "right" else -1.0)
    half = 0.5 * float(design.pinion.face_width)
    u, v = np.meshgrid(np.linspace(0.0, 1.0, count[0]), np.linspace(-1.0, 1.0, count[1]), indexing="ij")

    def placed(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        z = half * v
        low, top = pinion.lowest(z), pinion.profile(pinion.tip(z), z)
        return np.where(u < 0.25, 4.0 * u, low + (u - 0.25) / 0.75 * (top - low)), z

    gap = clearance(design, flank, *placed(u.ravel(), v.ravel()), rolls, kind).reshape(u.shape)
    padded = np.pad(gap, 1, constant_values=np.inf)
    around = np.min(
        [padded[i : i + u.shape[0], j : j + u.shape[1]] for i in range(3) for j in range(3)], axis=0
    )
    best = np.inf
    for i, j in np.argwhere((gap <= around) & (gap <= gap.min() + 1e-3) & np.isfinite(gap)):
        at, least = np.array((u[i, j], v[i, j])), gap[i, j]
        width = np.array((1.0 / count[0], 2.0 / count[1]))
        offsets = np.stack(np.meshgrid(np.linspace(-1.0, 1.0, 9), np.linspace(-1.0, 1.0, 9)), axis=-1)
        for _ in range(ZOOMS):
            places = at + width * offsets.reshape(-1, 2)
            places = np.clip(places, (1e-3, -1.0), (1.0, 1.0))
            found = clearance(design, flank, *placed(*places.T), rolls, kind)
            k = int(found.argmin())
            if found[k] < least:
                at, least = places[k], found[k]
            else:
                width = NARROWER * width
        best = min(best, least)
    return float(best)
