"""Clearance between the pinion's tooth surface and the mating gear tooth, with derivatives.

At a given pinion roll, each point (s1, z1) of the pinion's flank and fillet is touched by the gear at a gear
roll T(s1, z1) (`angular_clearance`). The clearance along the normal is

    f = sigma (T - T0) g,   g = m_n N2 cos(alpha) / 2,

with sigma = +1 on right flanks and -1 on left flanks, a reference roll T0, and the lever g of the gear, mm.
If the pinion's point moves by dP and n is the unit normal of the gear at the touched point, then

    dT = n.dP / (r_P2 n_y2),

so that f is stationary where the normals of both surfaces are opposed. r_P2 is the pitch radius of the gear,
and n_y2 is the component of n in the gear's frame of generation (`gear.generation`). On a modified gear, n
belongs to the generated surface without the modification. The modification rotates the points of this surface
about +z by psi2(s2, z2) (`turn_rows`; -sigma psi of `gear.modification`), which adds -sigma g psi2 to f.

The limits of both members are eight functions c(s1, z1) >= 0 in the order of `status.Limit`; the limits of
the gear are evaluated at the touched point. The root limit is the beginning of the bottom land. An undercut
tooth has an edge at which flank and fillet intersect. A task is either on its flank or on its fillet, and
both continue smoothly a little beyond the edge. The root limit of the flank is then this edge. The root limit
of the fillet is the edge or the bottom land, whichever is nearer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.crossing_curve import CrossingCurve
from ...gear.tooth_side import (
    END,
    RADIUS,
    START,
    Bends,
    Cut,
    cut_at,
    cut_with_bends,
    cut_with_normal_rate,
    generated_bends,
    generated_cut,
    profile_at,
    turn_rows,
)
from ...status import Limit
from ..angular_clearance import without_turns
from .search_task import Task, seen_by_gear


@dataclass(frozen=True, eq=False)
class Local:
    """Clearance at places (s1, z1) with derivatives, and the limits there; mm.

    Attributes
    ----------
    f : ndarray, shape (n,)
    slope : ndarray, shape (2, n)
        First derivatives of f by s1 and z1.
    bend : ndarray, shape (3, n)
        Second derivatives by s1 s1, s1 z1 and z1 z1.
    margin, rate, curve : ndarray, shapes (8, n), (8, 2, n) and (8, 3, n)
        Limits c >= 0 with first and second derivatives.
    meeting, meeting_rate : ndarray, shapes (2, n) and (2, 2, n)
        s2 and z2 of the touched point of the gear, with their derivatives.
    """

    f: FloatArray
    slope: FloatArray
    bend: FloatArray
    margin: FloatArray
    rate: FloatArray
    curve: FloatArray
    meeting: FloatArray
    meeting_rate: FloatArray

    def merit(self, weight: FloatArray, depth: float) -> FloatArray:
        """Return the merit function: the Lagrange function with multipliers `weight` (8, n) plus a
        quadratic penalty on violated limits; infinite where the gear has no point at this radius."""
        # The quadratic penalty does not stop steps along curved edges, as a linear one would.
        outside = np.minimum(self.margin, 0.0)
        merit = self.f + (150.0 / depth * outside * outside - weight * self.margin).sum(axis=0)
        return np.where(np.isnan(merit), np.inf, merit)

    def after(self, step: FloatArray) -> Local:
        """Return the values after small steps (2, n), by Taylor series: f and limits to second order, touched
        points to first order. The derivatives remain those before the steps."""
        x, y = step
        squares = np.array((0.5 * x * x, x * y, 0.5 * y * y))
        return replace(
            self,
            f=self.f + (self.slope * step).sum(axis=0) + (self.bend * squares).sum(axis=0),
            margin=self.margin + (self.rate * step).sum(axis=1) + (self.curve * squares).sum(axis=1),
            meeting=self.meeting + (self.meeting_rate * step).sum(axis=1),
        )

    def pick(self, index: Integers) -> Local:
        """Return the places `index`."""
        return Local(*(value.take(index, axis=-1) for value in vars(self).values()))

    def where_not(self, moved: Mask, there: Local) -> Local:
        """Return these places, replaced by `there` where `moved` (n,) is true."""
        rows = zip(vars(self).values(), vars(there).values(), strict=True)
        return Local(*(np.where(moved, new, old) for old, new in rows))


def limits_at(task: Task, s: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute the limits without the clearance.

    Parameters
    ----------
    task : Task
    s, z : ndarray, shape (n,)
        Places on the pinion, mm.

    Returns
    -------
    margin : ndarray, shape (8, n)
        mm, negative outside the limit.
    rate : ndarray, shape (8, 2, n)
        Derivatives by s1 and z1.
    """
    cut = cut_at(task.pinion, s, z)
    seen = seen_by_gear(task, z, cut)
    rows = _limits(task, s, z, (_squares(cut), _squares_seen(seen)), seen[2])
    return rows[:, 0], rows[:, 1:]


def _squares(cut: Cut, bends: Bends | None = None) -> FloatArray:
    """Return r^2 of points and half of its derivatives by s, z and, with `bends`, s s, s z and z z: (3, n)
    or (6, n)."""
    x, y = cut.x, cut.y
    rows = np.empty((3 if bends is None else 6, x.size))
    rows[0], rows[1], rows[2] = x * x + y * y, x * cut.x_s + y * cut.y_s, x * cut.x_z + y * cut.y_z
    if bends is not None:
        rows[3] = cut.x_s * cut.x_s + cut.y_s * cut.y_s + x * bends.x_ss + y * bends.y_ss
        rows[4] = cut.x_s * cut.x_z + cut.y_s * cut.y_z + y * bends.y_sz
        rows[5] = cut.x_z * cut.x_z + cut.y_z * cut.y_z
    return rows


def _squares_seen(seen: FloatArray) -> FloatArray:
    """Return r^2 of points about the gear's axis and half of its derivatives, as many as of the points."""
    x, y, _ = seen
    rows: FloatArray = x[0] * x + y[0] * y
    if len(rows) > 3:
        rows[3:5] += x[1] * x[1:3] + y[1] * y[1:3]
        rows[5] += x[2] * x[2] + y[2] * y[2]
    return rows


def _rooted(rows: FloatArray) -> FloatArray:
    """Return a square root and its derivatives, (3, n) or (6, n), from the square and half of its
    derivatives."""
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
    """Return the limits with derivatives, (8, 3, n) or (8, 6, n), from r^2 on both members and z2, `high`."""
    pinion, gear, (radii, other_radii) = task.pinion, task.gear, (_rooted(rows) for rows in squares)
    rows = np.zeros((len(Limit), *high.shape))
    rows[Limit.PINION_ROOT, 1] = 1.0
    rows[Limit.GEAR_ROOT] = other_radii - gear.root_taper * high
    np.negative(radii, out=rows[Limit.PINION_TIP])
    rows[Limit.GEAR_TIP] = gear.taper * high - other_radii
    rows[Limit.PINION_TOE, 2], rows[Limit.PINION_HEEL, 2] = 1.0, -1.0
    rows[Limit.GEAR_TOE] = high
    np.negative(high, out=rows[Limit.GEAR_HEEL])
    rows[Limit.PINION_TIP, 2] += pinion.taper
    rows[Limit.PINION_ROOT, 0] = s - pinion.bottom
    rows[Limit.GEAR_ROOT, 0] -= gear.root
    rows[Limit.PINION_TIP, 0] += pinion.tip + pinion.taper * z
    rows[Limit.GEAR_TIP, 0] += gear.tip
    rows[Limit.PINION_TOE, 0], rows[Limit.PINION_HEEL, 0] = pinion.half_width + z, pinion.half_width - z
    rows[Limit.GEAR_TOE :: 2, 0] += gear.half_width
    if task.edged:  # undercut: the root limit is the edge
        fillet = task.with_fillets_at(np.array((s, z))).fillet if task.fillet is None else task.fillet
        assert fillet is not None
        if pinion.crossing is not None:
            edge = _from_own_edge(pinion.crossing, s, z, fillet[0], len(squares[0]))
            rows[Limit.PINION_ROOT] = _nearer(rows[Limit.PINION_ROOT], edge, fillet[0])
        if gear.crossing is not None:
            edge = _from_other_edge(gear.crossing, other_radii, high, fillet[1])
            rows[Limit.GEAR_ROOT] = _nearer(rows[Limit.GEAR_ROOT], edge, fillet[1])
    return rows


def _nearer(bottom: FloatArray, edge: FloatArray, fillet: Mask) -> FloatArray:
    """Return the limit at the undercut edge, replaced by the limit at the bottom land for places on the
    fillet that are closer to the bottom land."""
    return np.where(fillet & (bottom[0] < edge[0]), bottom, edge)


def _from_own_edge(
    curve: CrossingCurve, s: FloatArray, z: FloatArray, fillet: Mask, count: int
) -> FloatArray:
    """Return the distance (mm) of places from the pinion's undercut edge along the profile, positive on
    the side of the task, with derivatives, (count, n)."""
    along, rows = curve.rows(z), np.zeros((count, z.size))
    (edge, edge_z, edge_zz), sign = np.where(fillet, along[END], along[START]), np.where(fillet, -1.0, 1.0)
    rows[0], rows[1], rows[2] = sign * (s - edge), sign, -sign * edge_z
    if count > 3:
        rows[5] = -sign * edge_zz
    return rows


def _from_other_edge(curve: CrossingCurve, radii: FloatArray, high: FloatArray, fillet: Mask) -> FloatArray:
    """Return the distance (mm) of the touched points from the gear's undercut edge, positive on the side
    of the task, with derivatives, from their radii and heights `high` (rows, n)."""
    radius, slope, bend = curve.rows(high[0])[RADIUS]
    rows = np.asarray(radii - slope * high)
    rows[0] = radii[0] - radius
    if len(rows) > 3:
        rows[3:5] -= bend * high[1] * high[1:3]
        rows[5] -= bend * high[2] * high[2]
    return np.where(fillet, -rows, rows)


def hessian(rows: FloatArray) -> FloatArray:
    """Return second derivatives as matrices.

    Parameters
    ----------
    rows : ndarray, shape (..., 3, n)
        Derivatives by s1 s1, s1 z1 and z1 z1.

    Returns
    -------
    ndarray, shape (..., 2, 2, n)
    """
    return rows[..., [[0, 1], [1, 2]], :]


def clearance_at(task: Task, s: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Compute the clearance and its first derivatives.

    Parameters
    ----------
    task : Task
    s, z : ndarray, shape (n,)
        Places on the pinion, mm.

    Returns
    -------
    f : ndarray, shape (n,)
        mm.
    slope : ndarray, shape (2, n)
        Derivatives by s1 and z1.
    s2 : ndarray, shape (n,)
        Profile coordinate of the touched point of the gear, mm.
    """
    gear, cut = task.gear, cut_at(task.pinion, s, z)
    seen = seen_by_gear(task, z, cut)
    x, y, high = seen[:, 0]
    square = x * x + y * y
    other_s = profile_at(gear, square, high, None if task.fillet is None else task.fillet[1])
    met = generated_cut(gear, other_s, high)
    f, cos, sin = _turn(task, x, y, met)
    normal = _turned(np.array((met.nx, met.ny, met.nz)) / met.ny, cos / square, sin / square)
    scale = gear.sigma * task.lever / gear.pitch_radius
    slope = scale * (normal[:, None] * seen[:, 1:3]).sum(axis=0)
    if gear.modification is not None:
        added = _modified(task, met, turn_rows(gear, other_s, high), (_squares_seen(seen), seen[2]))
        f, slope = f + added[0], slope + added[1:3]
    return f, slope, other_s


def _modified(
    task: Task,
    met: Cut,
    turn: FloatArray,
    moves: tuple[FloatArray, FloatArray],
    bends: Bends | None = None,
) -> FloatArray:
    """Return the part of f that the modification of the gear adds, with derivatives, (3, n) or, with `bends`,
    (6, n).

    Parameters
    ----------
    task : Task
    met, bends : Cut, Bends
        Touched points of the gear's surface without the modification.
    turn : ndarray, shape (6, n)
        `turn_rows` at the touched points.
    moves : tuple of ndarray
        Of the touched points: r^2 with half of its derivatives, and z2 with its derivatives, by s1, z1 and,
        with `bends`, s1 s1, s1 z1 and z1 z1.
    """
    squares, high = moves
    psi, by_s, by_z, by_ss, by_sz, by_zz = turn
    of_met = _squares(met, bends)
    # s2 follows from r^2 and z2.
    z = high[1:3]
    s = (squares[1:3] - of_met[2] * z) / of_met[1]
    rows = np.empty((3 if bends is None else 6, psi.size))
    rows[0], rows[1:3] = psi, by_s * s + by_z * z
    if bends is not None:
        pairs = (0, 0, 1), (0, 1, 1)
        ss, zz = s[pairs[0],] * s[pairs[1],], z[pairs[0],] * z[pairs[1],]
        sz = s[pairs[0],] * z[pairs[1],] + z[pairs[0],] * s[pairs[1],]
        s_bend = squares[3:] - of_met[3] * ss - of_met[4] * sz - of_met[5] * zz - of_met[2] * high[3:]
        rows[3:] = by_ss * ss + by_sz * sz + by_zz * zz + by_s * s_bend / of_met[1] + by_z * high[3:]
    # A rotation psi2 about +z decreases f on right flanks and increases it on left flanks.
    return -task.gear.sigma * task.lever * rows


def _turn(task: Task, x: FloatArray, y: FloatArray, met: Cut) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return f of points x, y, and r^2 cos(w) and r^2 sin(w). w is the angle about the gear's axis from the
    points `met`, which are not yet rotated by phi and roll, to the points x, y."""
    gear, cos, sin = task.gear, x * met.x + y * met.y, y * met.x - x * met.y
    # One arctangent of both angles: exact to rounding where the difference is small, near contact.
    turn = np.arctan2(sin, cos) - met.phi - task.start
    return task.counted(gear.sigma * without_turns(turn)) * task.lever, cos, sin


def local_at(task: Task, s: FloatArray, z: FloatArray) -> Local:
    """Compute the clearance, its derivatives and the limits.

    Parameters
    ----------
    task : Task
    s, z : ndarray, shape (n,)
        Places on the pinion, mm.

    Returns
    -------
    Local
        NaN where the gear has no point at the radius of the place.
    """
    gear = task.gear
    on_pinion, on_gear = task.reliefs or (None, None)
    cut, bends = cut_with_bends(task.pinion, s, z, on_pinion)
    seen = seen_by_gear(task, z, cut, bends)
    x, y, high = seen[:, 0]
    squares, moves = _squares_seen(seen), seen[:, 1:3]
    other_s = profile_at(gear, squares[0], high, None if task.fillet is None else task.fillet[1])
    met, scaled_s = cut_with_normal_rate(gear, other_s, high)
    f, cos, sin = _turn(task, x, y, met)
    cos, sin = cos / squares[0], sin / squares[0]
    scaled = np.array((met.nx, met.ny, met.nz)) / met.ny
    normal, bent = _turned(scaled, cos, sin), _turned((scaled_s - scaled_s[1] * scaled) / met.ny, cos, sin)
    scale = gear.sigma * task.lever / gear.pitch_radius
    # dT = n.dP / (r_P2 n_y2), with n scaled to n_y2 = 1.
    slope = (normal[:, None] * moves).sum(axis=0)
    # The touched point moves along the gear's profile by met_s, and its normal rotates with it.
    along, across = met.x * met.x_s + met.y * met.y_s, met.x * met.x_z + met.y * met.y_z
    met_s = (squares[1:3] - across * moves[2]) / along
    turned = slope / gear.pitch_radius + met.phi_s * met_s + met.phi_z * moves[2]
    change = bent[:, None] * met_s
    change[0] -= turned * normal[1]
    change[1] += turned * normal[0]
    bend = (normal[:, None] * seen[:, 3:]).sum(axis=0)
    bend[::2] += (moves * change).sum(axis=0)
    bend[1] += 0.5 * (moves * change[:, ::-1]).sum(axis=(0, 1))
    rows = _limits(task, s, z, (_squares(cut, bends), squares), seen[2])
    slope, bend = scale * slope, scale * bend
    if gear.modification is not None:
        of_met = generated_bends(gear, other_s, high)
        turn = turn_rows(gear, other_s, high, on_gear)
        added = _modified(task, met, turn, (squares, seen[2]), of_met[1])
        f, slope, bend = f + added[0], slope + added[1:3], bend + added[3:]
    return Local(
        f=f,
        slope=slope,
        bend=bend,
        margin=rows[:, 0],
        rate=rows[:, 1:3],
        curve=rows[:, 3:],
        meeting=np.array((other_s, high)),
        meeting_rate=np.array((met_s, moves[2])),
    )


def _turned(rows: FloatArray, cos: FloatArray, sin: FloatArray) -> FloatArray:
    """Return vectors (3, n) rotated about the third axis."""
    return np.array((cos * rows[0] - sin * rows[1], sin * rows[0] + cos * rows[1], rows[2]))
