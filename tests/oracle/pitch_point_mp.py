"""The pitch point of a pair at 60 digits, by `validation.five_equations_mp`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from beveloid_geom import Design, Errors
from beveloid_geom.validation.five_equations_mp import MP, Mpf, solve_mp
from beveloid_geom.validation.pitch_region import hand_of_pair, pitch_guess, pitch_region


@dataclass(frozen=True)
class MountingMp:
    """Pitch point of the unmodified pair without errors (mm, in S_f), and its position on both members.

    `dw1`, `dw2`: mounting distances, mm. `rw1`, `rw2`: working radii, mm."""

    dw1: Mpf
    dw2: Mpf
    rw1: Mpf
    rw2: Mpf
    pitch_point: tuple[Mpf, Mpf, Mpf]
    gap: Mpf  # smallest distance of the lines of action of right and left flanks, mm


def mounting_mp(design: Design) -> MountingMp:
    """Return the pitch point of the unmodified pair without errors: the midpoint between the nearest
    points of the lines of action of right and left flanks. Two contacts are solved for each line.

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
        if first.normal @ region.plane_normal <= 0:  # sin of the working pressure angle
            raise ArithmeticError(f"the {flank} flank's common normal belongs to the false branch")
        lines.append((first.point, second.point - first.point))
    (p, along_p), (q, along_q) = lines
    # Closest points p + s along_p and q + t along_q: the difference is perpendicular to both lines.
    pp, pq, qq = along_p @ along_p, along_p @ along_q, along_q @ along_q
    between = q - p
    determinant = pp * qq - pq**2
    s = ((between @ along_p) * qq - (between @ along_q) * pq) / determinant
    t = ((between @ along_p) * pq - (between @ along_q) * pp) / determinant
    on_p, on_q = p + s * along_p, q + t * along_q
    pitch_point, separation = (on_p + on_q) / 2, on_q - on_p
    offset, shaft = MP.mpf(plain.pair.offset), hand_of_pair(plain) * MP.mpf(plain.pair.shaft_angle)
    from_gear = pitch_point - np.array((offset, 0, 0))
    dw1, dw2 = pitch_point[2], from_gear @ np.array((0, MP.sin(shaft), MP.cos(shaft)))
    x, y, z = pitch_point
    return MountingMp(
        dw1=dw1,
        dw2=dw2,
        rw1=MP.sqrt(pitch_point @ pitch_point - dw1**2),
        rw2=MP.sqrt(from_gear @ from_gear - dw2**2),
        pitch_point=(x, y, z),
        gap=MP.sqrt(separation @ separation),
    )
