"""Path of contact by the method of the paper: five equations for each position (Eq. 15).

The contacts are followed as a curve by its length (`five_equations_curve`). Paths along which the pinion roll
or l1 turns back, or n_x (the component of the common normal along the common perpendicular of the axes)
changes sign, need no special treatment. At an end of the path, the contact reaches a limit of a flank: the
smallest of its distances from the limits is zero there. The method shares with the one-equation method only
the flanks, the frames and the first starting value, which is moved off the solution. If the one-equation
method has no result, the start is the rough pitch point of the unmodified pair (`pitch_region`), from which
coefficients and errors are introduced step by step.

The method takes about a thousand times as long as the one equation, and solves single designs only. A curve
of contacts that is not connected with the starting value is not found. If flanks touch along lines, each roll
has an infinite number of contacts, so that the equations are singular."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, flank_sign, gear_sense
from ..contact.parallel.lines import is_line_contact
from ..contact.path import ContactPath, PathEnds, path_of_contact, require_points
from ..design.arguments import require_unmodified
from ..design.model import Design, Errors
from ..status import Status
from .five_equations_curve import (
    LARGEST_STEP,
    FiveCurve,
    FiveEquations,
    Unknown,
    five_equations_of,
    follow_five_equations,
)
from .pitch_region import pitch_guess


def path_of_contact_five_equations(design: Design, flank: str = "right", points: int = 101) -> ContactPath:
    """Compute the path of contact of a single design by the five equations of the paper.

    Positions are evenly spaced in pinion roll; in l1 if the roll turns back along the path; and in length
    along the curve if l1 turns back as well.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    points : int
        Number of positions, at least 2.

    Returns
    -------
    ContactPath
        Empty if both methods find no contact on the flanks, and if the inputs leave nothing to solve
        (UNDEFINED).

    Raises
    ------
    ValueError
        For a batch, or fewer than two points.
    ArithmeticError
        For flanks with line contact; if the solver finds no contact, or loses it on the flanks.
    """
    require_unmodified(flank, "the five equations", pinion=design.pinion, gear=design.gear)
    if design.batch_shape:
        raise ValueError("the five equations are solved for single designs, not for batches")
    require_points(points)
    if is_line_contact(design, flank):
        reason = "because line contact has an infinite number of contacts at each roll"
        raise ArithmeticError(f"the five equations are singular, {reason}: use the one-equation method")
    guide = path_of_contact(design, flank, 3)
    if guide.ends.status == Status.UNDEFINED:
        return guide
    system = five_equations_of(design, flank)
    # Displacement of the starting value from the solution of the one equation, mm and rad.
    off_solution = np.array([1e-3, -2e-3, -1e-3, 2e-3, 1e-5, 0.0])
    with np.errstate(all="ignore"):
        if guide.ends.status == Status.SOLVED:
            start = np.array([getattr(guide, one.name.lower())[1] for one in Unknown]) + off_solution
            start_contact = nearest_contact(system, start / system.scale)
        else:
            start_contact = _from_pitch_point(design, flank)
        curve = None if start_contact is None else follow_five_equations(system, start_contact)
        pieces = np.empty((0, 2)) if curve is None else curve.pieces()
        if curve is not None and len(pieces):
            return _result(design, flank, curve, pieces, points)
    if guide.ends.status in (Status.OFF_FLANK, Status.NO_COMMON_NORMAL):
        return guide
    where = "to start from" if curve is None else "on the flanks along the curve they follow"
    raise ArithmeticError(f"the five equations find no contact {where}")


def _span(curve: FiveCurve, piece: FloatArray) -> float:
    """Return the pinion roll (rad) covered by a segment of the curve."""
    stops = np.concatenate((piece, curve.turns(Unknown.PINION_ROLL, (piece[0], piece[1]))))
    return float(
        np.ptp([curve.at(s)[Unknown.PINION_ROLL] for s in stops]) * curve.system.scale[Unknown.PINION_ROLL]
    )


def _positions(curve: FiveCurve, piece: FloatArray, ends: FloatArray, share: FloatArray) -> list[FloatArray]:
    """Return the scaled unknowns at shares `share` in [0, 1] of a segment with these ends; NaN if lost."""
    # Number of points of the spline in which starting values for a given roll or l1 are looked up.
    spline_points = 2001
    between = float(piece.min()), float(piece.max())
    row = next(
        (row for row in (Unknown.PINION_ROLL, Unknown.L1) if curve.turns(row, between).size == 0), None
    )
    if row is None:
        return [curve.at(s) for s in piece[0] + (piece[1] - piece[0]) * share]
    across, dense = np.eye(6)[row], np.linspace(*between, spline_points)
    values = curve.spline(dense)[:, row]
    order = np.argsort(values)
    positions = []
    for goal in ends[0, row] + (ends[1, row] - ends[0, row]) * share:
        start = curve.spline(np.interp(goal, values[order], dense[order]))
        start[row] = goal
        position = curve.system.correct(start, across)
        near = position is not None and np.linalg.norm(position - start) < LARGEST_STEP
        positions.append(position if position is not None and near else np.full(6, np.nan))
    return positions


def nearest_contact(system: FiveEquations, start: FloatArray) -> FloatArray | None:
    """Return the contact in the plane through `start` perpendicular to the curve, scaled; None if there is
    none."""
    tangent = system.tangent(start)
    return None if tangent is None else system.correct(start, tangent)


def _from_pitch_point(design: Design, flank: str) -> FloatArray | None:
    """Return a contact of the design, scaled, continued from the pitch point of the unmodified pair; None if
    it is lost."""
    errors, (a1, a2) = design.errors, (member.tool.parabola_of(flank) for member in design.members)

    def part(share: float) -> FiveEquations:
        """Return the equations with a share of the coefficients and errors."""
        partly = Errors(**{name: share * value for name, value in vars(errors).items()})
        return five_equations_of(design.with_parabola(share * a1, share * a2).with_errors(partly), flank)

    system = part(0.0)
    try:
        *parameters, pinion_roll, gear_roll = pitch_guess(design, flank)
    except ArithmeticError:  # the pitch cones have no common tangent plane
        return None
    known = nearest_contact(system, np.array((*parameters, gear_roll, pinion_roll)) / system.scale)
    done, step = 0.0, 0.25
    # Largest change of the scaled unknowns in a step in which coefficients and errors are introduced, and
    # smallest share of them in a step.
    largest_move, smallest_share = 0.3, 1e-4
    while known is not None and done < 1.0:
        ahead = min(done + step, 1.0)
        system = part(ahead)
        contact = nearest_contact(system, known)
        if contact is not None and np.linalg.norm(contact - known) <= largest_move:
            done, known, step = ahead, contact, 2.0 * step
        elif step < smallest_share:
            return None
        else:
            step *= 0.5
    return known


def _result(design: Design, flank: str, curve: FiveCurve, pieces: FloatArray, points: int) -> ContactPath:
    system, ratio = curve.system, design.pinion.teeth / design.gear.teeth
    spans = [_span(curve, piece) for piece in pieces]
    piece = pieces[int(np.argmax(spans))]
    ends = np.array([curve.end(s) for s in piece])
    if flank_sign(flank) * (ends[1, Unknown.PINION_ROLL] - ends[0, Unknown.PINION_ROLL]) < 0.0:
        piece, ends = piece[::-1], ends[::-1]
    positions = _positions(curve, piece, ends, np.append(np.linspace(0.0, 1.0, points), 0.5))
    positions[0], positions[points - 1] = ends
    here = system.at(np.array(positions) * system.scale)
    ahead = gear_sense(flank) * (here.unknowns[:, 4] + ratio * here.unknowns[:, 5])
    unknowns, points_on_members = here.unknowns[:points], here.member_points[:, :points]
    spread, radius = ends * system.scale, np.hypot(points_on_members[..., 0], points_on_members[..., 1])
    return ContactPath(
        design=design,
        flank=flank,
        **{one.name.lower(): unknowns[:, one] for one in Unknown},
        point=here.point[0, :points],
        normal=here.normal[0, :points],
        pinion_z=points_on_members[0, :, 2],
        pinion_r=radius[0],
        gear_z=points_on_members[1, :, 2],
        gear_r=radius[1],
        transmission_error=ahead[:points] - ahead[-1],
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
