"""The paper's five equations (Eqs. 1-15) at 60 working digits.

The rack is that of Eq. 4, without profile shift, and the member is placed as in Eq. 10, its
section of zero shift at `dw - bc`. Only the results are then turned into the project's
convention, so that a wrong shift, turn or height there cannot cancel here. Inputs arrive as
floats and count as exact. Lengths mm, angles rad.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from ..arrays import FLANK_SIGN
from ..design.model import Design, Errors, Member
from .pitch_region import hand_of_pair, pitch_guess, pitch_region

try:
    import mpmath
except ImportError as missing:
    raise ImportError("the five equations at 60 digits need mpmath: pip install mpmath") from missing

MP = mpmath.MPContext()
MP.dps = 60
RESIDUAL_LIMIT = MP.mpf(10) ** -40

Mpf: TypeAlias = Any  # mpmath's numbers belong to a context and carry no static type
Vector: TypeAlias = tuple[Mpf, Mpf, Mpf]
Surface: TypeAlias = Callable[[Mpf, Mpf, Mpf], tuple[Vector, Vector]]


@dataclass(frozen=True)
class ContactMp:
    """One contact: flank parameters and rolls in the project's convention; point and the
    pinion's outward unit normal in S_f; largest residual of the six equations."""

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
class MountingMp:
    """Pitch point of the unmodified pair without errors, and its place on both members."""

    dw1: Mpf
    dw2: Mpf
    rw1: Mpf
    rw2: Mpf
    pitch_point: Vector
    gap: Mpf  # closest approach of the right and left lines of contact


@dataclass(frozen=True)
class ZeroShift:
    """How far the paper's reference (zero-shift section) is from the project's (mid-face)."""

    radial: Mpf  # displacement of the rack, where no section of zero shift exists
    height: Mpf  # bc: mid-face lies this far above the zero-shift section
    u: Mpf  # u_paper = u_project + u
    turn: Mpf  # roll_paper = roll_project - turn


def reference_radius(member: Member) -> Mpf:
    """r_P = m_n N / (2 cos(beta))."""
    return MP.mpf(member.tool.normal_module) * MP.mpf(member.teeth) / (2 * MP.cos(MP.mpf(member.helix_angle)))


def zero_shift(member: Member) -> ZeroShift:
    """Distance of the zero-shift section, and what it does to `u` and to the roll.

    With s = bc / (cos(beta) cos(gamma)), the rack's trace direction t gives s t =
    (x m_n, bc tan(beta)/cos(gamma), bc): moved along its own trace by s, the unshifted rack
    arrives at mid-face with the radial displacement x m_n, but too far along y by
    bc tan(beta)/cos(gamma), which is undone by turning the member back.
    """
    shift = MP.mpf(member.profile_shift) * MP.mpf(member.tool.normal_module)
    beta, gamma = MP.mpf(member.helix_angle), MP.mpf(member.cone_angle)
    if gamma == 0:
        return ZeroShift(radial=shift, height=MP.zero, u=MP.zero, turn=MP.zero)
    height = shift / MP.tan(gamma)  # bc
    return ZeroShift(
        radial=MP.zero,
        height=height,
        u=height / (MP.cos(beta) * MP.cos(gamma)),
        turn=height * MP.tan(beta) / (MP.cos(gamma) * reference_radius(member)),
    )


def flank_surface(member: Member, flank: str) -> Surface:
    """Eqs. 1-6 and 12: (l, u, roll) to point and outward unit normal, in the frame that
    stands still, z from the zero-shift section; u and roll are the paper's."""
    sigma = MP.mpf(FLANK_SIGN[flank])
    a, alpha = MP.mpf(member.tool.parabola), MP.mpf(member.tool.normal_pressure_angle)
    beta, gamma = MP.mpf(member.helix_angle), MP.mpf(member.cone_angle)
    half_space = MP.pi * MP.mpf(member.tool.normal_module) / 4  # s0 / 2
    r_p, radial = reference_radius(member), zero_shift(member).radial
    sa, ca, sb, cb = MP.sin(alpha), MP.cos(alpha), MP.sin(beta), MP.cos(beta)
    sg, cg = MP.sin(gamma), MP.cos(gamma)

    def to_rack_frame(x: Mpf, y: Mpf, u: Mpf) -> Vector:  # S_n -> S_P -> S_c of Eq. 4
        return (
            cg * x + u * cb * sg - sb * sg * y,
            cb * y + u * sb,
            u * cb * cg - sg * x - cg * sb * y,
        )

    def surface(el: Mpf, u: Mpf, roll: Mpf) -> tuple[Vector, Vector]:
        x_c, y_c, z_c = to_rack_frame(
            a * el**2 * sa + el * ca, sigma * (a * el**2 * ca - el * sa + half_space), u
        )
        x_c += radial
        along_l = to_rack_frame(2 * a * el * sa + ca, sigma * (2 * a * el * ca - sa), MP.zero)
        along_u = to_rack_frame(MP.zero, MP.zero, MP.one)
        n = _scaled(_cross(along_l, along_u), -sigma)  # Eq. 5, out of the tooth
        n = _scaled(n, 1 / MP.sqrt(_dot(n, n)))
        phi = (n[0] * y_c - n[1] * x_c) / (n[0] * r_p)  # Eq. 6
        sin, cos = MP.sin(phi), MP.cos(phi)
        point = (
            x_c * cos - y_c * sin + r_p * (cos + phi * sin),
            x_c * sin + y_c * cos + r_p * (sin - phi * cos),
            z_c,
        )
        normal = _turned(n, phi)
        return _turned(point, roll), _turned(normal, roll)

    return surface


def solve_mp(
    design: Design,
    flank: str,
    guess: Sequence[float],
    fixed: tuple[str, float],
    mounting: tuple[Mpf, Mpf],
) -> ContactMp:
    """Contact of two flanks where `fixed` = ("l1", value) or ("phi1", value).

    `guess` is (l1, u1, l2, u2, phi1, phi2), its fixed entry ignored; `mounting` the distances
    dw1, dw2 without axial errors. Raises ArithmeticError where no solution is found whose six
    residuals (mm for points, 1 for normals) are all under 1e-40.
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
        # n_y follows from the other two by unit length, but for its sign, checked below.
        return [*position, normal[0], normal[2]]

    del start[place]
    try:
        found = MP.findroot(five, start, tol=MP.mpf(10) ** -50, maxsteps=60, verify=False)
    except ZeroDivisionError as singular:
        raise ArithmeticError(f"no contact found at {name} = {value}: singular equations") from singular
    six = unknowns_to_six(list(found))
    position, normal, point, outward = gaps(six)
    residual = max(abs(x) for x in (*position, *normal))
    if not residual < RESIDUAL_LIMIT:
        raise ArithmeticError(f"no contact found at {name} = {value}: residual {MP.nstr(residual, 3)}")
    l1, u1, l2, u2, phi1, phi2 = (x - dx for x, dx in zip(six, to_paper, strict=True))
    return ContactMp(l1, u1, l2, u2, phi1, phi2, point, outward, residual)


def mounting_mp(design: Design) -> MountingMp:
    """Pitch point: midpoint of the closest approach of the right and left lines of contact of
    the unmodified pair without errors, each line through two contacts solved for.

    Raises ArithmeticError if a line belongs to the other, false branch of the common normal.
    """
    plain = replace(design.with_parabola(0.0, 0.0), errors=Errors())
    region = pitch_region(plain)
    lines = []
    for flank in ("right", "left"):
        guess = pitch_guess(plain, flank)
        first, second = (
            solve_mp(plain, flank, guess, ("phi1", guess[4] + turn), region.mounting)
            for turn in (-0.05, 0.05)
        )
        if _dot(first.normal, region.plane_normal) <= 0:  # sin of the working pressure angle
            raise ArithmeticError(f"the {flank} flank's common normal belongs to the false branch")
        lines.append((first.point, _minus(second.point, first.point)))
    (p, along_p), (q, along_q) = lines
    # Closest points p + s along_p and q + t along_q: the difference is square to both lines.
    pp, pq, qq = _dot(along_p, along_p), _dot(along_p, along_q), _dot(along_q, along_q)
    between = _minus(q, p)
    determinant = pp * qq - pq**2
    s = (_dot(between, along_p) * qq - _dot(between, along_q) * pq) / determinant
    t = (_dot(between, along_p) * pq - _dot(between, along_q) * pp) / determinant
    on_p, on_q = _plus(p, _scaled(along_p, s)), _plus(q, _scaled(along_q, t))
    pitch_point = _scaled(_plus(on_p, on_q), MP.mpf(1) / 2)
    separation = _minus(on_q, on_p)
    offset, shaft = MP.mpf(plain.pair.offset), hand_of_pair(plain) * MP.mpf(plain.pair.shaft_angle)
    from_gear = _minus(pitch_point, (offset, MP.zero, MP.zero))
    dw1, dw2 = pitch_point[2], _dot(from_gear, (MP.zero, MP.sin(shaft), MP.cos(shaft)))
    return MountingMp(
        dw1=dw1,
        dw2=dw2,
        rw1=MP.sqrt(_dot(pitch_point, pitch_point) - dw1**2),
        rw2=MP.sqrt(_dot(from_gear, from_gear) - dw2**2),
        pitch_point=pitch_point,
        gap=MP.sqrt(_dot(separation, separation)),
    )


def base_cylinder_mp(member: Member, flank: str, el: float = 0.0, u: float = 0.0) -> tuple[Mpf, Mpf]:
    """Radius of the cylinder that the flank's normal touches, and arcsin of its z component,
    at one point of the flank; constant over an unmodified one."""
    point, normal = flank_surface(member, flank)(MP.mpf(el), MP.mpf(u), MP.zero)
    across = MP.sqrt(normal[0] ** 2 + normal[1] ** 2)
    return abs(point[0] * normal[1] - point[1] * normal[0]) / across, MP.asin(normal[2])


def _six_equations(
    design: Design, flank: str, mounting: tuple[Mpf, Mpf]
) -> Callable[[Sequence[Mpf]], tuple[Vector, Vector, Vector, Vector]]:
    """Eqs. 7-15 in the paper's variables (l1, u1, l2, u2, phi1, phi2): gap of the points, sum
    of the normals, pinion's point and normal, all in S_f."""
    errors = design.errors
    surface1, surface2 = flank_surface(design.pinion, flank), flank_surface(design.gear, flank)
    height1 = MP.mpf(mounting[0]) - zero_shift(design.pinion).height + MP.mpf(errors.pinion_axial)
    height2 = MP.mpf(mounting[1]) - zero_shift(design.gear).height + MP.mpf(errors.gear_axial)
    offset = MP.mpf(design.pair.offset) + MP.mpf(errors.offset)
    shaft = hand_of_pair(design) * (MP.mpf(design.pair.shaft_angle) + MP.mpf(errors.shaft_angle))
    sin, cos = MP.sin(shaft), MP.cos(shaft)

    def gear_to_fixed(v: Vector) -> Vector:  # X2 = -x, Y2 = k2 x X2, Z2 = k2
        return -v[0], -cos * v[1] + sin * v[2], sin * v[1] + cos * v[2]

    def gaps(six: Sequence[Mpf]) -> tuple[Vector, Vector, Vector, Vector]:
        l1, u1, l2, u2, phi1, phi2 = six
        (x1, y1, z1), n1 = surface1(l1, u1, phi1)
        (x2, y2, z2), n2 = surface2(l2, u2, phi2)
        point1 = (x1, y1, z1 + height1)
        point2 = _plus(gear_to_fixed((x2, y2, z2 + height2)), (offset, MP.zero, MP.zero))
        return _minus(point1, point2), _plus(n1, gear_to_fixed(n2)), point1, n1

    return gaps


def _turned(v: Vector, angle: Mpf) -> Vector:
    sin, cos = MP.sin(angle), MP.cos(angle)
    return cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]


def _dot(v: Sequence[Mpf], w: Sequence[Mpf]) -> Mpf:
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


def _cross(v: Vector, w: Vector) -> Vector:
    return v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]


def _scaled(v: Vector, factor: Mpf) -> Vector:
    return factor * v[0], factor * v[1], factor * v[2]


def _plus(v: Vector, w: Vector) -> Vector:
    return v[0] + w[0], v[1] + w[1], v[2] + w[2]


def _minus(v: Vector, w: Vector) -> Vector:
    return v[0] - w[0], v[1] - w[1], v[2] - w[2]
