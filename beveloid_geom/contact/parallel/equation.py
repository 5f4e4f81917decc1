"""Contact on parallel axes, where F(l1, l2) = 0 of crossed axes is singular.

n.k1 = v1 and n.k2 = -v2 are a single equation if k1 = k2, so that contact requires

    v_1(l1) + v_2(l2) = 0,

and the moments about both axes give n_y = (g_1 + g_2)/E (`pair.frames.parallel_normal`). Both planes of
action coincide, and w_1 is free in this plane. As on crossed axes,

    F(l1, l2, w_1) = A_1 + B_1 w_1 + A_2 + B_2 w_2 - E n_x = 0,   w_2 = w_1 - n_x E v_2 / S.

If both members are cut by the two sides of one rack, with the same trace, B_1 + B_2 = 0 and w_1 drops out of
F: a contact at one w_1 is a contact along the entire rack line, the straight line of constant l on the rack.
The solutions are

- flanks without a parabola: v_j are constants, and F = 0 gives l2 for every l1 and w_1: contact lines;
- teeth parallel to the axes (no helix, no cone), with parabolas or without: v_j = 0, also contact lines;
- other flanks with parabolas: v_1 + v_2 = 0 requires a_1 l1 = a_2 l2, that is (l1, l2) = s (a_2, a_1) / a_max
  with a_max = max(|a_1|, |a_2|), and F(s) = 0 has isolated solutions s, mm: a contact point, which moves
  along the rack line with a constant normal. If F(s) = 0 for all s the racks are conjugate, as for a_1 = -a_2
  on reference cylinders that touch, and the flanks touch along lines again.

Arrays have the shape (2, cases, positions), as in `equation`.
"""

from __future__ import annotations

import numpy as np

from ...arrays import COMPLEX_STEP, FloatArray, Mask
from ...gear.rack import Numbers
from ..equation import ContactTerms, gap_tolerance, meeting_at
from ..flank_pair import FlankPair, terms_of

PARALLEL_TRACE_TOLERANCE = 1e-12
"""Components of a trace below which teeth are parallel to the axis."""


def meet_on_parallel(pairing: FlankPair, l: Numbers, w: Numbers) -> ContactTerms:
    """Return F and its terms at l (2, cases, positions) and w1 (cases, positions), mm.

    The caller silences NumPy's warnings.
    """
    terms = terms_of(pairing, l)
    v, moment = terms.normal[2], terms.moment
    normal_y = (moment[0] + moment[1]) / pairing.layout.offset
    normal_x = pairing.branch * np.sqrt(1.0 - v[0] * v[0] - normal_y * normal_y)
    return meeting_at(pairing, terms, w + 0.0 * normal_x, normal_x, np.array((normal_y, normal_y)))


def mate_parameter(pairing: FlankPair, l1: FloatArray, w: FloatArray) -> FloatArray:
    """Return l2 (cases, positions), mm, with F = 0 at l1 and w1; explicit without parabolas."""
    l2 = np.zeros(np.broadcast_shapes(l1.shape, w.shape))
    steps = 2 if pairing.without_parabola.all() else 12
    # Newton step, relative to the length of the profile, below which the iteration ends: the remaining error
    # is of the order of its square, which is below rounding.
    converged = 1e-10 * (pairing.highest[1] - pairing.lowest[1])
    done = np.zeros(l2.shape, dtype=bool)
    # Newton's method with a complex step; F is linear without parabolas.
    for _ in range(steps):
        l = np.array(np.broadcast_arrays(l1 + 0j, l2 + COMPLEX_STEP * 1j))
        gap = meet_on_parallel(pairing, l, w).gap
        step = COMPLEX_STEP * gap.real / gap.imag
        l2 = np.where(done, l2, l2 - step)
        done |= ~(np.abs(step) > converged)  # also NaN
        if done.all():
            break
    return l2


def at_mid_face(pairing: FlankPair, l: FloatArray) -> FloatArray:
    """Return w1 (cases, positions), mm, of contacts at l (2, cases, positions), midway between mid-faces."""
    zero = np.zeros(l.shape[1:])
    low, high = (meet_on_parallel(pairing, l, zero + w) for w in (0.0, 1.0))
    middle = pairing.position.mean(axis=0)
    start, end = (met.normal[2, 0] * met.along[0] + met.square[0] * met.across[0] for met in (low, high))
    return np.asarray((middle - start) / (end - start))


def contact_at_l1(pairing: FlankPair, l1: FloatArray) -> tuple[FloatArray, ContactTerms, Mask]:
    """Return l (2, cases, positions) and terms of the contacts at l1 (cases, positions), mm, midway between
    the mid-faces, and where these exist.
    """
    # w1 at mid-face depends on l2, which is solved in between.
    start = np.array((l1, np.zeros(l1.shape)))
    l = np.array((l1, mate_parameter(pairing, l1, at_mid_face(pairing, start))))
    met = meet_on_parallel(pairing, l, at_mid_face(pairing, l))
    good = np.abs(met.gap) <= 8.0 * gap_tolerance(pairing)
    return l, met, good & (np.abs(met.normal[2].sum(axis=0)) <= PARALLEL_TRACE_TOLERANCE)


def one_rack(pairing: FlankPair) -> Mask:
    """Return for which cases the racks of both members are two sides of one rack, by normal and trace."""
    normal, trace = pairing.rack.normal, pairing.rack.trace
    mirrored = np.array((1.0, 1.0, -1.0)).reshape(3, 1, 1)
    turned = np.array((-1.0, -1.0, 1.0)).reshape(3, 1, 1)
    apart = np.abs(normal[:, 0] - mirrored * normal[:, 1]) + np.abs(trace[:, 0] - turned * trace[:, 1])
    return np.asarray((apart <= PARALLEL_TRACE_TOLERANCE).all(axis=(0, 2)))


def along_axes(pairing: FlankPair) -> Mask:
    """Return for which cases the teeth of both members are parallel to the axes: no helix and no cone."""
    return np.asarray((np.abs(pairing.rack.trace[:2]) <= PARALLEL_TRACE_TOLERANCE).all(axis=(0, 1, 3)))
