"""Transmission error of a pair whose teeth differ, over all pairs of teeth.

Teeth differ by pitch deviations and by measured deviations of single teeth (`FlankDeviations.teeth`).

Let e(roll) be the transmission error of one tooth pair without pitch deviations, where roll is the roll of
its pinion tooth. Let r_b and beta_b be base radius and base helix angle, and sigma = +1 on right flanks and
-1 on left flanks. A deviation p1 (mm along the normal) of the pinion tooth rotates this tooth by sigma p1 /
(r_b1 cos(beta_b1)), and a deviation p2 rotates the gear tooth. The transmission error of this pair is then

    e(roll + sigma p1 / (r_b1 cos(beta_b1))) + (p1 + p2) / (r_b2 cos(beta_b2)),

and the tooth pair with the largest error is in contact. These relations are exact. The error repeats when the
same two teeth meet again: after as many pitches as the least common multiple of the numbers of teeth. If only
one member has deviations, it repeats after one turn of this member. The measured flanks of both teeth are
part of e, which is computed for each combination of their tables.

Teeth are counted from tooth 0 in the direction of positive rotation, from x to y of the gear frame. Tooth
pair k consists of pinion tooth k and gear tooth -k.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product
from math import lcm

import numpy as np

from ..arrays import FloatArray, Indices, flank_sign
from ..design.arguments import require_single
from ..design.member import MODIFICATIONS, Member
from ..design.model import Design
from ..design.modification import Modification
from ..status import FirstStatus
from ..support.array_repr import short_repr
from .engagement import pitch_point_roll, spread
from .first_contact import first_contact


@dataclass(frozen=True, eq=False)
class PitchCycle:
    """Transmission error with pitch deviations at equally spaced pinion rolls, arrays (pitches, points).

    Attributes
    ----------
    design : Design
    flank : {'right', 'left'}
    pinion_roll : ndarray
        Pinion rolls, rad. The first is the roll at which the flank of tooth 0 passes the pitch point.
    transmission_error : ndarray
        rad, positive where the gear is ahead of the unmodified pair; NaN where no teeth touch.
    pinion_tooth, gear_tooth : ndarray of int
        Numbers of the teeth in contact; 0 where no teeth touch.
    """

    __repr__ = short_repr

    design: Design = field(repr=False)
    flank: str
    pinion_roll: FloatArray
    transmission_error: FloatArray
    pinion_tooth: Indices
    gear_tooth: Indices

    @property
    def pitches(self) -> int:
        """Number of pitches after which the transmission error repeats."""
        return len(self.pinion_roll)

    @property
    def teeth(self) -> tuple[Indices, Indices]:
        """Numbers of the teeth of pinion and gear in contact."""
        return self.pinion_tooth, self.gear_tooth

    @property
    def peak_to_peak(self) -> float:
        """Peak-to-peak value at these rolls, rad."""
        return float(np.ptp(self.transmission_error))


def pitch_cycle(design: Design, flank: str = "right", points: int = 24) -> PitchCycle:
    """Compute the transmission error over all pairs of teeth, with the deviations of each tooth.

    Parameters
    ----------
    design : Design
        A single design, with or without pitch deviations (`Modification.pitch_deviations_um`) and tables of
        measured deviations of single teeth (`FlankDeviations.teeth`).
    flank : {'right', 'left'}
    points : int
        Number of rolls in each pitch.

    Returns
    -------
    PitchCycle

    Raises
    ------
    ValueError
        For a batch of designs, for points that are not a whole number of at least 1, for more than
        20,000 pitches or 400 pairs of measured teeth.

    References
    ----------
    Method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> from dataclasses import replace
    >>> design = bg.builtin_design("ni-2017")
    >>> deviations = bg.Modification(pitch_deviations_um=(4.0, *[0.0] * 28))
    >>> cycle = bg.pitch_cycle(replace(design, pinion=design.pinion.modified(deviations)), points=4)
    >>> cycle.pitches
    29
    """
    require_single(design)
    if not isinstance(points, int | np.integer) or isinstance(points, bool) or points < 1:
        raise ValueError(f"points must be a whole number of at least 1, got {points!r}")
    teeth = [int(member.teeth) for member in design.members]
    amounts = [_amounts(member, flank) for member in design.members]
    shapes = [_members(member, flank) for member in design.members]
    pitches = lcm(*map(_period, teeth, amounts, map(len, shapes)))
    _check_numbers(pitches, len(shapes[0]) * len(shapes[1]))
    pitch = 2.0 * np.pi / teeth[0]
    roll = np.asarray(pitch_point_roll(design, flank) + pitch / points * np.arange(points))
    error, pairs = _errors_alone(design, flank, roll, amounts, shapes)
    # In each pitch, the numbers of the pairs decrease by 1.
    number = pairs - np.arange(pitches)[:, None]
    pinion, gear = number % teeth[0], -number % teeth[1]
    with np.errstate(invalid="ignore"):
        shift = (amounts[0][pinion] + amounts[1][gear]) / _lever(design.gear)
        ahead = error[pinion, gear % len(shapes[1]), np.arange(pairs.size)] + shift[..., None]
    first = ahead.argmax(axis=1)
    largest = np.take_along_axis(ahead, first[:, None], axis=1)[:, 0]
    lost = ~np.isfinite(largest)
    return PitchCycle(
        design=design,
        flank=flank,
        pinion_roll=roll + pitch * np.arange(pitches)[:, None],
        transmission_error=np.where(lost, np.nan, largest),
        pinion_tooth=np.where(lost, 0, np.take_along_axis(pinion, first, axis=1)),
        gear_tooth=np.where(lost, 0, np.take_along_axis(gear, first, axis=1)),
    )


def _check_numbers(pitches: int, pairs: int) -> None:
    """Raise ValueError for too many pitches of a cycle, or too many pairs of measured teeth."""
    max_pitches, max_pairs = 20_000, 400  # a pair of measured teeth takes 0.05 to 0.2 s
    if pitches > max_pitches:
        cure = "give the deviations of the teeth of one member only"
        raise ValueError(
            f"deviations of teeth must repeat within {max_pitches} pitches, got {pitches}: {cure}"
        )
    if pairs > max_pairs:
        cure = "use fewer measured teeth of one member"
        raise ValueError(f"measured teeth must form at most {max_pairs} pairs, got {pairs}: {cure}")


def _amounts(member: Member, flank: str) -> FloatArray:
    """Return the pitch deviations of all teeth of a member, mm."""
    given = member.pitch_deviations(flank)
    return np.zeros(int(member.teeth)) if given is None else 1e-3 * np.array(given)


def _lever(member: Member) -> float:
    """Return r_b cos(beta_b) of a member, mm."""
    tool = member.tool
    return 0.5 * float(tool.normal_module * member.teeth * np.cos(tool.normal_pressure_angle))


def _members(member: Member, flank: str) -> list[Member]:
    """Return the member with the table of each measured tooth; the member itself without such tables."""
    given: Modification | None = getattr(member, MODIFICATIONS[flank])
    tables = member.tooth_deviations(flank)
    if given is None or not tables:
        return [member]
    return [member.modified(replace(given, deviations=table), flank) for table in tables]


def _period(teeth: int, amounts: FloatArray, tables: int) -> int:
    """Return the number of pitches after which the deviations of a member repeat."""
    return teeth if amounts.any() or teeth % tables else tables


def _errors_alone(
    design: Design, flank: str, roll: FloatArray, amounts: list[FloatArray], shapes: list[list[Member]]
) -> tuple[FloatArray, Indices]:
    """Return the transmission error of single tooth pairs, rad, for each pinion tooth and each table of the
    gear (teeth, tables, pairs, rolls), and the numbers of the pairs at the given rolls (pairs,).

    It is minus infinity where a pair does not touch, or is so late that it is never in contact."""
    reach = 2 + int(np.ceil(spread(design, flank)))
    pairs = np.arange(-reach, reach + 1)
    pair_rolls = roll + 2.0 * np.pi / float(design.pinion.teeth) * pairs[:, None]
    turn = flank_sign(flank) * amounts[0] / _lever(design.pinion)
    designs = {
        (a, b): replace(design, pinion=pinion, gear=gear)
        for (a, pinion), (b, gear) in product(*map(enumerate, shapes))
    }
    # `near`: pairs that can be in contact. The others remain behind even with the largest deviations. The
    # error of an edge contact falls by less than 0.5 rad per rad of roll.
    nominal = np.array([_alone(one, flank, pair_rolls) for one in designs.values()])
    shift = sum(float(np.ptp(np.append(values, 0.0))) for values in amounts) / _lever(design.gear)
    near = nominal.max(axis=0) >= nominal.min(axis=0).max(axis=0) - 2.0 * shift - np.abs(turn).max()
    # Pinion teeth with the same deviation and the same table have the same errors.
    table = np.arange(turn.size) % len(shapes[0])
    kinds, number = np.unique(np.stack((turn, table)), axis=1, return_inverse=True)
    error = np.full((kinds.shape[1], len(shapes[1]), *pair_rolls.shape), -np.inf)
    for a, b in designs:
        rows = np.flatnonzero(kinds[1] == a)
        known = error[rows, b]
        known[:, near] = _alone(designs[a, b], flank, pair_rolls[near] + kinds[0, rows, None])
        error[rows, b] = known
    return error[number.ravel()], pairs


def _alone(design: Design, flank: str, roll: FloatArray) -> FloatArray:
    """Return the transmission error (rad) of tooth pair 0 alone at pinion rolls, rad."""
    first = first_contact(design, flank, roll.ravel(), (0,))
    known = first.status == FirstStatus.SOLVED
    return np.where(known, first.transmission_error, -np.inf).reshape(roll.shape)
