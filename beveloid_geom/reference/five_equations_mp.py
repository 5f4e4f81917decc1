"""The paper's five equations (Eqs. 1-15) at 60 working digits.

The rack is that of Eq. 4, without profile shift, and the member is placed as in Eq. 10, its
section of zero shift at `dw - bc`. Only the results are then turned into the project's
convention, so that a wrong shift, turn or height there cannot cancel here. Inputs arrive as
floats and count as exact. Lengths mm, angles rad.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FLANK_SIGN
from ..design.model import Design, Member
from .pitch_region import hand_of_pair

try:
    import mpmath
except ImportError as missing:
    raise ImportError("the five equations at 60 digits need mpmath: pip install mpmath") from missing

MP = mpmath.MPContext()
MP.dps = 60
RESIDUAL_LIMIT = MP.mpf(10) ** -40

Mpf: TypeAlias = Any  # mpmath's numbers belong to a context and carry no static type
Vector: TypeAlias = NDArray[Any]
"""Three of them: NumPy adds and multiplies whatever numbers it is given."""
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
    """Find the distance of the zero-shift section, and what it does to `u` and to the roll.

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

    # S_n -> S_P -> S_c of Eq. 4: its columns are x_n, y_n and the trace.
    to_rack_frame = np.array([[cg, -sb * sg, cb * sg], [0, cb, sb], [-sg, -cg * sb, cb * cg]])

    def surface(el: Mpf, u: Mpf, roll: Mpf) -> tuple[Vector, Vector]:
        """Give point and outward unit normal."""
        section = a * el**2 * sa + el * ca, sigma * (a * el**2 * ca - el * sa + half_space), u
        x_c, y_c, z_c = to_rack_frame @ section + (radial, 0, 0)
        along_l = to_rack_frame @ (2 * a * el * sa + ca, sigma * (2 * a * el * ca - sa), 0)
        n = -sigma * np.cross(along_l, to_rack_frame[:, 2])  # Eq. 5, out of the tooth
        n = n / MP.sqrt(n @ n)
        phi = (n[0] * y_c - n[1] * x_c) / (n[0] * r_p)  # Eq. 6
        sin, cos = MP.sin(phi), MP.cos(phi)
        point = (
            x_c * cos - y_c * sin + r_p * (cos + phi * sin),
            x_c * sin + y_c * cos + r_p * (sin - phi * cos),
            z_c,
        )
        return _turned(point, roll), _turned(n, phi + roll)

    return surface


def solve_mp(
    design: Design,
    flank: str,
    guess: Sequence[float],
    fixed: tuple[str, float],
    mounting: tuple[Mpf, Mpf],
) -> ContactMp:
    """Find the contact of two flanks where `fixed` = ("l1", value) or ("phi1", value).

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

    # X2 = -x, Y2 = k2 x X2, Z2 = k2
    gear_to_fixed = np.array([[-1, 0, 0], [0, -cos, sin], [0, sin, cos]])

    def gaps(six: Sequence[Mpf]) -> tuple[Vector, Vector, Vector, Vector]:
        """Give the gaps at six unknowns."""
        l1, u1, l2, u2, phi1, phi2 = six
        (point1, n1), (point2, n2) = surface1(l1, u1, phi1), surface2(l2, u2, phi2)
        point1 += 0, 0, height1
        point2 += 0, 0, height2
        point2 = gear_to_fixed @ point2 + (offset, 0, 0)
        return point1 - point2, n1 + gear_to_fixed @ n2, point1, n1

    return gaps


def _turned(v: Sequence[Mpf] | Vector, angle: Mpf) -> Vector:
    """Turn a vector (3,) about z by an angle, rad."""
    sin, cos = MP.sin(angle), MP.cos(angle)
    return np.array((cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]))
