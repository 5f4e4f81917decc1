"""The paper's five equations (Eqs. 1-15) with NumPy 3-vectors and 4x4 matrices, and `fsolve`.

Written as the equations stand in the paper and as most people would type them: constant
matrices made once, the others where they are needed. The second reference for speed. Profile
shift enters as a radial displacement at mid-face. Lengths mm, angles rad.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import fsolve

from ..arrays import flank_sign
from ..design.model import Design, Member
from .five_equations_math import RESIDUAL_LIMIT, XTOL, Contacts, first_start
from .pitch_region import hand_of_pair

FloatArray = NDArray[np.float64]
Surface = Callable[[float, float], tuple[FloatArray, FloatArray]]


def translation(x: float, y: float, z: float) -> FloatArray:
    """4x4 matrix of a displacement (Eqs. 10 and 11)."""
    return np.array([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def rotation_x(angle: float) -> FloatArray:
    """4x4 matrix of a turn about x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0, 0.0], [0.0, c, -s, 0.0], [0.0, s, c, 0.0], [0.0, 0.0, 0.0, 1.0]])


def rotation_y(angle: float) -> FloatArray:
    """4x4 matrix of a turn about y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, 0.0], [0.0, 0.0, 0.0, 1.0]])


def rotation_z(angle: float) -> FloatArray:
    """4x4 matrix of a turn about z (Eq. 12)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def flank_surface(member: Member, flank: str) -> Surface:
    """Eqs. 1-6: (l, u) to homogeneous point and unit normal, out of the tooth, in the member's frame."""
    sigma = flank_sign(flank)
    m_n, a = float(member.tool.normal_module), float(member.tool.parabola)
    alpha, beta = float(member.tool.normal_pressure_angle), float(member.helix_angle)
    ca, sa = np.cos(alpha), np.sin(alpha)
    r_p = m_n * float(member.teeth) / (2.0 * np.cos(beta))
    # S_n -> S_P -> S_c (Eq. 4), moved out by the profile shift.
    shift = translation(float(member.profile_shift) * m_n, 0.0, 0.0)
    to_rack = shift @ rotation_y(float(member.cone_angle)) @ rotation_x(-beta)

    def surface(el: float, u: float) -> tuple[FloatArray, FloatArray]:
        section = np.array(
            [el * ca + a * el**2 * sa, sigma * (a * el**2 * ca - el * sa + np.pi * m_n / 4.0), u, 1.0]
        )
        # Eq. 5, square to the section's tangent: the trace is along z of S_n.
        across = np.array([sa - 2.0 * a * el * ca, sigma * (ca + 2.0 * a * el * sa), 0.0])
        normal = to_rack[:3, :3] @ (across / np.linalg.norm(across))
        x_c, y_c, z_c, _ = to_rack @ section
        phi = (normal[0] * y_c - normal[1] * x_c) / (normal[0] * r_p)  # Eq. 6
        turn = rotation_z(phi)
        return turn @ np.array([r_p + x_c, y_c - r_p * phi, z_c, 1.0]), turn[:3, :3] @ normal

    return surface


def member_matrices(design: Design, mounting: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Eqs. 9-11: matrices from each member's own fixed frame at roll 0 to S_f, errors included."""
    errors = design.errors
    shaft = hand_of_pair(design) * (float(design.pair.shaft_angle) + float(errors.shaft_angle))
    pinion = translation(0.0, 0.0, float(mounting[0]) + float(errors.pinion_axial))
    gear = (
        translation(float(design.pair.offset) + float(errors.offset), 0.0, 0.0)
        @ rotation_x(-shaft)
        @ rotation_z(np.pi)
        @ translation(0.0, 0.0, float(mounting[1]) + float(errors.gear_axial))
    )
    return pinion, gear


def placed(
    surface: Surface, matrix: FloatArray, el: float, u: float, roll: float
) -> tuple[FloatArray, FloatArray]:
    """Eqs. 7, 8 and 12-14: point and unit normal of a rolled member in S_f."""
    to_fixed = matrix @ rotation_z(roll)
    point, normal = surface(el, u)
    return (to_fixed @ point)[:3], to_fixed[:3, :3] @ normal


def solve_numpy(
    design: Design,
    flank: str,
    phi1: Sequence[float] | FloatArray,
    guess: Sequence[float],
    mounting: tuple[float, float],
    *,
    xtol: float = XTOL,
    cold: bool = False,
    residual_limit: float = RESIDUAL_LIMIT,
) -> Contacts:
    """Contacts at pinion rolls `phi1`; arguments and errors as for `solve_math`."""
    surface1, surface2 = flank_surface(design.pinion, flank), flank_surface(design.gear, flank)
    pinion_matrix, gear_matrix = member_matrices(design, mounting)

    def residuals(unknowns: FloatArray, roll: float) -> FloatArray:  # Eq. 15
        l1, u1, l2, u2, phi2 = unknowns
        point1, normal1 = placed(surface1, pinion_matrix, l1, u1, roll)
        point2, normal2 = placed(surface2, gear_matrix, l2, u2, phi2)
        return np.concatenate([point1 - point2, (normal1 + normal2)[[0, 2]]])

    rolls = np.asarray(phi1, dtype=np.float64)
    solutions, points, normals, left_over, converged = [], [], [], [], []
    evaluations = 0
    for i, roll in enumerate(rolls):
        if cold or i == 0:
            start = first_start(design, guess, float(roll))
        start, found, code, message = fsolve(residuals, start, args=(roll,), xtol=xtol, full_output=True)
        evaluations += found["nfev"]
        residual = np.max(np.abs(found["fvec"]))
        if not residual <= residual_limit:
            raise ArithmeticError(f"no contact found at phi1 = {roll}: residual {residual:.1e}; {message}")
        converged.append(code == 1 or residual < RESIDUAL_LIMIT)
        point, normal = placed(surface1, pinion_matrix, start[0], start[1], roll)
        solutions.append(start)
        points.append(point)
        normals.append(normal)
        left_over.append(residual)
    l1, u1, l2, u2, phi2 = np.array(solutions).T
    return Contacts(
        l1=l1,
        u1=u1,
        l2=l2,
        u2=u2,
        phi1=rolls,
        phi2=phi2,
        point=np.array(points),
        normal=np.array(normals),
        residual=np.array(left_over),
        converged=np.array(converged),
        evaluations=evaluations,
    )
