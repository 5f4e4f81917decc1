"""Contact on parallel axes, where F(l1, l2) = 0 of crossed axes becomes singular.

n.k1 = v1 and n.k2 = -v2 are one equation where k1 = k2, so that a contact asks for

    v_1(l1) + v_2(l2) = 0,

and the moments about both axes give n_y = (g_1 + g_2)/E (`pair.frames.parallel_normal`). Both planes of
action are then one, and w_1 is free in it; the axes' distance closes the loop as before,

    F(l1, l2, w_1) = A_1 + B_1 w_1 + A_2 + B_2 w_2 - E n_x = 0,   w_2 = w_1 - n_x E v_2 / S.

Where both members are cut by the two sides of one rack, trace on trace, B_1 + B_2 = 0 and w_1 drops out of F:
what touches at one w_1 touches along the whole rack line. So the solutions are

- unmodified flanks: v_j are constants, and F = 0 gives l2 for every l1 and w_1: lines of contact;
- teeth along cylinders (no helix, no cone), with parabolas or without: v_j = 0, the same;
- other flanks with parabolas: v_1 + v_2 = 0 asks for a_1 l1 = a_2 l2, (l1, l2) = s (a_2, a_1), and F(s) =
  0 leaves single s: a contact point, which runs along the rack line, with a normal that does not change.
  Where F(s) = 0 for all s the racks are conjugate, as a_1 = -a_2 on reference cylinders that touch, and
  the flanks touch along lines again.

Arrays are those of `equation`: (2, cases, positions).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import COMPLEX_STEP, FloatArray
from ...gear.rack import Numbers
from ...pair.mounting import across_of_gear
from ..equation import Meeting, Pairing, Terms, gap_tolerance, terms_of

SQUARE, PASSES = 1e-12, 12
"""Components of a trace below which teeth run along the axis; steps of Newton to l2."""


def meet_on_parallel(pairing: Pairing, l: Numbers, w: Numbers) -> Meeting:
    """Evaluate F and its terms at l (2, cases, positions) and w1 (cases, positions), mm; of `reach` only
    that of the pinion means something. The caller silences NumPy's warnings."""
    terms = terms_of(pairing, l)
    v, moment = terms.own[2], terms.moment
    normal_y = (moment[0] + moment[1]) / pairing.layout.offset
    normal_x = pairing.branch * np.sqrt(1.0 - v[0] * v[0] - normal_y * normal_y)
    return meeting_at(pairing, terms, w + 0.0 * normal_x, normal_x, np.array((normal_y, normal_y)))


def meeting_at(pairing: Pairing, terms: Terms, w: Numbers, normal_x: Numbers, normal_y: Numbers) -> Meeting:
    """Give F and its terms at w1 (cases, positions), mm, from those of both members and the common normal as
    both see it: `normal_x` (cases, positions) and `normal_y` (2, cases, positions)."""
    layout, v = pairing.layout, terms.own[2]
    across = np.array((w, across_of_gear(layout, v, terms.square, terms.moment, w, normal_x)))
    along = terms.level + terms.slope * across
    return Meeting(
        gap=along[0] + along[1] - layout.offset * normal_x,
        along=along,
        across=across,
        slope=terms.slope,
        reach=normal_x * across,
        normal_x=normal_x,
        normal_y=normal_y,
        square=terms.square,
        moment=terms.moment,
        own=terms.own,
        start=terms.start,
    )


def mate_parameter(pairing: Pairing, l1: FloatArray, w: FloatArray) -> FloatArray:
    """Solve F = 0 for l2 (cases, positions), mm, at l1 and w1: at once where flanks are unmodified."""
    l2 = np.zeros(np.broadcast_shapes(l1.shape, w.shape))
    steps = PASSES if np.any(pairing.rack.parabola) else 2
    for _ in range(steps):
        l = np.array(np.broadcast_arrays(l1 + 0j, l2 + COMPLEX_STEP * 1j))
        gap = meet_on_parallel(pairing, l, w).gap
        l2 = l2 - COMPLEX_STEP * gap.real / gap.imag
    return l2


def at_mid_face(pairing: Pairing, l: FloatArray) -> FloatArray:
    """Find w1 (cases, positions), mm, of contacts at l (2, cases, positions) midway between the mid-faces."""
    zero = np.zeros(l.shape[1:])
    low, high = (meet_on_parallel(pairing, l, zero + w) for w in (0.0, 1.0))
    middle = pairing.position.mean(axis=0)
    start, end = (met.own[2, 0] * met.along[0] + met.square[0] * met.across[0] for met in (low, high))
    return np.asarray((middle - start) / (end - start))


def contact_at_l1(pairing: Pairing, l1: FloatArray) -> tuple[FloatArray, Meeting, NDArray[np.bool_]]:
    """Give l (2, cases, positions) and terms of the contacts at l1 (cases, positions), mm, midway between the
    mid-faces, and where these are any."""
    start = np.array((l1, np.zeros(l1.shape)))
    l = np.array((l1, mate_parameter(pairing, l1, at_mid_face(pairing, start))))
    met = meet_on_parallel(pairing, l, at_mid_face(pairing, l))
    good = np.abs(met.gap) <= 8.0 * gap_tolerance(pairing)
    return l, met, good & (np.abs(met.own[2].sum(axis=0)) <= SQUARE)


def one_rack(pairing: Pairing) -> NDArray[np.bool_]:
    """Say of which cases the racks of both members are two sides of one: same normal, and trace on trace."""
    normal, trace = pairing.rack.normal, pairing.rack.trace
    mirrored = np.array((1.0, 1.0, -1.0)).reshape(3, 1, 1)
    turned = np.array((-1.0, -1.0, 1.0)).reshape(3, 1, 1)
    apart = np.abs(normal[:, 0] - mirrored * normal[:, 1]) + np.abs(trace[:, 0] - turned * trace[:, 1])
    return np.asarray((apart <= SQUARE).all(axis=(0, 2)))


def along_axes(pairing: Pairing) -> NDArray[np.bool_]:
    """Say of which cases the teeth of both members run along the axes: no helix and no cone."""
    return np.asarray((np.abs(pairing.rack.trace[:2]) <= SQUARE).all(axis=(0, 1, 3)))
