"""The paper's own method, as a reference: five equations for each position (Eq. 15).

The contacts are followed as a curve by its length (`five_equations_curve`), so that a path along which
the pinion's roll or l1 turns back, or n_x changes its sign, is a path like any other. The ends are
roots of the least distance inside the limits along the curve. Nothing is shared with the one-equation
method but the flanks, the frames and the very first starting value, which is moved off the solution;
where that method gives none, the start is the rough pitch point of the unmodified pair (`pitch_region`),
from where the coefficients and errors are brought in step by step.

Takes about a thousand times longer; single designs only. A curve of contacts that is not connected with
the starting value is not seen.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, flank_sign
from ..contact.path import ContactPath, PathEnds, path_of_contact, require_points
from ..design.model import Design, Errors
from ..status import Status
from .five_equations_curve import (
    L1,
    LARGEST_STEP,
    ROLL,
    FiveCurve,
    FiveEquations,
    five_equations_of,
    follow_five_equations,
)
from .pitch_region import pitch_guess

UNKNOWNS = ("l1", "u1", "l2", "u2", "gear_roll", "pinion_roll")
FIRST_GUESS = np.array([1e-3, -2e-3, -1e-3, 2e-3, 1e-5, 0.0])
DENSE = 2001
"""Points of the spline in which the first guess of a position with a given roll or l1 is looked up."""
LARGEST_MOVE, LEAST_SHARE = 0.3, 1e-4
"""Largest move (scaled unknowns) of the starting value when coefficients and errors are brought in, and
least share of them brought in at a time."""


def path_of_contact_five_equations(design: Design, flank: str = "right", points: int = 101) -> ContactPath:
    """Find the path of contact of a single design by the paper's five equations; see `path_of_contact`.

    Positions are evenly spaced in pinion roll, in l1 where the roll turns back along the path, and in
    length along the curve where l1 turns back as well. Empty if both methods find no contact on the
    flanks, and if the inputs leave nothing to solve (UNDEFINED). Raises ValueError for a batch or fewer
    than two points, and ArithmeticError where the solver finds no contact, or loses it on the flanks."""
    if design.batch_shape:
        raise ValueError("the five equations are solved for single designs, not for batches")
    require_points(points)
    guide = path_of_contact(design, flank, 3)
    if guide.ends.status == Status.UNDEFINED:
        return guide
    system = five_equations_of(design, flank)
    with np.errstate(all="ignore"):
        if guide.ends.status == Status.SOLVED:
            start = np.array([getattr(guide, name)[1] for name in UNKNOWNS]) + FIRST_GUESS
            found = nearest_contact(system, start / system.scale)
        else:
            found = _from_pitch_point(design, flank)
        curve = None if found is None else follow_five_equations(system, found)
        pieces = np.empty((0, 2)) if curve is None else curve.pieces()
        if curve is not None and len(pieces):
            return _result(design, flank, curve, pieces, points)
    if guide.ends.status in (Status.OFF_FLANK, Status.NO_COMMON_NORMAL):
        return guide
    where = "to start from" if curve is None else "on the flanks along the curve they follow"
    raise ArithmeticError(f"the five equations find no contact {where}")


def _span(curve: FiveCurve, piece: FloatArray) -> float:
    """Find the pinion roll (rad) covered by a piece of the curve."""
    stops = np.concatenate((piece, curve.turns(ROLL, (piece[0], piece[1]))))
    return float(np.ptp([curve.at(s)[ROLL] for s in stops]) * curve.system.scale[ROLL])


def _positions(curve: FiveCurve, piece: FloatArray, ends: FloatArray, share: FloatArray) -> list[FloatArray]:
    """Find the scaled unknowns at `share` in [0, 1] of the way along a piece with these ends; NaN where
    lost."""
    between = float(piece.min()), float(piece.max())
    row = next((row for row in (ROLL, L1) if curve.turns(row, between).size == 0), None)
    if row is None:
        return [curve.at(s) for s in piece[0] + (piece[1] - piece[0]) * share]
    across, dense = np.eye(6)[row], np.linspace(*between, DENSE)
    values = curve.spline(dense)[:, row]
    order = np.argsort(values)
    positions = []
    for goal in ends[0, row] + (ends[1, row] - ends[0, row]) * share:
        start = curve.spline(np.interp(goal, values[order], dense[order]))
        start[row] = goal
        found = curve.system.correct(start, across)
        near = found is not None and np.linalg.norm(found - start) < LARGEST_STEP
        positions.append(found if found is not None and near else np.full(6, np.nan))
    return positions


def nearest_contact(system: FiveEquations, start: FloatArray) -> FloatArray | None:
    """Give the contact in the plane through `start` that is square to the curve there; scaled."""
    tangent = system.tangent(start)
    return None if tangent is None else system.correct(start, tangent)


def _from_pitch_point(design: Design, flank: str) -> FloatArray | None:
    """Give a contact of the design, scaled, led over from the pitch point of the unmodified pair."""
    errors, a1, a2 = design.errors, design.pinion.tool.parabola, design.gear.tool.parabola

    def part(share: float) -> FiveEquations:
        partly = Errors(**{name: share * value for name, value in vars(errors).items()})
        return five_equations_of(design.with_parabola(share * a1, share * a2).with_errors(partly), flank)

    system = part(0.0)
    try:
        *parameters, pinion_roll, gear_roll = pitch_guess(design, flank)
    except ArithmeticError:  # the cones have no common plane
        return None
    known = nearest_contact(system, np.array((*parameters, gear_roll, pinion_roll)) / system.scale)
    done, step = 0.0, 0.25
    while known is not None and done < 1.0:
        ahead = min(done + step, 1.0)
        system = part(ahead)
        found = nearest_contact(system, known)
        if found is not None and np.linalg.norm(found - known) <= LARGEST_MOVE:
            done, known, step = ahead, found, 2.0 * step
        elif step < LEAST_SHARE:
            return None
        else:
            step *= 0.5
    return known


def _result(design: Design, flank: str, curve: FiveCurve, pieces: FloatArray, points: int) -> ContactPath:
    system, ratio = curve.system, design.pinion.teeth / design.gear.teeth
    spans = [_span(curve, piece) for piece in pieces]
    piece = pieces[int(np.argmax(spans))]
    ends = np.array([curve.end(s) for s in piece])
    if flank_sign(flank) * (ends[1, ROLL] - ends[0, ROLL]) < 0.0:
        piece, ends = piece[::-1], ends[::-1]
    found = _positions(curve, piece, ends, np.append(np.linspace(0.0, 1.0, points), 0.5))
    found[0], found[points - 1] = ends
    here = system.at(np.array(found) * system.scale)
    phase = here.unknowns[:, 4] + ratio * here.unknowns[:, 5]
    unknowns, own, spread = here.unknowns[:points], here.own[:, :points], ends * system.scale
    radius = np.hypot(own[..., 0], own[..., 1])
    return ContactPath(
        design=design,
        flank=flank,
        **{name: unknowns[:, k] for k, name in enumerate(UNKNOWNS)},
        point=here.point[0, :points],
        normal=here.normal[0, :points],
        pinion_z=own[0, :, 2],
        pinion_r=radius[0],
        gear_z=own[1, :, 2],
        gear_r=radius[1],
        transmission_error=phase[:points] - phase[-1],
        status=np.where(np.isnan(unknowns[:, 0]), Status.NOT_CONVERGED, Status.SOLVED).astype(np.int8),
        ends=PathEnds(
            l1=spread[:, 0],
            l2=spread[:, 2],
            pinion_roll=spread[:, 5],
            limit=system.margins(ends).argmin(axis=-1).astype(np.int8),
            contact_ratio=np.asarray(max(spans) * design.pinion.teeth / (2.0 * np.pi)),
            pieces=np.asarray(len(pieces)),
            status=np.asarray(Status.SOLVED, dtype=np.int8),
        ),
    )
