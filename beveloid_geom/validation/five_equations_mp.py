"""The paper's five equations (Eqs. 1-15) at 60 digits.

The rack is that of Eq. 4, without profile shift, and the member is placed as in Eq. 10: its section of zero
shift is at dw - bc along the axis, with the mounting distance dw of mid-face and the height bc of mid-face
above this section. The equations contain only the variables of the paper. Starting values, the given
parameter and the results are converted outside the equations, so that a wrong shift, rotation or height
cannot cancel. The inputs are floats and are taken as exact. Lengths in mm, angles in rad."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FLANK_SIGN
from ..design.member import Member
from ..design.model import Design
from ..design.modification import Kind
from .pitch_region import hand_of_pair

try:
    import mpmath
except ImportError as missing:
    raise ImportError("the five equations at 60 digits need mpmath: pip install mpmath") from missing

MP = mpmath.MPContext()
MP.dps = 60

Mpf: TypeAlias = Any  # mpmath's numbers belong to a context and carry no static type
Vector: TypeAlias = NDArray[Any]
"""Three mpmath numbers in an object array."""
Surface: TypeAlias = Callable[[Mpf, Mpf, Mpf], tuple[Vector, Vector]]


@dataclass(frozen=True)
class ContactMp:
    """One contact: flank parameters and rolls in the convention of the project; point and outward unit normal
    of the pinion in S_f; largest residual of the six components of R1 - R2 and n1 + n2, of which five are
    solved."""

    l1: Mpf
    u1: Mpf
    l2: Mpf
    u2: Mpf
    phi1: Mpf
    phi2: Mpf
    point: Vector
    normal: Vector
    residual: Mpf


@dataclass(frozen=True)
class ZeroShift:
    """Distance of the paper's reference section (zero shift) from that of the project (mid-face)."""

    radial: Mpf  # displacement of the rack, where no section of zero shift exists
    height: Mpf  # bc: mid-face lies this far above the zero-shift section
    u: Mpf  # u_paper = u_project + u
    turn: Mpf  # roll_paper = roll_project - turn


def pitch_radius_mp(member: Member) -> Mpf:
    """Return r_P = m_n N / (2 cos(beta))."""
    return MP.mpf(member.tool.normal_module) * MP.mpf(member.teeth) / (2 * MP.cos(MP.mpf(member.helix_angle)))


def zero_shift(member: Member) -> ZeroShift:
    """Return the distance of the zero-shift section and its effect on `u` and on the roll.

    With s = bc / (cos(beta) cos(gamma)), the trace direction t of the rack gives s t = (x m_n, bc
    tan(beta)/cos(gamma), bc). Moved along its trace by s, the unshifted rack reaches mid-face with the radial
    displacement x m_n, but is displaced along y by bc tan(beta)/cos(gamma). A rotation of the member removes
    this displacement."""
    shift = MP.mpf(member.profile_shift) * MP.mpf(member.tool.normal_module)
    beta, gamma = MP.mpf(member.helix_angle), MP.mpf(member.cone_angle)
    if gamma == 0:
        return ZeroShift(radial=shift, height=MP.zero, u=MP.zero, turn=MP.zero)
    height = shift / MP.tan(gamma)  # bc
    return ZeroShift(
        radial=MP.zero,
        height=height,
        u=height / (MP.cos(beta) * MP.cos(gamma)),
        turn=height * MP.tan(beta) / (MP.cos(gamma) * pitch_radius_mp(member)),
    )


@dataclass(frozen=True)
class RackMp:
    """Rack of a flank in S_c (Eq. 4), without profile shift. The columns of `frame` are x_n, y_n and the
    trace."""

    sigma: Mpf
    a: Mpf
    apex: Mpf
    sin: Mpf
    cos: Mpf
    half_space: Mpf  # s0 / 2
    frame: NDArray[Any]

    @property
    def trace(self) -> Vector:
        """Direction of the tooth trace."""
        return self.frame[:, 2]

    def point(self, el: Mpf, u: Mpf) -> Vector:
        """Return the point at l and u."""
        bend, line = self.a * el**2, el + self.apex  # along the straight flank from the reference line
        across = bend * self.cos - line * self.sin + self.half_space
        return np.asarray(self.frame @ (bend * self.sin + line * self.cos, self.sigma * across, u))

    def tangent(self, el: Mpf) -> Vector:
        """Return the derivative of the point by l."""
        turn = 2 * self.a * el
        return np.asarray(
            self.frame @ (turn * self.sin + self.cos, self.sigma * (turn * self.cos - self.sin), 0)
        )

    def normal(self, el: Mpf) -> Vector:
        """Return the normal out of the tooth (Eq. 5), not of unit length."""
        return np.asarray(-self.sigma * np.cross(self.tangent(el), self.trace))

    @property
    def normal_rate(self) -> Vector:
        """Derivative of the normal by l."""
        bent = self.frame @ (2 * self.a * self.sin, self.sigma * 2 * self.a * self.cos, 0)
        return np.asarray(-self.sigma * np.cross(bent, self.trace))


def rack_mp(member: Member, flank: str) -> RackMp:
    """Return the rack of a flank."""
    tool = member.tool
    flank_parabola = {"right": tool.parabola_right, "left": tool.parabola_left}[flank]
    alpha, beta, gamma = map(MP.mpf, (tool.normal_pressure_angle, member.helix_angle, member.cone_angle))
    sb, cb, sg, cg = MP.sin(beta), MP.cos(beta), MP.sin(gamma), MP.cos(gamma)
    return RackMp(
        sigma=MP.mpf(FLANK_SIGN[flank]),
        a=MP.mpf(tool.parabola if flank_parabola is None else flank_parabola),
        apex=MP.mpf(tool.parabola_apex),
        sin=MP.sin(alpha),
        cos=MP.cos(alpha),
        half_space=MP.pi * MP.mpf(tool.normal_module) / 4,
        frame=np.array([[cg, -sb * sg, cb * sg], [0, cb, sb], [-sg, -cg * sb, cb * cg]]),  # S_n, S_P, S_c
    )


def precise_flank_surface(member: Member, flank: str) -> Surface:
    """Return Eqs. 1-6 and 12 as a function (l, u, roll) -> point and outward unit normal, in the fixed frame
    of the member, z from the zero-shift section; u and roll are those of the paper."""
    rack, r_p, shift = rack_mp(member, flank), pitch_radius_mp(member), zero_shift(member)
    turned_by = _modification(member, flank, rack)

    def surface(el: Mpf, u: Mpf, roll: Mpf) -> tuple[Vector, Vector]:
        """Return point and outward unit normal."""
        x_c, y_c, z_c = rack.point(el, u)
        x_c, n = x_c + shift.radial, rack.normal(el)
        phi = (n[0] * y_c - n[1] * x_c) / (n[0] * r_p)  # Eq. 6
        if turned_by is not None:
            # Tangents by l and u of the point (r_p + x_c, k x_c, z_c) with k = n_y / n_x, which is rotated by
            # phi and by the modification.
            slope, bent = n[1] / n[0], rack.normal_rate
            slope_l = (bent[1] - slope * bent[0]) / n[0]
            turn, turn_l, turn_z = turned_by(el, z_c - shift.height)
            tangents = []
            for (x, y, z), k, own_turn in ((rack.tangent(el), slope_l, turn_l), (rack.trace, 0, 0)):
                across = k * x_c + slope * x
                rate = (y - across) / r_p + own_turn + turn_z * z
                tangents.append(np.array((x - rate * slope * x_c, across + rate * (r_p + x_c), z)))
            n = -rack.sigma * np.cross(tangents[0], tangents[1])
            roll = roll + turn
        n = n / MP.sqrt(n @ n)
        sin, cos = MP.sin(phi), MP.cos(phi)
        point = (
            x_c * cos - y_c * sin + r_p * (cos + phi * sin),
            x_c * sin + y_c * cos + r_p * (sin - phi * cos),
            z_c,
        )
        return _turned(point, roll), _turned(n, phi + roll)

    return surface


def _modification(
    member: Member, flank: str, rack: RackMp
) -> Callable[[Mpf, Mpf], tuple[Mpf, Mpf, Mpf]] | None:
    """Return the rotation by the modification and its derivatives by l and z, as a function of l and z from
    mid-face; None without one.

    Raises ValueError for measured deviations, whose spline is computed in floats."""
    given = member.modification(flank)
    if given is None:
        return None
    if given.deviations is not None:
        raise ValueError("the five equations at 60 digits need flanks without measured deviations")
    tool, half = member.tool, MP.mpf(member.face_width) / 2
    m, r_p, straight = MP.mpf(tool.normal_module), pitch_radius_mp(member), rack.normal(MP.zero)
    base_radius = r_p * abs(straight[1]) / MP.hypot(straight[0], straight[1])
    shift = MP.mpf(member.profile_shift) * m

    def square(el: Mpf) -> Mpf:
        """Return r^2 of the flank at mid-face, where the shift is a radial displacement."""
        (x_c, _, z_c), normal = rack.point(el, 0), rack.normal(el)
        x_c += shift - z_c * rack.trace[0] / rack.trace[2]  # along the trace to mid-face
        return (r_p + x_c) ** 2 + (normal[1] / normal[0] * x_c) ** 2

    # The active flank begins at the round of the tool, or at one addendum if both differ by rounding.
    joint = tool.dedendum - tool.tip_radius * (1 - rack.sin)
    low = (tool.addendum if abs(joint - tool.addendum) < 1e-4 else joint) * m + rack.apex * rack.cos
    start = -2 * low / (rack.cos + MP.sqrt(rack.cos**2 - 4 * rack.a * rack.sin * low))
    radius = r_p + shift + MP.mpf(member.tip_height) * m
    tip = MP.findroot(lambda el: square(el) - radius**2, m)

    def coordinates(kind: Kind, length: Mpf) -> tuple[tuple[Mpf, Mpf], tuple[Mpf, Mpf]]:
        """Return zero and rate of the coordinates of the shape along the profile and the face."""
        profile = {"tip": (tip - length, 1 / length), "root": (start + length, -1 / length)}
        face = {"heel": (half - length, 1 / length), "toe": (length - half, -1 / length)}
        return (
            profile.get(kind.profile, ((start + tip) / 2, 2 / (tip - start))),
            face.get(kind.face, (MP.zero, 1 / half)),
        )

    def turned_by(el: Mpf, z: Mpf) -> tuple[Mpf, Mpf, Mpf]:
        """Return the rotation and its derivatives."""
        total = [MP.zero] * 3
        for kind, amount, length in given.terms():
            (zero_l, rate_l), (zero_z, rate_z) = coordinates(kind, MP.mpf(length or 1))
            places = (el - zero_l) * rate_l, (z - zero_z) * rate_z
            if length is not None and places[kind.profile == "active"] <= 0:
                continue  # before the beginning of a relief
            scale = -FLANK_SIGN[flank] * MP.mpf(amount) / 1000 / base_radius
            values = kind.shape(*places)
            for row, rate in enumerate((1, rate_l, rate_z)):
                total[row] += scale * rate * values[row]
        return total[0], total[1], total[2]

    return turned_by


def solve_mp(
    design: Design,
    flank: str,
    guess: Sequence[float],
    fixed: tuple[str, float],
    mounting: tuple[Mpf, Mpf],
) -> ContactMp:
    """Compute the contact of two flanks at `fixed` = ("l1", value) or ("phi1", value).

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    guess : sequence of float
        (l1, u1, l2, u2, phi1, phi2), mm and rad; its fixed entry is ignored.
    fixed : tuple of str and float
    mounting : tuple
        Mounting distances dw1, dw2 without axial errors, mm.

    Returns
    -------
    ContactMp

    Raises
    ------
    ArithmeticError
        Unless all six residuals (mm for points, 1 for normals) are below 1e-40.
    """
    names = ("l1", "u1", "l2", "u2", "phi1", "phi2")
    name, value = fixed
    if name not in ("l1", "phi1"):
        raise ValueError(f"fixed must name 'l1' or 'phi1', got {name!r}")
    place = names.index(name)
    # The paper's variables and the project's differ by constants.
    shift1, shift2 = zero_shift(design.pinion), zero_shift(design.gear)
    to_paper = (0, shift1.u, 0, shift2.u, -shift1.turn, -shift2.turn)
    start = [MP.mpf(x) + dx for x, dx in zip(guess, to_paper, strict=True)]
    held = MP.mpf(value) + to_paper[place]
    gaps = _six_equations(design, flank, mounting)

    def unknowns_to_six(unknowns: Sequence[Mpf]) -> list[Mpf]:
        return [*unknowns[:place], held, *unknowns[place:]]

    def five(*unknowns: Mpf) -> list[Mpf]:
        position, normal, *_ = gaps(unknowns_to_six(unknowns))
        # n_y follows from the other two by unit length, except for its sign, which the residual checks.
        return [*position, normal[0], normal[2]]

    del start[place]
    try:
        root = MP.findroot(five, start, tol=MP.mpf(10) ** -50, maxsteps=60, verify=False)
    except ZeroDivisionError as singular:
        raise ArithmeticError(f"no contact found at {name} = {value}: singular equations") from singular
    six = unknowns_to_six(list(root))
    position, normal, point, outward = gaps(six)
    residual = max(abs(x) for x in (*position, *normal))
    if not residual < MP.mpf(10) ** -40:
        raise ArithmeticError(f"no contact found at {name} = {value}: residual {MP.nstr(residual, 3)}")
    l1, u1, l2, u2, phi1, phi2 = (x - dx for x, dx in zip(six, to_paper, strict=True))
    return ContactMp(l1, u1, l2, u2, phi1, phi2, point, outward, residual)


def _six_equations(
    design: Design, flank: str, mounting: tuple[Mpf, Mpf]
) -> Callable[[Sequence[Mpf]], tuple[Vector, Vector, Vector, Vector]]:
    """Return Eqs. 7-15 as a function of the paper's variables (l1, u1, l2, u2, phi1, phi2): gap of the
    points, sum of the normals, point and normal of the pinion, all in S_f."""
    errors = design.errors
    surface1, surface2 = (precise_flank_surface(member, flank) for member in design.members)
    height1 = MP.mpf(mounting[0]) - zero_shift(design.pinion).height + MP.mpf(errors.pinion_axial)
    height2 = MP.mpf(mounting[1]) - zero_shift(design.gear).height + MP.mpf(errors.gear_axial)
    offset = MP.mpf(design.pair.offset) + MP.mpf(errors.offset)
    shaft = hand_of_pair(design) * (MP.mpf(design.pair.shaft_angle) + MP.mpf(errors.shaft_angle))
    sin, cos = MP.sin(shaft), MP.cos(shaft)

    # X2 = -x, Y2 = k2 x X2, Z2 = k2
    gear_to_fixed = np.array([[-1, 0, 0], [0, -cos, sin], [0, sin, cos]])

    def gaps(six: Sequence[Mpf]) -> tuple[Vector, Vector, Vector, Vector]:
        """Return the gaps at six unknowns."""
        l1, u1, l2, u2, phi1, phi2 = six
        (point1, n1), (point2, n2) = surface1(l1, u1, phi1), surface2(l2, u2, phi2)
        point1 += 0, 0, height1
        point2 += 0, 0, height2
        point2 = gear_to_fixed @ point2 + (offset, 0, 0)
        return point1 - point2, n1 + gear_to_fixed @ n2, point1, n1

    return gaps


def _turned(v: Sequence[Mpf] | Vector, angle: Mpf) -> Vector:
    """Return a vector (3,) rotated about z by an angle, rad."""
    sin, cos = MP.sin(angle), MP.cos(angle)
    return np.array((cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]))
