"""How near a tooth of the gear is to the pinion's, point by point, and where it is nearest.

At a given roll of the pinion every point (s1, z1) of its flank and fillet is met by the gear's at
a roll T(s1, z1) of the gear (`separation`). The clearance is f = sigma (T - T0) g, in mm along the normal,
with a roll T0 to count from and the gear's lever g = m_n N2 cos(alpha) / 2. Its gradient is
explicit: if the pinion's point moves by dP and n is the gear's unit normal where they meet,

    dT = n.dP / (r_P2 n_y2),

so that f is stationary where the normals are opposed. The limits of both members are eight
functions c(s1, z1) >= 0 in the order of `status.Limit`, those of the gear through the meeting
point; a root limit is the end of the fillet here.

`least_clearances` goes from a start to a local least f within the limits by quadratic programs inside a
trust box (`support.quadratic_step`); the corner or edge on which such a program ends names the limits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..gear.tooth_side import Bends, Cut, Surface, cut_at, cut_with_bends, cut_with_turn, profile_at
from ..status import Limit
from ..support.quadratic_step import quadratic_step
from .separation import Pose, without_turns

WALLS = np.array(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)))[..., None]
PASSES, LAST_STEP = 60, 1e-7
"""Steps; share of the tooth depth below which a step is the last, as it leaves an error of its square."""
PENALTY = 150.0
"""Over the tooth depth: what the square of being outside a limit costs, beside the multiplier times it.
A cost in proportion would stop every step along a curved edge."""
FEASIBLE, NOISE = 1e-10, 1e-12
"""Shares of the tooth depth: outside a limit and still on it; f that means nothing."""
OVERLAP = 0.25
"""Share of the period after which two teeth meet again that may be overlap; clearances are larger."""
ALIKE = 1e-3
"""Shares of the first steps, within which places of searches count as the same."""
BLOCK = 2048


@dataclass(frozen=True, eq=False)
class Task:
    """Pinion rolls and poses, (n,): `roll` of the pinion, `start` (T0) of the gear, rad. After a turn of
    the gear by `period` (rad) the same two teeth can meet again."""

    own: Surface
    other: Surface
    lever: float
    pose: Pose
    roll: FloatArray
    start: FloatArray
    period: float = 2.0 * np.pi

    @property
    def depth(self) -> float:
        """Give the depth of the pinion's teeth, mm: what small lengths are shares of."""
        return self.own.tip - self.own.root

    def pick(self, index: Integers) -> Task:
        """Give the tasks `index`."""
        own, other, lever, pose, roll, start, period = vars(self).values()
        return Task(own, other, lever, pose.at(index), roll.take(index), start.take(index), period)

    @property
    def earliest(self) -> float:
        """Give the angle (rad), negative for overlap, from which on points are looked at over one period."""
        return -OVERLAP * self.period

    def counted(self, angle: FloatArray) -> FloatArray:
        """Give angles (rad) from half a turn either way to one turn, with that period in its middle."""
        least = -np.pi - self.earliest
        return np.where(angle < least, angle + 2.0 * np.pi, angle)

    def later(self, periods: Integers) -> Task:
        """Give the tasks counted from a roll of the gear so many `periods` (n,) on."""
        return replace(self, start=self.start + self.period * periods)


@dataclass(frozen=True, eq=False)
class Local:
    """f (n) with its `slope` (2, n) by (s1, z1) and `bend` (3, n) by twice s1, both and twice z1, the limits'
    `margin` (8, n) with `rate` (8, 2, n) and `curve` (8, 3, n), and `meeting` (2, n): s2 and z2; mm."""

    f: FloatArray
    slope: FloatArray
    bend: FloatArray
    margin: FloatArray
    rate: FloatArray
    curve: FloatArray
    meeting: FloatArray

    def merit(self, weight: FloatArray, depth: float) -> FloatArray:
        """Give f less the margins times their multipliers (8, n), with a cost of being outside; infinite
        where the gear has no such point."""
        outside = np.minimum(self.margin, 0.0)
        merit = self.f + (PENALTY / depth * outside * outside - weight * self.margin).sum(axis=0)
        return np.where(np.isnan(merit), np.inf, merit)

    def pick(self, index: Integers) -> Local:
        """Give the places with the numbers `index`."""
        return Local(*(value.take(index, axis=-1) for value in vars(self).values()))

    def where_not(self, moved: Mask, there: Local) -> Local:
        """Give these places, but those `there` where `moved` (n,)."""
        rows = zip(vars(self).values(), vars(there).values(), strict=True)
        return Local(*(np.where(moved, new, old) for old, new in rows))


@dataclass(frozen=True, eq=False)
class Least:
    """Local least values: `place` (2, n): s1 and z1; `f` (n); `meeting` (2, n); mm. `limit` (2, n):
    codes of the limits it lies on, -1 for none; `outside` (n), mm; `converged` (n)."""

    place: FloatArray
    f: FloatArray
    meeting: FloatArray
    limit: Codes
    outside: FloatArray
    converged: Mask

    def pick(self, index: Integers) -> Least:
        """Give the results with the numbers `index`."""
        return Least(*(value.take(index, axis=-1) for value in vars(self).values()))

    def and_also(self, *others: Least) -> Least:
        """Give these and others, in order."""
        values = zip(*(vars(part).values() for part in (self, *others)), strict=True)
        return Least(*(np.concatenate(parts, axis=-1) for parts in values))


def _seen(task: Task, z: FloatArray, cut: Cut, bends: Bends | None = None) -> FloatArray:
    """Give the pinion's points x, y, z2 as the gear sees them, their derivatives by s1, z1 and, with `bends`,
    twice s1, both and twice z1: (3, 3, n) or (3, 6, n)."""
    pose, turned = task.pose, cut.phi + task.roll
    x, y = np.empty((2, 3 if bends is None else 6, z.size))
    # A point that turns by phi moves by (x', y') and phi' times its own place a quarter turn on.
    x[0], y[0] = cut.x, cut.y
    x[1], y[1] = cut.x_s - cut.phi_s * cut.y, cut.y_s + cut.phi_s * cut.x
    x[2], y[2] = cut.x_z - cut.phi_z * cut.y, cut.y_z + cut.phi_z * cut.x
    if bends is not None:
        x[3] = bends.x_ss - bends.phi_ss * cut.y - cut.phi_s * (cut.y_s + y[1])
        y[3] = bends.y_ss + bends.phi_ss * cut.x + cut.phi_s * (cut.x_s + x[1])
        x[4] = -bends.phi_sz * cut.y - cut.phi_z * cut.y_s - cut.phi_s * y[2]
        y[4] = bends.y_sz + bends.phi_sz * cut.x + cut.phi_z * cut.x_s + cut.phi_s * x[2]
        x[5], y[5] = -cut.phi_z * (cut.y_z + y[2]), cut.phi_z * (cut.x_z + x[2])
    cos, sin = np.cos(turned), np.sin(turned)
    across = sin * x + cos * y
    seen = np.empty((3, *x.shape))
    np.subtract(sin * y, cos * x, out=seen[0])
    np.multiply(-pose.cos, across, out=seen[1])
    np.multiply(pose.sin, across, out=seen[2])
    seen[0, 0] += pose.offset
    ahead = z + pose.position[0]
    seen[1, 0] += pose.sin * ahead
    seen[2, 0] += pose.cos * ahead - pose.position[1]
    seen[1, 2] += pose.sin
    seen[2, 2] += pose.cos
    return seen


def limits_at(task: Task, s: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give margins (8, n) and their rates (8, 2, n) by s1 and z1 at places (n,), mm."""
    cut = cut_at(task.own, s, z)
    seen = _seen(task, z, cut)
    rows = _limits(task, s, z, (_squares(cut), _squares_seen(seen)), seen[2])
    return rows[:, 0], rows[:, 1:]


def _squares(cut: Cut, bends: Bends | None = None) -> FloatArray:
    """Give r^2 of points and half its derivatives by s, z and, with `bends`, twice s, both and twice z,
    (3, n) or (6, n)."""
    x, y = cut.x, cut.y
    rows = np.empty((3 if bends is None else 6, x.size))
    rows[0], rows[1], rows[2] = x * x + y * y, x * cut.x_s + y * cut.y_s, x * cut.x_z + y * cut.y_z
    if bends is not None:
        rows[3] = cut.x_s * cut.x_s + cut.y_s * cut.y_s + x * bends.x_ss + y * bends.y_ss
        rows[4] = cut.x_s * cut.x_z + cut.y_s * cut.y_z + y * bends.y_sz
        rows[5] = cut.x_z * cut.x_z + cut.y_z * cut.y_z
    return rows


def _squares_seen(seen: FloatArray) -> FloatArray:
    """Give r^2 of points as seen by the gear and half its derivatives, as many as those of the points."""
    x, y, _ = seen
    rows: FloatArray = x[0] * x + y[0] * y
    if len(rows) > 3:
        rows[3:5] += x[1] * x[1:3] + y[1] * y[1:3]
        rows[5] += x[2] * x[2] + y[2] * y[2]
    return rows


def _rooted(rows: FloatArray) -> FloatArray:
    """Give a root and its derivatives, (3, n) or (6, n), from its square and half the derivatives of that."""
    root = np.sqrt(rows[0])
    rows = rows / root
    if len(rows) > 3:
        over = rows[1:3] / root
        rows[3:5] -= rows[1] * over
        rows[5] -= rows[2] * over[1]
    return rows


def _limits(
    task: Task, s: FloatArray, z: FloatArray, squares: tuple[FloatArray, FloatArray], high: FloatArray
) -> FloatArray:
    """Give margins, in the order of `Limit`, with their derivatives, (8, 3, n) or (8, 6, n), from those of
    r^2 on either member and of the gear's z, `high`."""
    own, other, (radii, other_radii) = task.own, task.other, (_rooted(rows) for rows in squares)
    rows = np.zeros((len(Limit), *high.shape))
    rows[Limit.PINION_ROOT, 1] = 1.0
    rows[Limit.GEAR_ROOT] = other_radii - other.root_taper * high
    np.negative(radii, out=rows[Limit.PINION_TIP])
    rows[Limit.GEAR_TIP] = other.taper * high - other_radii
    rows[Limit.PINION_TOE, 2], rows[Limit.PINION_HEEL, 2] = 1.0, -1.0
    rows[Limit.GEAR_TOE] = high
    np.negative(high, out=rows[Limit.GEAR_HEEL])
    rows[Limit.PINION_TIP, 2] += own.taper
    rows[Limit.PINION_ROOT, 0] = s - own.bottom
    rows[Limit.GEAR_ROOT, 0] -= other.root
    rows[Limit.PINION_TIP, 0] += own.tip + own.taper * z
    rows[Limit.GEAR_TIP, 0] += other.tip
    rows[Limit.PINION_TOE, 0], rows[Limit.PINION_HEEL, 0] = own.half_width + z, own.half_width - z
    rows[Limit.GEAR_TOE :: 2, 0] += other.half_width
    return rows


def square(rows: FloatArray) -> FloatArray:
    """Give second derivatives (..., 2, 2, n) from those by twice s1, both and twice z1, (..., 3, n)."""
    return rows[..., [[0, 1], [1, 2]], :]


def clearance_at(task: Task, s: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the clearance f (n,), its slope (2, n) by s1 and z1, and s2 where places (s1, z1) meet, mm."""
    other, cut = task.other, cut_at(task.own, s, z)
    seen = _seen(task, z, cut)
    x, y, high = seen[:, 0]
    square = x * x + y * y
    other_s = profile_at(other, square, high)
    met = cut_at(other, other_s, high)
    f, cos, sin = _turn(task, x, y, met)
    normal = _turned(np.array((met.nx, met.ny, met.nz)) / met.ny, cos / square, sin / square)
    scale = other.sigma * task.lever / other.pitch_radius
    return f, scale * (normal[:, None] * seen[:, 1:3]).sum(axis=0), other_s


def _turn(task: Task, x: FloatArray, y: FloatArray, met: Cut) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give f of points at x, y from the points of the gear's surface that they meet; and, times r^2, cosine
    and sine of the angle from those before they turn."""
    other, cos, sin = task.other, x * met.x + y * met.y, y * met.x - x * met.y
    # Angle between the point and the cut point as one arctangent, small at contact.
    turn = np.arctan2(sin, cos) - met.phi - task.start
    return task.counted(other.sigma * without_turns(turn)) * task.lever, cos, sin


def local_at(task: Task, s: FloatArray, z: FloatArray) -> Local:
    """Give the clearance and its derivatives at places (s1, z1), each (n,), mm."""
    other = task.other
    cut, bends = cut_with_bends(task.own, s, z)
    seen = _seen(task, z, cut, bends)
    x, y, high = seen[:, 0]
    squares, moves = _squares_seen(seen), seen[:, 1:3]
    other_s = profile_at(other, squares[0], high)
    met, by_other = cut_with_turn(other, other_s, high)
    f, cos, sin = _turn(task, x, y, met)
    cos, sin = cos / squares[0], sin / squares[0]
    own = np.array((met.nx, met.ny, met.nz)) / met.ny
    normal, bent = _turned(own, cos, sin), _turned((by_other - by_other[1] * own) / met.ny, cos, sin)
    scale = other.sigma * task.lever / other.pitch_radius
    slope = (normal[:, None] * moves).sum(axis=0)
    # As the place moves, the point met moves along the profile, and its normal turns.
    along, across = met.x * met.x_s + met.y * met.y_s, met.x * met.x_z + met.y * met.y_z
    met_s = (squares[1:3] - across * moves[2]) / along
    turned = slope / other.pitch_radius + met.phi_s * met_s + met.phi_z * moves[2]
    change = bent[:, None] * met_s
    change[0] -= turned * normal[1]
    change[1] += turned * normal[0]
    bend = (normal[:, None] * seen[:, 3:]).sum(axis=0)
    bend[::2] += (moves * change).sum(axis=0)
    bend[1] += 0.5 * (moves * change[:, ::-1]).sum(axis=(0, 1))
    rows = _limits(task, s, z, (_squares(cut, bends), squares), seen[2])
    return Local(
        f=f,
        slope=scale * slope,
        bend=scale * bend,
        margin=rows[:, 0],
        rate=rows[:, 1:3],
        curve=rows[:, 3:],
        meeting=np.array((other_s, high)),
    )


def _turned(rows: FloatArray, cos: FloatArray, sin: FloatArray) -> FloatArray:
    """Give vectors (3, n) turned about the third axis."""
    return np.array((cos * rows[0] - sin * rows[1], sin * rows[0] + cos * rows[1], rows[2]))


def least_clearances(task: Task, place: FloatArray, box: FloatArray, owner: Integers) -> Least:
    """Give the local least clearance that each start `place` (2, n) leads to; `box` (2, n): how far the first
    step may go, and all steps along the profile of a fillet; mm. Of starts with the same `owner` (n,) that
    lead to the same place one is followed there, the others end as `outside` as can be."""
    parts = []
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        every = np.arange(place.shape[1])
        for start in range(0, max(1, every.size), BLOCK):
            block = every[start : start + BLOCK]
            parts.append(_least(task.pick(block), place[:, block], box[:, block], owner[block]))
    return parts[0].and_also(*parts[1:])


def _least(task: Task, place: FloatArray, box: FloatArray, owner: Integers) -> Least:
    n, depth = place.shape[1], task.depth
    here = local_at(task, *place)
    least = Least(
        place=place.copy(),
        f=here.f.copy(),
        meeting=here.meeting.copy(),
        limit=np.full((2, n), -1, dtype=np.int8),
        outside=np.maximum(-here.margin.min(axis=0), 0.0),
        converged=np.zeros(n, dtype=bool),
    )
    going = np.flatnonzero(np.isfinite(here.f))
    if going.size < n:
        task, place, box, here = task.pick(going), place[:, going], box[:, going], here.pick(going)
    weight, reach = np.zeros((len(Limit), going.size)), np.ones(going.size)
    unit = ALIKE * box.max(axis=1, initial=0.0, keepdims=True)
    for count in range(PASSES):
        # Longer steps along the profile only where it is convex, off the fillets.
        size = np.array((np.where(here.bend[0] > 0.0, reach, np.minimum(reach, 1.0)), reach)) * box
        lines = np.concatenate((here.rate, WALLS.repeat(going.size, axis=2)))
        margin = np.concatenate((here.margin, size, size))
        bend = here.bend - (weight[:, None] * here.curve).sum(axis=0)
        step, active, multiplier = quadratic_step(here.slope, bend, lines, margin, size, FEASIBLE * depth)
        boxed = (active >= len(Limit)).any(axis=0)
        small = (np.abs(step) <= LAST_STEP * depth).all(axis=0) & ~boxed
        there = local_at(task, *(place + step))
        pull = np.maximum(multiplier[: len(Limit)], 0.0)
        better = there.merit(pull, depth) <= here.merit(pull, depth) + NOISE * depth
        if better.all():
            place, here, weight = place + step, there, pull
        else:
            place, weight = np.where(better, place + step, place), np.where(better, pull, weight)
            here = here.where_not(better, there)
        reach = reach * np.where(better, np.where(boxed, 2.0, 1.0), 0.25)
        found, doubled = small & better, np.zeros(going.size, dtype=bool)
        if count:  # those that come where another is going, or has ended
            near, met = np.flatnonzero(better & ~boxed & ~found), np.flatnonzero(least.converged)
            ways = np.concatenate((least.place[:, met], place[:, near]), axis=1) / unit
            limits = np.concatenate((least.limit[:, met], active[:, near]), axis=1)
            owners = owner[np.append(met, going[near])]
            doubled[near] = repeated(np.array((*np.rint(ways), *limits, owners)))[met.size :]
        done = found | doubled | (reach <= 1e-12) | (count == PASSES - 1)
        if not done.any():
            continue
        ended, stays = going[done], np.flatnonzero(~done)
        least.place[:, ended], least.f[ended], least.meeting[:, ended] = (
            row[..., done] for row in (place, here.f, here.meeting)
        )
        least.limit[:, ended], least.converged[ended] = active[:, done], found[done]
        least.outside[ended] = np.where(doubled, np.inf, np.maximum(-here.margin.min(axis=0), 0.0))[done]
        if not stays.size:
            break
        task, here, going, reach = task.pick(stays), here.pick(stays), going[stays], reach[stays]
        place, box, weight = (rows.take(stays, axis=1) for rows in (place, box, weight))
    limit = np.sort(np.where(least.limit >= len(Limit), -1, least.limit), axis=0)[::-1]
    return replace(least, limit=limit)


def repeated(columns: FloatArray) -> Mask:
    """Say which columns (k, n) are the same as one before them."""
    order = np.lexsort(columns)
    doubled = np.zeros(order.size, dtype=bool)
    doubled[order[1:]] = (columns[:, order[1:]] == columns[:, order[:-1]]).all(axis=0)
    return doubled
