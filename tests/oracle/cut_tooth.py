"""First contact of teeth, undercut or not, by sampling alone. It shares no code with the package.

A tooth in a plane z is the material left by a tool without parabola: at a radius, the deepest of the points
that its flank and its round cut there (Eqs. 4-6, written anew). Points of the pinion that its own tool cuts
away are left out. The least angle by which the gear may turn is found on grids over flank and round, which
are narrowed around their lowest points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beveloid_geom import Design, Member

from .bracketed import EPSILON, roots_between

Array = NDArray[np.float64]
ZOOMS, SHRUNK, FOLLOWED = 40, 0.5, 3
"""Number of times that a grid is moved or narrowed, share to which it is narrowed, grids for each part."""
CUT_AWAY = 1e-12
"""rad that a point may lie above the material left by the tool and count as part of the tooth."""


@dataclass(frozen=True)
class CutTooth:
    """One side of a tooth without parabola; `sign` 1 for the right side. Flank points are given by mm along
    the tool's flank, points of the round by the angle of the tool's normal."""

    member: Member
    sign: float

    @property
    def joint(self) -> float:
        """Return the place on the tool's flank at which its round touches, mm."""
        tool = self.member.tool
        alpha = float(tool.normal_pressure_angle)
        depth = float(tool.tip_radius) * (1.0 - np.sin(alpha)) - float(tool.dedendum)
        return float(depth * tool.normal_module / np.cos(alpha))

    def _cut(self, x: Array, y: Array, angle: Array, z: Array) -> tuple[Array, Array, Array]:
        """Return x_c, the slope n_y / n_x and the roll of points of the tool that cut in the planes z."""
        member, m = self.member, float(self.member.tool.normal_module)
        beta, gamma = float(member.helix_angle), float(member.cone_angle)
        turn = np.array([[1, 0, 0], [0, np.cos(beta), np.sin(beta)], [0, -np.sin(beta), np.cos(beta)]])
        tilt = np.array([[np.cos(gamma), 0, np.sin(gamma)], [0, 1, 0], [-np.sin(gamma), 0, np.cos(gamma)]])
        a, b, c = (tilt @ turn).T
        nx, ny = (np.sin(angle) * a[k] + self.sign * np.cos(angle) * b[k] for k in (0, 1))
        along = (z - x * a[2] - self.sign * y * b[2]) / c[2]
        x, y = (x * a[k] + self.sign * y * b[k] + along * c[k] for k in (0, 1))
        x = x + member.profile_shift * m
        return x, ny / nx, (y - ny / nx * x) / self.pitch_radius

    @property
    def pitch_radius(self) -> float:
        """Return the radius of the cylinder on which the tool rolls, mm."""
        return float(
            0.5 * self.member.tool.normal_module * self.member.teeth / np.cos(self.member.helix_angle)
        )

    def _flank(self, l: Array, z: Array) -> tuple[Array, Array, Array]:
        alpha = float(self.member.tool.normal_pressure_angle)
        half = 0.25 * np.pi * float(self.member.tool.normal_module)
        return self._cut(l * np.cos(alpha), half - l * np.sin(alpha), np.full_like(l, alpha), z)

    def _round(self, angle: Array, z: Array) -> tuple[Array, Array, Array]:
        tool = self.member.tool
        alpha, m, l = float(tool.normal_pressure_angle), float(tool.normal_module), self.joint
        radius = float(tool.tip_radius) * m
        x = l * np.cos(alpha) + radius * (np.sin(alpha) - np.sin(angle))
        y = 0.25 * np.pi * m - l * np.sin(alpha) + radius * (np.cos(alpha) - np.cos(angle))
        return self._cut(x, y, angle, z)

    def polar(self, part: str, p: Array, z: Array) -> tuple[Array, Array]:
        """Return radii, and angles about the axis, positive into the metal, of flank or round."""
        x, slope, phi = self._flank(p, z) if part == "flank" else self._round(p, z)
        across = self.pitch_radius + x
        return np.hypot(across, slope * x), -self.sign * (phi + np.arctan2(slope * x, across))

    def tip(self, z: Array) -> Array:
        """Return the radius of the tip cone, mm."""
        member = self.member
        height = member.profile_shift + member.tool.addendum + member.tip_alteration
        return np.asarray(
            self.pitch_radius + height * member.tool.normal_module + z * np.tan(member.cone_angle)
        )

    def on_flank(self, radius: Array, z: Array) -> Array:
        """Return the place on the tool's flank that cuts a radius, outside the base cylinder; NaN inside."""
        zero = np.zeros_like(z)
        start, slope, _ = self._flank(zero, z)
        rate = self._flank(zero + 1.0, z)[0] - start
        r, spread = self.pitch_radius, 1.0 + slope * slope
        with np.errstate(invalid="ignore"):
            x = (np.sqrt(r * r - spread * (r * r - radius * radius)) - r) / spread
        return np.asarray((x - start) / rate)

    def lowest(self, z: Array) -> Array:
        """Return the lowest place of the flank: the joint, or that at which its radius no longer falls."""
        zero = np.zeros_like(z)
        start, slope, _ = self._flank(zero, z)
        rate = self._flank(zero + 1.0, z)[0] - start
        return np.maximum((-self.pitch_radius / (1.0 + slope * slope) - start) / rate, self.joint)

    def surface(self, radius: Array, z: Array) -> Array:
        """Return the angle of the tooth at radii: of flank and round the one that cuts deeper."""
        l = self.on_flank(radius, z)
        flank = np.where(l >= self.joint, self.polar("flank", l, z)[1], np.nan)
        alpha = float(self.member.tool.normal_pressure_angle)
        low, high = np.full_like(z, 0.5 * np.pi), np.full_like(z, alpha)
        turned = roots_between(
            lambda angle: self.polar("round", angle, z)[0] - radius, low, high, EPSILON * radius
        )
        round_ = self.polar("round", turned, z)[1]
        return np.asarray(np.fmax(flank, round_))


def clearance(
    design: Design,
    sign: float,
    part: str,
    place: tuple[Array, Array],
    setting: tuple[float, ...],
    spare: float = CUT_AWAY,
) -> Array:
    """Return angles by which the gear may turn until it meets points of the pinion, infinite where these are
    cut away by more than `spare` rad or not between the gear's ends and below its tips."""
    pinion, gear = (CutTooth(member, sign) for member in design.members)
    (p, z), (pinion_roll, gear_roll, first, second) = place, setting
    radius, inwards = pinion.polar(part, p, z)
    errors, hand = design.errors, 1.0 if design.pinion.helix_angle + design.gear.helix_angle >= 0.0 else -1.0
    angle, theta = hand * (design.pair.shaft_angle + errors.shaft_angle), pinion_roll - sign * inwards
    x, y = radius * np.cos(theta) - design.pair.offset - errors.offset, radius * np.sin(theta)
    along = z + first + errors.pinion_axial
    x, y, height = (
        -x,
        np.sin(angle) * along - np.cos(angle) * y,
        np.sin(angle) * y + np.cos(angle) * along - second - errors.gear_axial,
    )
    reach, gap = np.hypot(x, y), np.full(z.shape, np.inf)
    inside = (np.abs(height) <= 0.5 * gear.member.face_width + 1e-10) & (reach <= gear.tip(height) + 1e-10)
    inside[inside] = inwards[inside] >= pinion.surface(radius[inside], z[inside]) - spare
    turn = np.arctan2(y, x)[inside] + sign * gear.surface(reach[inside], height[inside]) - gear_roll
    gap[inside] = sign * (np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi)
    return np.where(np.isnan(gap), np.inf, gap)


def least_turn(
    design: Design, sign: float, setting: tuple[float, ...], size: tuple[int, int] = (31, 25)
) -> float:
    """Return the least angle (rad) by which the gear may turn towards a tooth of the pinion without parabola;
    `setting`: the rolls of both, and the distances of their mid-faces."""
    pinion, best = CutTooth(design.pinion, sign), np.inf
    half, alpha = 0.5 * float(design.pinion.face_width), float(design.pinion.tool.normal_pressure_angle)
    share, face = np.meshgrid(np.linspace(0.0, 1.0, size[0]), half * np.linspace(-1.0, 1.0, size[1]))
    a, b = (x.ravel() for x in np.meshgrid(np.linspace(-1.0, 1.0, 7), np.linspace(-1.0, 1.0, 7)))
    for part in ("flank", "round"):

        def placed(t: Array, z: Array, part: str = part) -> tuple[Array, Array]:
            if part == "round":
                return 0.5 * np.pi - 0.02 + (alpha - 0.5 * np.pi + 0.02) * t, z
            low = pinion.lowest(z)
            return low + (pinion.on_flank(pinion.tip(z), z) - low) * t, z

        gap = clearance(design, sign, part, placed(share.ravel(), face.ravel()), setting)
        padded = np.pad(gap.reshape(share.shape), 1, constant_values=np.inf)
        rows, columns = share.shape
        around = np.min(
            [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)], axis=0
        ).ravel()
        local = np.flatnonzero((gap <= around) & np.isfinite(gap))
        local = local[np.argsort(gap[local])][:FOLLOWED]
        at, least = np.array((share.ravel()[local], face.ravel()[local])), gap[local]
        width = np.repeat([[1.0 / (size[0] - 1)], [2.0 * half / (size[1] - 1)]], local.size, axis=1)
        each = np.arange(local.size)
        for _ in range(ZOOMS if local.size else 0):
            t = np.clip(at[0][:, None] + a * width[0][:, None], 0.0, 1.0)
            z = np.clip(at[1][:, None] + b * width[1][:, None], -half, half)
            found = clearance(design, sign, part, placed(t.ravel(), z.ravel()), setting).reshape(t.shape)
            k = found.argmin(axis=1)
            lower = found[each, k] < least
            least = np.where(lower, found[each, k], least)
            at = np.where(lower, (t[each, k], z[each, k]), at)
            width = np.where(lower, width, SHRUNK * width)
        best = min([best, *least.tolist()])
    return float(best)
