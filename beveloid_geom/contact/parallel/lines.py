"""Lines along which flanks on parallel axes touch, and the contact ratios of ISO 21771.

Unmodified flanks that fit each other touch along straight lines in their plane of action, which wander
over it with the roll; teeth without helix and cone along lines parallel to the axes, whatever their
profiles are.
`path_of_contact` crosses these lines from the first to the last; here each of them has its ends.

    eps_alpha = g_alpha / p_bt,   eps_beta = b tan(beta_b) / p_bt,   eps_gamma = eps_alpha + eps_beta

hold for cylindrical gears: path of contact in a transverse section g_alpha, common face width b,
transverse base pitch p_bt. Of members with cones the transverse ratio changes along the face: it is given
in the middle of the common face, eps_beta with the base helix angle of the flank, which differs between
right and left ones, and the total ratio by itself, from the roll between the first and the last line.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...design.model import Design
from ...status import Limit, Status
from ...support.few_lines import few_lines
from ..equation import Pairing, axial_and_radius, limit_margins, pairing_of, roll_angles
from ..path import ContactPath
from ..path_polynomial import HEIGHT, POINT, ROWS, rows_of
from .equation import along_axes, meet_on_parallel
from .paths import LINE, greatest_at, interval, kinds_of, on_lines

AT_EDGE = 1e-13
"""`interval`'s spare for the lines at the ends of a path, which lie along an edge but for rounding."""


@dataclass(frozen=True, eq=False)
class ContactLines:
    """Lines of contact of one flank pair at the rolls of its path, arrays (*batch, lines), of their two ends
    (*batch, lines, 2), and in S_f (*batch, lines, 2, 3).

    `pinion_roll`, `gear_roll` (rad); `length` (mm); of both ends `point`, and as in `ContactPath` `l1, l2,
    pinion_z, pinion_r, gear_z, gear_r` (mm); `limit`: codes of the `Limit` that ends the line. Batch shape:
    `transverse_ratio`, `overlap_ratio`, `total_ratio` (that of the path). NaN, and limits -1, where flanks
    do not touch along lines."""

    __repr__ = few_lines

    design: Design = field(repr=False)
    flank: str
    pinion_roll: FloatArray
    gear_roll: FloatArray
    length: FloatArray
    point: FloatArray
    l1: FloatArray
    l2: FloatArray
    pinion_z: FloatArray
    pinion_r: FloatArray
    gear_z: FloatArray
    gear_r: FloatArray
    limit: NDArray[np.int8]
    transverse_ratio: FloatArray
    overlap_ratio: FloatArray
    total_ratio: FloatArray


def touches_along_lines(design: Design, flank: str = "right") -> NDArray[np.bool_]:
    """Say (batch shape) whether flanks touch along lines: on parallel axes, with its errors, unmodified or
    along cylinders without helix."""
    pairing = pairing_of(design, flank)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return along_lines(pairing).reshape(design.batch_shape)


def along_lines(pairing: Pairing) -> NDArray[np.bool_]:
    """Say the same of the cases of a pairing. The caller silences NumPy's warnings."""
    found = pairing.parallel & ~pairing.undefined
    at = np.flatnonzero(found)
    if at.size:
        found[at] = kinds_of(pairing.cases(at))[0] == LINE
    return found


def contact_lines(path: ContactPath) -> ContactLines:
    """Find the lines along which flanks on parallel axes touch, one at each roll of a path.

    Parameters
    ----------
    path : ContactPath
        Of evenly spaced positions; it has the design and the flank.

    Returns
    -------
    ContactLines
        NaN where flanks touch in points, or not at all.
    """
    pairing, shape = pairing_of(path.design, path.flank), path.design.batch_shape
    l1 = path.l1.reshape(len(pairing.branch), -1)
    roll = path.pinion_roll.reshape(l1.shape)
    rows = np.full((HEIGHT, *l1.shape, 2), np.nan)
    limit = np.full((*l1.shape, 2), np.int8(-1))
    ratios = np.full((2, len(l1)), np.nan)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        solved = path.ends.status.reshape(-1) == Status.SOLVED
        at = np.flatnonzero(along_lines(pairing) & solved)
        if at.size:
            part = pairing.cases(at)
            found = _line_ends(part, l1[at], roll[at])
            rows[:, at] = found[:HEIGHT]
            limit[at] = found[HEIGHT:].argmin(axis=0)
            ratios[:, at] = _ratios(part)
    named = {name: rows[row].reshape(*shape, -1, 2) for name, row in ROWS.items()}
    point = np.moveaxis(rows[POINT], 0, -1)
    return ContactLines(
        design=path.design,
        flank=path.flank,
        length=np.linalg.norm(point[..., 1, :] - point[..., 0, :], axis=-1).reshape(*shape, -1),
        pinion_roll=named["pinion_roll"][..., 0],
        gear_roll=named["gear_roll"][..., 0],
        point=point.reshape(*shape, -1, 2, 3),
        **{name: named[name] for name in ("l1", "l2", "pinion_z", "pinion_r", "gear_z", "gear_r")},
        limit=limit.reshape(*shape, -1, 2),
        transverse_ratio=ratios[0].reshape(shape),
        overlap_ratio=ratios[1].reshape(shape),
        total_ratio=np.where(np.isnan(ratios[0].reshape(shape)), np.nan, path.ends.contact_ratio),
    )


def _line_ends(pairing: Pairing, l1: FloatArray, roll: FloatArray) -> FloatArray:
    """Give rows (WIDTH, cases, lines, 2) of both ends of the lines of given `roll` (cases, lines), rad, each
    through the contact at l1, mm; that nearer to the pinion's toe first.

    The contacts of one roll have w1 linear in it at each l1; the ends are the least and greatest l1 at
    which that lies within the limits. Along teeth without helix and cone it is l1 that the roll gives."""
    shape, along, lines = l1.shape, along_axes(pairing)[:, None], on_lines(pairing)

    def at_roll(l1: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give w1 at the roll and the first and last w1 within the limits, at l1 (cases, lines, samples)."""
        l, met = lines(l1.reshape(shape[0], -1))
        ends = interval(pairing, l, met, AT_EDGE)
        own = roll_angles(pairing, met)[0]
        rate = met.slope[0] / met.moment[0] + 0.0 * own
        own, rate, first, last = (x.reshape(l1.shape) for x in (own, rate, *ends))
        return (roll[..., None] - own) / rate, first, last

    def inside(l1: FloatArray) -> FloatArray:
        w, first, last = at_roll(l1)
        return np.where((first <= w) & (w <= last), l1, np.nan)

    ends = []
    for way, bound in ((-1.0, pairing.lowest[0]), (1.0, pairing.highest[0])):
        start = l1[..., None]
        found = greatest_at(inside, start, np.broadcast_to(bound[..., None], start.shape), way)
        found = np.where(np.isnan(found) | along[..., None], start, found)
        w, first, last = (x[..., 0] for x in at_roll(found))
        w = np.where(along, first if way < 0.0 else last, np.clip(w, first, last))
        l, _ = lines(found[..., 0])
        ends.append(rows_of(pairing, l, meet_on_parallel(pairing, l, w)))
    rows = np.stack(ends, axis=-1)
    swapped = rows[ROWS["pinion_z"], ..., :1] > rows[ROWS["pinion_z"], ..., 1:]
    return np.where(swapped, rows[..., ::-1], rows)


def _ratios(pairing: Pairing) -> FloatArray:
    """Give transverse contact ratio in the middle of the common face and overlap ratio, (2, cases)."""
    low = (pairing.position - pairing.half_width).max(axis=0)
    high = (pairing.position + pairing.half_width).min(axis=0)
    pitch, lines = 2.0 * np.pi / pairing.teeth[0], on_lines(pairing)

    def roll(l1: FloatArray) -> FloatArray:
        """Give the pinion's roll of contacts at l1 in the section, NaN beyond root and tip."""
        l, met = lines(l1)
        v, square = met.own[2, 0], met.square[0]
        axial, rate = v * met.along[0] + square * met.across[0], v * met.slope[0] + square
        met = meet_on_parallel(pairing, l, (0.5 * (low + high) - axial) / rate)
        z, radius = axial_and_radius(pairing, met)
        depth = limit_margins(pairing, l, z, radius)[: Limit.PINION_TOE].min(axis=0)
        return np.where(depth >= 0.0, roll_angles(pairing, met)[0], np.nan)

    ends = [roll(greatest_at(roll, pairing.lowest[0], pairing.highest[0], way)) for way in (-1.0, 1.0)]
    normal = pairing.rack.normal
    lean = np.abs(normal[2, 0] / (np.asarray(pairing.rack.pitch_radius)[0] * normal[1, 0]))
    return np.array(((ends[1] - ends[0]) / pitch, (high - low) * lean / pitch))[..., 0]
