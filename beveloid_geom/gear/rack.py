"""The generating rack: parabolic profile, normal section, and position at the gear (Eqs. 1-5).

The flank of the tool is a parabola in its normal section. In the frame S_a at its apex (Eq. 1),
x_a = l points along the straight flank towards the tip of the generated tooth, and y_a = a l^2
along the normal of the straight flank, out of the generated tooth. In the paper, the apex is on the
reference line, half a normal space width s0 / 2 = pi m_n / 4 from the middle of the generated tooth.
Here, it may be moved by l0 along the straight flank (`parabola_apex`), so that l + l0 is the distance
from the reference line, and a is the coefficient of this flank. In S_n, x_n points from the root of
the generated tooth to its tip and y_n across the tooth:

    x_n = (l + l0) cos(alpha) + a l^2 sin(alpha)
    y_n = sigma (a l^2 cos(alpha) - (l + l0) sin(alpha) + s0 / 2),

with sigma = +1 on the right flank and -1 on the left flank (Eqs. 2, 3). The section is rotated by
the helix angle about x and tilted by the cone angle about y (Eq. 4); `u` is measured along the
tooth trace from the section at mid-face. With unit vectors d along the straight flank, m along
its normal and t along the trace, and with the apex p, the rack is

    R(l, u) = p + l d + a l^2 m + u t,    n(l) = (m - 2 a l d) / sqrt(1 + 4 a^2 l^2).

Difference from the paper: Eq. 4 contains no profile shift. The paper moves the gear axially by
b_c = x m_n / tan(gamma), which diverges for cylindrical gears. Here the shift moves the rack
radially by x m_n at mid-face. Because the rack is tilted, both give the same surface, rotated by
-b_c tan(beta) / (cos(gamma) r_P) about the gear axis.

Vectors have their components on the leading axis, (3, ...), so that each component is contiguous.
The public functions of other modules return points (..., 3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Quantity, flank_sign
from ..design.member import Member, Tool
from ..support.frozen_arrays import read_only

Numbers: TypeAlias = NDArray[Any]
"""Real or complex array; derivatives are computed by complex steps."""


@dataclass(frozen=True, eq=False)
class Rack:
    """Flank of the rack at its gear, in S_c: x radial from the pitch line, y along the sliding, z axial.

    Vectors (3, ...): `apex` p in mm; unit vectors `direction` d, `normal` m and `trace` t. `parabola`
    is a in 1/mm, `pitch_radius` r_P in mm, and `sigma` is +1 on right and -1 on left flanks.
    """

    apex: FloatArray
    direction: FloatArray
    normal: FloatArray
    trace: FloatArray
    parabola: Quantity
    pitch_radius: Quantity
    sigma: float

    def pick(self, index: Any) -> Rack:
        """Return the racks at an index of the arrays."""
        each = (slice(None), *index)
        return Rack(
            apex=self.apex[each],
            direction=self.direction[each],
            normal=self.normal[each],
            trace=self.trace[each],
            parabola=np.asarray(self.parabola)[index],
            pitch_radius=np.asarray(self.pitch_radius)[index],
            sigma=self.sigma,
        )

    @cached_property
    def parts(self) -> tuple[Rack, ...]:
        """Racks of stacked members, one by one."""
        return read_only(tuple(self.pick((member,)) for member in range(self.apex.shape[1])))


def reference_radius(member: Member) -> Quantity:
    """Return the reference pitch radius r_P = m_n N / (2 cos beta), mm."""
    return member.tool.normal_module * member.teeth / (2.0 * np.cos(member.helix_angle))


def section_point(tool: Tool, flank: str, l: FloatArray) -> FloatArray:
    """Return points (..., 2) of the tool flank in its normal section, (x_n, y_n) (Eqs. 1-3), mm."""
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    bend, straight = tool.parabola_of(flank) * l * l, l + tool.parabola_apex
    across = bend * cos - straight * sin + 0.25 * np.pi * tool.normal_module
    return np.stack((straight * cos + bend * sin, flank_sign(flank) * across), axis=-1)


def section_frame(member: Member) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the frame S_n of the normal section of the tool in S_c (Eq. 4).

    Parameters
    ----------
    member : Member

    Returns
    -------
    tuple of ndarray, shape (3, ...)
        Origin, mm, and unit vectors along x_n and y_n.
    """
    sin_beta, cos_beta = np.sin(member.helix_angle), np.cos(member.helix_angle)
    sin_gamma, cos_gamma = np.sin(member.cone_angle), np.cos(member.cone_angle)
    origin = _vector(member.profile_shift * np.asarray(member.tool.normal_module), 0.0, 0.0)
    along = _vector(cos_gamma, 0.0, -sin_gamma)
    across = _vector(-sin_gamma * sin_beta, cos_beta, -cos_gamma * sin_beta)
    return origin, along, across


def rack_of(member: Member, flank: str) -> Rack:
    """Return the rack that generates `flank` ('right' or 'left') of `member` (Eqs. 3, 4)."""
    tool, sigma = member.tool, flank_sign(flank)
    sin_alpha, cos_alpha = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    sin_beta, cos_beta = np.sin(member.helix_angle), np.cos(member.helix_angle)
    sin_gamma, cos_gamma = np.sin(member.cone_angle), np.cos(member.cone_angle)
    origin, along, across = section_frame(member)
    direction = cos_alpha * along - sigma * sin_alpha * across
    on_reference_line = origin + (sigma * 0.25 * np.pi) * tool.normal_module * across
    moved = np.asarray(tool.parabola_apex)
    return Rack(
        apex=_against(on_reference_line, moved) + moved * _against(direction, moved),
        direction=direction,
        normal=sin_alpha * along + sigma * cos_alpha * across,
        trace=_vector(cos_beta * sin_gamma, sin_beta, cos_beta * cos_gamma),
        parabola=tool.parabola_of(flank),
        pitch_radius=reference_radius(member),
        sigma=sigma,
    )


def _vector(x: Quantity, y: Quantity, z: Quantity) -> FloatArray:
    vector = np.empty((3, *np.shape(x + y + z)))
    vector[0], vector[1], vector[2] = x, y, z
    return vector


def _against(vector: FloatArray, values: Numbers) -> FloatArray:
    """Return the vectors (3, ...) with axes inserted after the first one, to broadcast with `values`."""
    missing = values.ndim + 1 - vector.ndim
    return vector if missing <= 0 else vector.reshape(3, *[1] * missing, *vector.shape[1:])


def rack_point(rack: Rack, l: Numbers) -> Numbers:
    """Return points (3, ...) of the rack in S_c at `u = 0` (Eq. 4), mm."""
    return _point(rack, l, rack_tangent(rack, l))


def rack_normal(rack: Rack, l: Numbers) -> Numbers:
    """Return the unit normals (3, ...) of the rack in S_c (Eq. 5), out of the gear tooth."""
    return _normal(rack, 2.0 * rack.parabola * l)


def rack_tangent(rack: Rack, l: Numbers) -> Numbers:
    """Return the derivative (3, ...) of the rack point by `l`. It is perpendicular to normal and trace, and
    not of unit length.
    """
    return _tangent(rack, 2.0 * rack.parabola * l)


def rack_at(rack: Rack, l: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return `rack_normal`, `rack_point` and `rack_tangent` (3, ...) of the rack at `l`."""
    bend = 2.0 * rack.parabola * l
    tangent = _tangent(rack, bend)
    return _normal(rack, bend), _point(rack, l, tangent), tangent


def turn_rate(rack: Rack, l: Numbers) -> Numbers:
    """Return the factor (...) of the tangent T in the derivative of the unit normal by `l`.

    The normal rotates against the tangent: n' = -2 a T / |T|^3 with |T|^2 = 1 + 4 a^2 l^2."""
    return np.asarray(-2.0 * rack.parabola / (1.0 + (2.0 * rack.parabola * l) ** 2) ** 1.5)


def _normal(rack: Rack, bend: Numbers) -> Numbers:
    """Return the unit normals where the profile is rotated by atan(`bend`), bend = 2 a l."""
    return (_against(rack.normal, bend) - bend * _against(rack.direction, bend)) / np.sqrt(1.0 + bend * bend)


def _tangent(rack: Rack, bend: Numbers) -> Numbers:
    return _against(rack.direction, bend) + bend * _against(rack.normal, bend)


def _point(rack: Rack, l: Numbers, tangent: Numbers) -> Numbers:
    """Return the points at `l`. Along a parabola, the mean slope from the apex is the slope at half of l."""
    middle = 0.5 * (_against(rack.direction, tangent[0]) + tangent)
    return _against(rack.apex, tangent[0]) + l * middle


def parameter_at_height(tool: Tool, flank: str, height: Quantity) -> FloatArray:
    """Return the flank parameter `l` at which a flank of the tool has x_n = `height` (mm).

    NaN if the parabola is so strong that the profile folds between the apex and this height.
    """
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    height = height - tool.parabola_apex * cos  # from the apex
    with np.errstate(invalid="ignore"):
        root = np.sqrt(cos**2 + 4.0 * np.asarray(tool.parabola_of(flank)) * sin * height)
    return np.asarray(2.0 * height / (cos + root))
