"""Ease-off: how far the pinion's flank stands back from the conjugate of its mate.

The conjugate is what the gear's flank, unlimited and turning at the constant ratio -N1/N2, would generate on
the pinion: the envelope of its positions in the pinion's frame. The gear is phased so that both flanks touch
in the middle of their path of contact (`contact.placing`), where the ease-off is 0 but for the square of the
slope of the transmission error. At a point P of the pinion's flank with the outward normal n1 it is the
distance g along n1 to that envelope, positive where the flanks part. With X a point of the gear's flank and N
its outward normal, all in S_f at the pinion roll phi,

    P + g n1 = X,    N.W = 0,    W = k1 x (X - O1) + (N1/N2) k2 x (X - O2).

W is the velocity of the pinion at X seen from the gear, the second the equation of meshing. For any roll the
first gives g, l2 and u2, with dg/dphi = -N.W / N.n1: the second is the one equation in phi under which g is
least. Newton's method takes phi from it, and l2 and u2 along the ray, with analytic derivatives, for all
points at once. It starts at the roll at which P itself would touch a conjugate mate, n1.W = 0 at P, that is
A cos(phi) + B sin(phi) = C, and there from the foot of the perpendicular on the gear's flank.

Along the path of contact g is the transmission error times its lever, to first order. Tips, edges and
neighbouring teeth have no part in it: what they do is in `operation`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Mask
from ..contact.ellipse import normal_rates
from ..contact.placing import Frame, MeshingPair, frames_at, meshing_pair
from ..design.model import Design
from ..gear.flank import flank_patch, place_at, trace_parameter
from ..gear.perpendicular import feet
from ..operation.separation import without_turns
from ..pair.frames import layout_of, normals_to_fixed, to_fixed
from ..status import Status
from ..support.few_lines import few_lines

SHAPE = (15, 21)
"""Points from root to tip and from toe to heel."""
STEPS, LAST_STEP = 40, 1e-9
"""Newton steps at most; rad of roll, and modules on the flank, below which one is the last: it leaves an
error of its square."""
FACING = float(np.cos(np.radians(30.0)))
"""Cosine of the angle between normals beyond which, and more than a module apart, flanks that are nowhere
trimmed meet without being in mesh."""
PINION_AXIS = np.array((0.0, 0.0, 1.0))
COEFFICIENTS = ("mean", "face_slope", "profile_slope", "face_crowning", "profile_crowning", "twist")


@dataclass(frozen=True, eq=False)
class EaseOff:
    """Ease-off of the pinion's flank of a `design`. Arrays (nl, nz), root and toe first.

    `profile` (nl) and `face` (nz): places from -1 at root and toe to 1 at tip and heel; `l`, `z`, flank
    parameter and distance from mid-face, mm; `deviation` along the normal, mm, positive where the flanks
    part; `pinion_roll` at which the flanks are nearest there, rad; `status`, codes of `Status`:
    NOT_CONVERGED and NaN where the mate has no conjugate."""

    __repr__ = few_lines

    design: Design = field(repr=False)
    flank: str
    profile: FloatArray
    face: FloatArray
    l: FloatArray
    z: FloatArray
    deviation: FloatArray
    pinion_roll: FloatArray
    status: Codes

    @property
    def corners(self) -> dict[str, float]:
        """Ease-off at the four corners, mm."""
        ends = {"root": 0, "tip": -1}, {"toe": 0, "heel": -1}
        return {
            f"{depth}_{end}": float(self.deviation[i, j])
            for depth, i in ends[0].items()
            for end, j in ends[1].items()
        }

    @property
    def second_order(self) -> SecondOrder:
        """The surface of second order nearest to it."""
        return second_order_of(self.profile, self.face, self.deviation)


@dataclass(frozen=True)
class SecondOrder:
    """A surface of second order, mm, with x from toe (-1) to heel (1) and y from root (-1) to tip (1):

    mean + face_slope x + profile_slope y
         + face_crowning (x^2 - 1/3) + profile_crowning (y^2 - 1/3) + twist x y.

    `mean` is that over the flank, a crowning by how much both ends stand back from the middle; `rest`: root
    mean square of what it leaves. NaN without six points."""

    mean: float
    face_slope: float
    profile_slope: float
    face_crowning: float
    profile_crowning: float
    twist: float
    rest: float


def ease_off(design: Design, flank: str = "right", shape: tuple[int, int] = SHAPE) -> EaseOff:
    """Find the ease-off of the pinion's flank over an even grid, root to tip and toe to heel.

    Parameters
    ----------
    design : Design
        A single one; its errors count.
    flank : {'right', 'left'}
    shape : (int, int)
        Points along profile and face, at least 3 each.

    Returns
    -------
    EaseOff

    Raises
    ------
    ValueError
        For a batch, too few points, and where the pair has no path of contact on these flanks.
    """
    if min(shape) < 3:
        raise ValueError(f"shape must be at least 3 points along profile and face, got {shape}")
    profile, face = (np.linspace(-1.0, 1.0, count) for count in shape)
    pose = meshing_pair(design, flank)
    l, z, u = place_at(design.pinion, flank, 0.5 * (1.0 + profile[:, None]), 0.5 * (1.0 + face))
    deviation, roll, status = conjugate_gap(design, pose, l, u)
    return EaseOff(design, flank, profile, face, l, z, deviation, roll, status)


def ease_off_at(design: Design, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Find the ease-off (...), mm, of the pinion's flank at parameters `l` in planes `z`, mm, on the active
    flank or not; NaN where the mate has no conjugate. ValueError as of `ease_off`."""
    pose, u = meshing_pair(design, flank), trace_parameter(design.pinion, flank, l, z)
    return conjugate_gap(design, pose, *np.broadcast_arrays(np.asarray(l, dtype=float), u))[0]


def second_order_of(profile: FloatArray, face: FloatArray, deviation: FloatArray) -> SecondOrder:
    """Fit a surface of second order to values (nl, nz), mm, by least squares over the flank, integrals by the
    trapezoidal rule, so that little depends on the grid; NaN is left out."""
    y, x = np.meshgrid(profile, face, indexing="ij")
    known = np.isfinite(deviation)
    if np.count_nonzero(known) < len(COEFFICIENTS):
        return SecondOrder(*[np.nan] * 7)
    terms = np.stack((np.ones_like(x), x, y, x * x - 1.0 / 3.0, y * y - 1.0 / 3.0, x * y), axis=-1)[known]
    share = np.sqrt(np.multiply.outer(_widths(profile), _widths(face))[known])
    found = np.linalg.lstsq(terms * share[:, None], deviation[known] * share, rcond=None)[0]
    left = share * (deviation[known] - terms @ found)
    return SecondOrder(*map(float, (*found, np.sqrt((left**2).sum() / (share**2).sum()))))


def _widths(places: FloatArray) -> FloatArray:
    """Give the weights (n,) of the trapezoidal rule at places (n,)."""
    steps = np.diff(places)
    return np.asarray(0.5 * (np.append(steps, 0.0) + np.append(0.0, steps)))


def conjugate_gap(
    design: Design, pose: MeshingPair, l: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray, Codes]:
    """Find distances (...), mm, along the pinion's normal from its flank points (l, u), mm, to the conjugate
    of the gear phased as in `pose`; the pinion rolls (rad) at which the gear touches it; and status. What is
    not found from its own start is looked for from the nearest that is."""
    from scipy.spatial import cKDTree

    mate, shape, place = _mate_of(design, pose), np.shape(l), np.stack((np.ravel(l), np.ravel(u)), axis=-1)
    patch = flank_patch(design.pinion, pose.flank, *place.T)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        roll = _own_roll(mate, patch.point, patch.normal)
        start = feet(design.gear, pose.flank, _seen_by_gear(mate, patch.point, roll))
        gap, state = _least(mate, patch.point, patch.normal, np.stack((roll, start.l, start.u)))
        given = np.isfinite(place.sum(axis=1))
        while True:
            lost, known = np.flatnonzero(np.isnan(gap) & given), np.flatnonzero(np.isfinite(gap))
            if not lost.size or not known.size:
                break
            begin = state[:, known[cKDTree(place[known]).query(place[lost])[1]]]
            gap[lost], state[:, lost] = _least(mate, patch.point[lost], patch.normal[lost], begin)
            if np.isnan(gap[lost]).all():
                break
    status = np.where(np.isnan(gap), np.int8(Status.NOT_CONVERGED), np.int8(Status.SOLVED)).astype(np.int8)
    return gap.reshape(shape), state[0].reshape(shape), status.reshape(shape)


def _least(
    mate: _Mate, point: FloatArray, normal: FloatArray, state: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Find least distances (n,), mm, and their states (3, n), from the states given on; NaN where there is
    none to be found."""
    last = LAST_STEP * np.array([[1.0], [mate.module], [mate.module]])
    for _ in range(STEPS):
        gap, step, nearest = _newton_step(mate, point, normal, state)
        state = state + step
        done = (np.abs(step) <= last).all(axis=0)
        if np.all(done | ~np.isfinite(gap)):
            break
    found = done & nearest & (np.abs(gap) < mate.module)
    return np.where(found, gap, np.nan), np.where(found, state, np.nan)


@dataclass(frozen=True, eq=False)
class _Mate:
    """The gear's unlimited flank at a constant ratio. `rate`: gear roll by pinion roll; `roll` (2,) of both
    in the middle of the path, rad; `axis` (3,) of the gear and a point of it, `centre` (3,), mm, in S_f."""

    design: Design
    flank: str
    module: float
    rate: float
    roll: FloatArray
    axis: FloatArray
    centre: FloatArray

    def frames(self, roll: FloatArray) -> tuple[Frame, Frame]:
        """Give frames of pinion and gear at pinion rolls (...), rad."""
        return frames_at(self.design, roll, self.roll[1] + self.rate * (roll - self.roll[0]))

    def sliding(self, vectors: FloatArray) -> FloatArray:
        """Give the pinion's turning less the gear's, k1 x v + (N1/N2) k2 x v, of vectors (..., 3)."""
        return np.asarray(np.cross(PINION_AXIS - self.rate * self.axis, vectors))


def _mate_of(design: Design, pose: MeshingPair) -> _Mate:
    layout = layout_of(design)
    return _Mate(
        design=design,
        flank=pose.flank,
        module=float(design.gear.tool.normal_module),
        rate=-float(design.pinion.teeth) / float(design.gear.teeth),
        roll=pose.roll,
        axis=np.array((0.0, float(layout.sin_angle), float(layout.cos_angle))),
        centre=np.array((float(layout.offset), 0.0, 0.0)),
    )


def _own_roll(mate: _Mate, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Find the pinion roll (...) nearest to that of `mate` at which points with their normals (..., 3), own
    frame, meet the equation of meshing; where there is none, that which comes nearest to it."""
    origin = frames_at(mate.design, 0.0, 0.0)[0][1]
    moment, arm = np.cross(point, normal), np.cross(mate.axis, origin - mate.centre)
    # n.(k2 x (R - O2)) = k2.Rz (P x n) + (k2 x (O1 - O2)).Rz n, while n.(k1 x R) does not turn.
    cos = moment[..., :2] @ mate.axis[:2] + normal[..., :2] @ arm[:2]
    sin = moment[..., :2] @ _quarter(mate.axis) + normal[..., :2] @ _quarter(arm)
    rest = moment[..., 2] / mate.rate - moment[..., 2] * mate.axis[2] - normal[..., 2] * arm[2]
    turn = np.arccos(np.clip(rest / np.hypot(cos, sin), -1.0, 1.0))
    both = np.arctan2(sin, cos) + np.stack((turn, -turn)) - mate.roll[0]
    both = without_turns(both)
    return np.asarray(mate.roll[0] + np.where(np.abs(both[0]) < np.abs(both[1]), both[0], both[1]))


def _quarter(vector: FloatArray) -> FloatArray:
    """Give x and y of a vector (3,), turned back by a right angle about z."""
    return np.array((vector[1], -vector[0]))


def _seen_by_gear(mate: _Mate, point: FloatArray, roll: FloatArray) -> FloatArray:
    """Give points (..., 3) of the pinion's own frame in the gear's, at pinion rolls."""
    pinion, (rotation, origin) = mate.frames(roll)
    return np.asarray(np.einsum("...ji,...j->...i", rotation, to_fixed(pinion, point) - origin))


def _newton_step(
    mate: _Mate, point: FloatArray, normal: FloatArray, state: FloatArray
) -> tuple[FloatArray, FloatArray, Mask]:
    """Find the distance (...) along the pinion's normal at a `state` (3, ...) of roll, l2 and u2, the step of
    Newton's method, and whether the distance is least here and the flanks face each other."""
    roll, l, u = state
    pinion, gear = mate.frames(roll)
    own, ray = to_fixed(pinion, point), normals_to_fixed(pinion, normal)
    patch, turns = (
        flank_patch(mate.design.gear, mate.flank, l, u),
        normal_rates(mate.design.gear, mate.flank, l, u),
    )
    x, n = to_fixed(gear, patch.point), normals_to_fixed(gear, patch.normal)
    (x_l, x_u), (n_l, n_u) = (
        [normals_to_fixed(gear, each) for each in pair]
        for pair in ((patch.tangent_l, patch.tangent_u), turns)
    )
    facing = _dot(n, ray)
    gap = _dot(n, x - own) / facing
    off = own + gap[..., None] * ray - x  # in the tangent plane of the gear's flank
    # Meshing, N.W = 0, and its derivatives; the gear turns with `rate`.
    slide = mate.sliding(x) + mate.rate * np.cross(mate.axis, mate.centre)
    turned, carried = (mate.rate * np.cross(mate.axis, v) for v in (n, x - mate.centre))
    meshing = _dot(n, slide)
    by_roll, by_l, by_u = (
        _dot(by, slide) + _dot(n, mate.sliding(moved))
        for by, moved in ((turned, carried), (n_l, x_l), (n_u, x_u))
    )
    # The place on the gear's flank moves by `off`, and with the roll by what the ray does over the flank.
    over = slide + np.cross(PINION_AXIS, off)
    over = over - (_dot(n, over) / facing)[..., None] * ray
    along, across = np.cross(x_u, n), np.cross(n, x_l)
    along, across = along / _dot(along, x_l)[..., None], across / _dot(across, x_u)[..., None]
    bend = by_roll + by_l * _dot(along, over) + by_u * _dot(across, over)
    # Down to where the distance is least, also from where it is bent the other way; half a pitch at most.
    step = -(meshing + by_l * _dot(along, off) + by_u * _dot(across, off)) / np.abs(bend)
    most = np.pi / float(mate.design.pinion.teeth)
    step = np.clip(step, -most, most)
    moved = off + step[..., None] * over
    nearest = (bend > 0.0) & (facing < -FACING) & (patch.regularity > 0.0)
    return gap, np.stack((step, _dot(along, moved), _dot(across, moved))), nearest


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Give the scalar products (...) of vectors (..., 3)."""
    return np.asarray((first * second).sum(axis=-1))
