"""The generating rack: parabolic profile, normal section, and pose at the gear (Eqs. 1-5).

The flank of the tool is a parabola in its normal section, given in the frame S_a at its apex
(Eq. 1): x_a = l along the straight flank towards the tip of the generated tooth, y_a = a l^2
along that flank's normal, out of the generated tooth. The apex stands on the reference line,
half a normal space width s0 / 2 = pi m_n / 4 from the middle of the generated tooth. In S_n,
x_n pointing from the root of the generated tooth to its tip and y_n across it, that is

    x_n = l cos(alpha) + a l^2 sin(alpha)
    y_n = sigma (a l^2 cos(alpha) - l sin(alpha) + s0 / 2),

with sigma = +1 on the right flank and -1 on the left (Eqs. 2, 3). The section is turned by the
helix angle about x and tilted by the cone angle about y, which gives Eq. 4; `u` runs along
the tooth trace from the section at mid-face. With unit vectors d along the straight flank, m
along its normal and t along the trace, and the apex p, the rack is

    R(l, u) = p + l d + a l^2 m + u t,    n(l) = (m - 2 a l d) / sqrt(1 + 4 a^2 l^2).

Difference to the paper: Eq. 4 holds no profile shift; the paper moves the gear axially by
b_c = x m_n / tan(gamma) instead, which diverges for cylindrical gears. Here the shift moves
the rack radially by x m_n at mid-face. Because the rack is tilted both give the same
surface, turned by -b_c tan(beta) / (cos(gamma) r_P) about the gear axis.

Vectors are arrays with the components on the leading axis, (3, ...), unlike the public points
(..., 3) of the other modules: it keeps components contiguous where time is spent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Quantity, flank_sign
from ..design.model import Member, Tool

Numbers: TypeAlias = NDArray[Any]
"""Real or complex array: derivatives are taken by complex steps."""


@dataclass(frozen=True, eq=False)
class Rack:
    """A rack flank at its gear, in S_c (x radial, y along the sliding, z axial), the radial
    coordinate taken from the pitch line. Vectors (3, ...), mm and 1."""

    apex: FloatArray
    direction: FloatArray
    normal: FloatArray
    trace: FloatArray
    parabola: Quantity
    pitch_radius: Quantity
    sigma: float


def reference_radius(member: Member) -> Quantity:
    """Find the reference pitch radius r_P = m_n N / (2 cos beta), mm."""
    return member.tool.normal_module * member.teeth / (2.0 * np.cos(member.helix_angle))


def section_point(tool: Tool, flank: str, l: FloatArray) -> FloatArray:
    """Find points (..., 2) of the tool flank in its normal section, (x_n, y_n) (Eqs. 1-3), mm."""
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    bend = tool.parabola * l * l
    across = bend * cos - l * sin + 0.25 * np.pi * tool.normal_module
    return np.stack((l * cos + bend * sin, flank_sign(flank) * across), axis=-1)


def rack_of(member: Member, flank: str) -> Rack:
    """Give the rack that generates `flank` ('right' or 'left') of `member` (Eqs. 3, 4)."""
    tool, sigma = member.tool, flank_sign(flank)
    sin_alpha, cos_alpha = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    sin_beta, cos_beta = np.sin(member.helix_angle), np.cos(member.helix_angle)
    sin_gamma, cos_gamma = np.sin(member.cone_angle), np.cos(member.cone_angle)
    across = _vector(-sin_gamma * sin_beta, cos_beta, -cos_gamma * sin_beta)  # y of S_n
    along = _vector(cos_gamma, 0.0, -sin_gamma)  # x of S_n
    shift = _vector(member.profile_shift * np.asarray(tool.normal_module), 0.0, 0.0)
    return Rack(
        apex=shift + (sigma * 0.25 * np.pi) * tool.normal_module * across,
        direction=cos_alpha * along - sigma * sin_alpha * across,
        normal=sin_alpha * along + sigma * cos_alpha * across,
        trace=_vector(cos_beta * sin_gamma, sin_beta, cos_beta * cos_gamma),
        parabola=tool.parabola,
        pitch_radius=reference_radius(member),
        sigma=sigma,
    )


def _vector(x: Quantity, y: Quantity, z: Quantity) -> FloatArray:
    vector = np.empty((3, *np.shape(x + y + z)))
    vector[0], vector[1], vector[2] = x, y, z
    return vector


def _against(vector: FloatArray, values: Numbers) -> FloatArray:
    """Give the vectors (3, *batch) with axes put in behind the first, to broadcast with `values`."""
    missing = values.ndim + 1 - vector.ndim
    return vector if missing <= 0 else vector.reshape(3, *[1] * missing, *vector.shape[1:])


def rack_point(rack: Rack, l: Numbers) -> Numbers:
    """Find points (3, ...) of the rack in S_c at `u = 0` (Eq. 4), mm."""
    bend = rack.parabola * l * l
    return _against(rack.apex, bend) + l * _against(rack.direction, bend) + bend * _against(rack.normal, bend)


def rack_normal(rack: Rack, l: Numbers) -> Numbers:
    """Find the unit normals (3, ...) of the rack in S_c (Eq. 5), out of the gear tooth."""
    bend = 2.0 * rack.parabola * l
    return (_against(rack.normal, bend) - bend * _against(rack.direction, bend)) / np.sqrt(1.0 + bend * bend)


def rack_tangent(rack: Rack, l: Numbers) -> Numbers:
    """Find the derivative (3, ...) of the rack point by `l`; square to normal and trace, not of unit
    length."""
    bend = 2.0 * rack.parabola * l
    return _against(rack.direction, bend) + bend * _against(rack.normal, bend)


def parameter_at_height(tool: Tool, height: Quantity) -> FloatArray:
    """Find the flank parameter `l` at which the tool flank has x_n = `height` (mm).

    NaN where the parabola is so strong that the profile folds before it gets there."""
    sin, cos = np.sin(tool.normal_pressure_angle), np.cos(tool.normal_pressure_angle)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(cos**2 + 4.0 * np.asarray(tool.parabola) * sin * height)
    return np.asarray(2.0 * height / (cos + root))
