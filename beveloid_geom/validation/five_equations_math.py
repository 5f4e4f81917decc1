"""The paper's five equations (Eqs. 1-15) in Python floats, solved with `scipy.optimize.fsolve`.

This is the reference for speed. The rack is a polynomial in l with precomputed constants. An evaluation takes
one square root and one sine and cosine per member, and uses no arrays. Profile shift is a radial displacement
at mid-face. Lengths in mm, angles in rad."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, sin, sqrt

import numpy as np
from scipy.optimize import fsolve

from ..arrays import FLANK_SIGN, FloatArray, Mask
from ..design.arguments import require_unmodified
from ..design.member import Member
from ..design.model import Design
from .pitch_region import hand_of_pair

Surface = Callable[[float, float, float], tuple[float, float, float, float, float, float]]
RESIDUAL_LIMIT = 1e-10
"""Largest residual of an accepted position, mm for points and 1 for normals."""


@dataclass(frozen=True, eq=False)
class ReferenceContacts:
    """Contacts at n pinion rolls: shape (n,), points and pinion normals in S_f (n, 3)."""

    l1: FloatArray
    u1: FloatArray
    l2: FloatArray
    u2: FloatArray
    phi1: FloatArray
    phi2: FloatArray
    point: FloatArray
    normal: FloatArray
    residual: FloatArray  # largest of the five, mm for points and 1 for normals
    converged: Mask  # reported by fsolve, or with a residual below RESIDUAL_LIMIT


def flank_function(member: Member, flank: str) -> Surface:
    """Return Eqs. 1-6 and 12 as a function (l, u, roll) -> (x, y, z, n_x, n_y, n_z), with z from mid-face."""
    sigma = FLANK_SIGN[flank]
    tool, m_n = member.tool, float(member.tool.normal_module)
    flank_parabola = tool.parabola_right if sigma > 0.0 else tool.parabola_left
    a, apex = float(tool.parabola if flank_parabola is None else flank_parabola), float(tool.parabola_apex)
    alpha, beta = float(member.tool.normal_pressure_angle), float(member.helix_angle)
    gamma = float(member.cone_angle)
    sa, ca, sb, cb, sg, cg = sin(alpha), cos(alpha), sin(beta), cos(beta), sin(gamma), cos(gamma)
    r_p = m_n * float(member.teeth) / (2.0 * cb)
    half_space = pi * m_n / 4.0
    # Eq. 4: position = p + q l + e l^2 + t u, all in S_c; p is the apex at u = 0, and e contains the
    # coefficient a.
    px = float(member.profile_shift) * m_n - sb * sg * sigma * half_space
    py, pz = cb * sigma * half_space, -cg * sb * sigma * half_space
    qx, qy, qz = cg * ca + sb * sg * sigma * sa, -cb * sigma * sa, -sg * ca + cg * sb * sigma * sa
    px, py, pz = px + apex * qx, py + apex * qy, pz + apex * qz
    ex, ey = (cg * sa - sb * sg * sigma * ca) * a, cb * sigma * ca * a
    ez = -(sg * sa + cg * sb * sigma * ca) * a
    tx, ty, tz = cb * sg, sb, cb * cg
    # Eq. 5: (q + 2 e l) x t, of length sqrt(1 + 4 a^2 l^2), out of the tooth.
    nx0, ny0, nz0 = (-sigma * c for c in (qy * tz - qz * ty, qz * tx - qx * tz, qx * ty - qy * tx))
    nx1, ny1, nz1 = (-2.0 * sigma * c for c in (ey * tz - ez * ty, ez * tx - ex * tz, ex * ty - ey * tx))
    four_a2 = 4.0 * a * a

    def surface(el: float, u: float, roll: float) -> tuple[float, float, float, float, float, float]:
        """Return the components of point and unit normal."""
        x_c = px + el * (qx + el * ex) + u * tx
        y_c = py + el * (qy + el * ey) + u * ty
        scale = 1.0 / sqrt(1.0 + four_a2 * el * el)
        n_x, n_y = (nx0 + el * nx1) * scale, (ny0 + el * ny1) * scale
        y = n_y / n_x * x_c  # Eq. 6: y_c - r_P phi
        turn = (y_c - y) / r_p + roll
        c, s = cos(turn), sin(turn)
        x = r_p + x_c
        return (
            c * x - s * y,
            s * x + c * y,
            pz + el * (qz + el * ez) + u * tz,
            c * n_x - s * n_y,
            s * n_x + c * n_y,
            (nz0 + el * nz1) * scale,
        )

    return surface


def five_residuals(
    design: Design, flank: str, mounting: tuple[float, float]
) -> Callable[[FloatArray, float], list[float]]:
    """Return the residuals of Eqs. 7-15 as a function of (l1, u1, l2, u2, phi2) and phi1."""
    require_unmodified(flank, "the five equations", pinion=design.pinion, gear=design.gear)
    errors = design.errors
    surface1, surface2 = flank_function(design.pinion, flank), flank_function(design.gear, flank)
    height1 = float(mounting[0]) + float(errors.pinion_axial)
    height2 = float(mounting[1]) + float(errors.gear_axial)
    offset = float(design.pair.offset) + float(errors.offset)
    shaft = hand_of_pair(design) * (float(design.pair.shaft_angle) + float(errors.shaft_angle))
    s, c = sin(shaft), cos(shaft)

    def residuals(unknowns: FloatArray, phi1: float) -> list[float]:
        """Return R1 - R2, mm, and two components of n1 + n2."""
        l1, u1, l2, u2, phi2 = unknowns.tolist()
        x1, y1, z1, nx1, _, nz1 = surface1(l1, u1, phi1)
        x2, y2, z2, nx2, ny2, nz2 = surface2(l2, u2, phi2)
        z2 += height2
        return [
            x1 + x2 - offset,
            y1 + c * y2 - s * z2,
            z1 + height1 - s * y2 - c * z2,
            nx1 - nx2,
            nz1 + s * ny2 + c * nz2,
        ]

    return residuals


def solve_math(
    design: Design,
    flank: str,
    phi1: Sequence[float] | FloatArray,
    guess: Sequence[float],
    mounting: tuple[float, float],
    *,
    xtol: float = 1e-14,
    residual_limit: float = RESIDUAL_LIMIT,
) -> ReferenceContacts:
    """Compute contacts at pinion rolls `phi1` in order, each started from the one before.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    phi1 : sequence of float
        Pinion rolls, rad.
    guess : sequence of float
        (l1, u1, l2, u2, phi1, phi2) of a contact near the first roll. The gear is rotated from there by the
        ratio of the tooth numbers.
    mounting : tuple of float
        Mounting distances, mm.
    xtol : float
        Tolerance of `fsolve`.
    residual_limit : float
        Largest residual of an accepted position; to be raised with a large `xtol`.

    Returns
    -------
    ReferenceContacts

    Raises
    ------
    ModifiedFlanksError
        For flanks with a modification.
    ArithmeticError
        At the first roll whose residual exceeds `residual_limit`.
    """
    residuals = five_residuals(design, flank, mounting)
    surface1 = flank_function(design.pinion, flank)
    height1 = float(mounting[0]) + float(design.errors.pinion_axial)
    rolls = np.asarray(phi1, dtype=np.float64)
    table, converged = np.empty((rolls.size, 12)), np.empty(rolls.size, dtype=bool)
    ratio = float(design.pinion.teeth) / float(design.gear.teeth)
    start = np.array([*guess[:4], guess[5] - ratio * (rolls[0] - guess[4])])
    for i, roll in enumerate(rolls.tolist()):
        start, info, code, message = fsolve(residuals, start, args=(roll,), xtol=xtol, full_output=True)
        # fsolve reports "no progress" at the rounding limit, so that the residual decides.
        residual = max(map(abs, info["fvec"].tolist()))
        if not residual <= residual_limit:
            raise ArithmeticError(f"no contact found at phi1 = {roll}: residual {residual:.1e}; {message}")
        converged[i] = code == 1 or residual < RESIDUAL_LIMIT
        l1, u1, l2, u2, phi2 = start.tolist()
        x, y, z, *normal = surface1(l1, u1, roll)
        table[i] = l1, u1, l2, u2, phi2, residual, x, y, z + height1, *normal
    return ReferenceContacts(
        l1=table[:, 0],
        u1=table[:, 1],
        l2=table[:, 2],
        u2=table[:, 3],
        phi1=rolls,
        phi2=table[:, 4],
        point=table[:, 6:9],
        normal=table[:, 9:12],
        residual=table[:, 5],
        converged=converged,
    )
