"""Ease-off: deviation of the pinion flank from the conjugate of its mate.

The conjugate is the envelope that the unlimited gear flank, turning at the constant ratio -N1/N2, generates
on the pinion. The gear is phased so that both flanks touch in the middle of their path of contact
(`contact.mesh_position`). The ease-off is 0 there, apart from the square of the slope of the transmission
error. At a point P of the pinion flank with the outward normal n1, the ease-off is the distance g along n1 to
this envelope, positive if there is a gap. Let X be a point of the gear flank with the outward normal N. All
vectors are in the fixed frame S_f (`pair.frames`) at the pinion roll phi. k1 and k2 are the directions of the
axes of pinion and gear, O1 and O2 are points of these axes. Then

    P + g n1 = X,    N.W = 0,    W = k1 x (X - O1) + (N1/N2) k2 x (X - O2).

W is the velocity of the pinion at X relative to the gear; N.W = 0 is the equation of meshing. For any roll,
the first equation determines g, l2 and u2, with dg/dphi = -N.W / N.n1. The equation of meshing is therefore
one equation in phi, and g has its minimum there. Newton's method solves it for phi, and for l2 and u2 along
the ray, with analytic derivatives for all points at once. It starts at the roll at which P itself would touch
a conjugate mate, n1.W = 0 at P, which is A cos(phi) + B sin(phi) = C, and from the projection of P on the
gear flank.

Along the path of contact, g equals the transmission error times its lever, to first order. Tips, edges and
neighbouring teeth are not considered; they are in `operation`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Mask
from ..contact.mesh_position import Frame, MeshingPair, frames_at, meshing_pair
from ..design.arguments import require_design, require_two_numbers
from ..design.model import Design
from ..gear.active_flank import place_at
from ..gear.closest_point import feet
from ..gear.flank import flank_patch, normal_rates, trace_parameter
from ..operation.angular_clearance import without_turns
from ..pair.frames import layout_of, normals_to_fixed, to_fixed
from ..status import Status
from ..support.array_repr import short_repr

PINION_AXIS = np.array((0.0, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class EaseOff:
    """Ease-off of the pinion flank of a `design`. Arrays (nl, nz) from root to tip and from toe to heel.

    Attributes
    ----------
    profile, face : FloatArray
        (nl,) and (nz,), positions from -1 at root and toe to 1 at tip and heel.
    l, z : FloatArray
        Flank parameter and distance from mid-face, mm.
    deviation : FloatArray
        Ease-off along the normal, mm; positive if there is a gap.
    pinion_roll : FloatArray
        Roll at which the flanks are nearest at this point, rad.
    status : Codes
        Codes of `Status`: NOT_CONVERGED, with NaN values, where the gear flank generates no conjugate
        surface.
    """

    __repr__ = short_repr

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
        """Surface of second order fitted to the ease-off."""
        return second_order_of(self.profile, self.face, self.deviation)


@dataclass(frozen=True)
class SecondOrder:
    """Surface of second order, mm, with x from -1 at -z to 1 at +z, and y from root (-1) to tip (1):

        mean + face_slope x + profile_slope y
             + face_crowning (x^2 - 1/3) + profile_crowning (y^2 - 1/3) + twist x y.

    `mean` is the mean over the flank. A crowning is the height of both ends relative to the middle. `rest` is
    the root mean square of the residual. NaN with fewer than six points."""

    mean: float
    face_slope: float
    profile_slope: float
    face_crowning: float
    profile_crowning: float
    twist: float
    rest: float


def ease_off(design: Design, flank: str = "right", shape: tuple[int, int] = (15, 21)) -> EaseOff:
    """Compute the ease-off of the pinion flank on an even grid, from root to tip and from toe to heel.

    Parameters
    ----------
    design : Design
        A single design, with its errors.
    flank : {'right', 'left'}
    shape : (int, int)
        Number of points along profile and face, at least 3 each.

    Returns
    -------
    EaseOff

    Raises
    ------
    ValueError
        For a batch; for too few points; and if the flanks have no path of contact.

    References
    ----------
    Conjugate surfaces: Litvin and Fuentes, Gear Geometry and Applied Theory, 2004; definitions:
    beveloid_geom/analysis/README.md, Ease-off.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> design = bg.builtin_design("ni-2017").with_parabola(0.001, -0.001)
    >>> surface = bg.ease_off(design, "right", shape=(3, 3))
    >>> print(f"{surface.deviation.max():.4f} mm")
    0.0126 mm
    """
    require_design(design)
    require_two_numbers(shape=shape)
    if min(shape) < 3:
        raise ValueError(f"shape must be at least 3 points along profile and face, got {shape}")
    profile, face = (np.linspace(-1.0, 1.0, count) for count in shape)
    pose = meshing_pair(design, flank)
    l, z, u = place_at(design.pinion, flank, 0.5 * (1.0 + profile[:, None]), 0.5 * (1.0 + face))
    deviation, roll, status = conjugate_gap(design, pose, l, u)
    return EaseOff(design, flank, profile, face, l, z, deviation, roll, status)


def ease_off_at(design: Design, flank: str, l: ArrayLike, z: ArrayLike) -> FloatArray:
    """Return the ease-off of the pinion flank at given points, also outside the active flank.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    l, z : array_like
        Flank parameters l, and axial positions z from mid-face, mm; they broadcast.

    Returns
    -------
    ndarray
        mm; NaN where the mate has no conjugate.

    Raises
    ------
    ValueError
        As in `ease_off`.
    """
    pose, u = meshing_pair(design, flank), trace_parameter(design.pinion, flank, l, z)
    return conjugate_gap(design, pose, *np.broadcast_arrays(np.asarray(l, dtype=float), u))[0]


def second_order_of(profile: FloatArray, face: FloatArray, deviation: FloatArray) -> SecondOrder:
    """Return the surface of second order fitted to values (nl, nz), mm, by least squares over the flank. The
    integrals use the trapezoidal rule, so that the result depends little on the grid; NaN values are ignored.
    """
    y, x = np.meshgrid(profile, face, indexing="ij")
    known = np.isfinite(deviation)
    if np.count_nonzero(known) < 6:  # terms
        return SecondOrder(*[np.nan] * 7)
    terms = np.stack((np.ones_like(x), x, y, x * x - 1.0 / 3.0, y * y - 1.0 / 3.0, x * y), axis=-1)[known]
    share = np.sqrt(np.multiply.outer(_widths(profile), _widths(face))[known])
    coefficients = np.linalg.lstsq(terms * share[:, None], deviation[known] * share, rcond=None)[0]
    left = share * (deviation[known] - terms @ coefficients)
    return SecondOrder(*map(float, (*coefficients, np.sqrt((left**2).sum() / (share**2).sum()))))


def _widths(places: FloatArray) -> FloatArray:
    """Return the weights (n,) of the trapezoidal rule at positions (n,)."""
    steps = np.diff(places)
    return np.asarray(0.5 * (np.append(steps, 0.0) + np.append(0.0, steps)))


def conjugate_gap(
    design: Design, pose: MeshingPair, l: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray, Codes]:
    """Return distances (...), mm, along the pinion normal from flank points (l, u), mm, to the conjugate of
    the gear phased as in `pose`, the pinion rolls (rad) at which the gear touches it, and the status.

    Points that are not solved from their own start are started again from the nearest solved point."""
    from scipy.spatial import cKDTree

    mate, shape, place = _mate_of(design, pose), np.shape(l), np.stack((np.ravel(l), np.ravel(u)), axis=-1)
    patch = flank_patch(design.pinion, pose.flank, *place.T)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        roll = _roll_of_mate(mate, patch.point, patch.normal)
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
    """Return the distances (n,), mm, and states (3, n) after Newton's method; NaN if it fails."""
    newton_max_iterations = 40
    # Newton step, rad of roll and modules on the flank, after which the iteration ends: the error is
    # its square.
    last_step = 1e-9
    last = last_step * np.array([[1.0], [mate.module], [mate.module]])
    for _ in range(newton_max_iterations):
        gap, step, nearest = _newton_step(mate, point, normal, state)
        state = state + step
        done = (np.abs(step) <= last).all(axis=0)
        if np.all(done | ~np.isfinite(gap)):
            break
    valid = done & nearest & (np.abs(gap) < mate.module)
    return np.where(valid, gap, np.nan), np.where(valid, state, np.nan)


@dataclass(frozen=True, eq=False)
class _Mate:
    """The unlimited gear flank at a constant ratio. `rate`: gear roll per pinion roll; `roll` (2,): both
    rolls in the middle of the path, rad; `axis` (3,) and `centre` (3,), mm: direction and a point of the gear
    axis in S_f."""

    design: Design
    flank: str
    module: float
    rate: float
    roll: FloatArray
    axis: FloatArray
    centre: FloatArray

    def frames(self, roll: FloatArray) -> tuple[Frame, Frame]:
        """Return the frames of pinion and gear at pinion rolls (...), rad."""
        return frames_at(self.design, roll, self.roll[1] + self.rate * (roll - self.roll[0]))

    def sliding(self, vectors: FloatArray) -> FloatArray:
        """Return k1 x v + (N1/N2) k2 x v, the rotation of the pinion relative to the gear, of vectors (...,
        3)."""
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


def _roll_of_mate(mate: _Mate, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the pinion roll (...) nearest to that of `mate` at which points with their normals (..., 3), in
    the pinion frame, satisfy the equation of meshing; if there is none, the roll that comes nearest to it."""
    origin = frames_at(mate.design, 0.0, 0.0)[0][1]
    moment, arm = np.cross(point, normal), np.cross(mate.axis, origin - mate.centre)
    # n.(k2 x (R - O2)) = k2.Rz (P x n) + (k2 x (O1 - O2)).Rz n; n.(k1 x R) is independent of the roll.
    cos = moment[..., :2] @ mate.axis[:2] + normal[..., :2] @ arm[:2]
    sin = moment[..., :2] @ _quarter(mate.axis) + normal[..., :2] @ _quarter(arm)
    constant_term = moment[..., 2] / mate.rate - moment[..., 2] * mate.axis[2] - normal[..., 2] * arm[2]
    turn = np.arccos(np.clip(constant_term / np.hypot(cos, sin), -1.0, 1.0))
    both = np.arctan2(sin, cos) + np.stack((turn, -turn)) - mate.roll[0]
    both = without_turns(both)
    return np.asarray(mate.roll[0] + np.where(np.abs(both[0]) < np.abs(both[1]), both[0], both[1]))


def _quarter(vector: FloatArray) -> FloatArray:
    """Return x and y of a vector (3,) rotated by -90 deg about z."""
    return np.array((vector[1], -vector[0]))


def _seen_by_gear(mate: _Mate, point: FloatArray, roll: FloatArray) -> FloatArray:
    """Return points (..., 3) of the pinion frame in the gear frame, at pinion rolls."""
    pinion, (rotation, origin) = mate.frames(roll)
    return np.asarray(np.einsum("...ji,...j->...i", rotation, to_fixed(pinion, point) - origin))


def _newton_step(
    mate: _Mate, point: FloatArray, normal: FloatArray, state: FloatArray
) -> tuple[FloatArray, FloatArray, Mask]:
    """Return the distance (...) along the pinion normal at a `state` (3, ...) of roll, l2 and u2, the Newton
    step, and whether the distance is a minimum and the flanks face each other."""
    roll, l, u = state
    pinion, gear = mate.frames(roll)
    pinion_point, ray = to_fixed(pinion, point), normals_to_fixed(pinion, normal)
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
    gap = _dot(n, x - pinion_point) / facing
    off = pinion_point + gap[..., None] * ray - x  # in the tangent plane of the gear's flank
    # Equation of meshing, N.W = 0, and its derivatives by roll, l2 and u2.
    slide = mate.sliding(x) + mate.rate * np.cross(mate.axis, mate.centre)
    turned, carried = (mate.rate * np.cross(mate.axis, v) for v in (n, x - mate.centre))
    meshing = _dot(n, slide)
    by_roll, by_l, by_u = (
        _dot(by, slide) + _dot(n, mate.sliding(moved))
        for by, moved in ((turned, carried), (n_l, x_l), (n_u, x_u))
    )
    # The point on the gear flank moves by `off`, and with the roll by the motion of the ray over the flank.
    over = slide + np.cross(PINION_AXIS, off)
    over = over - (_dot(n, over) / facing)[..., None] * ray
    along, across = np.cross(x_u, n), np.cross(n, x_l)
    along, across = along / _dot(along, x_l)[..., None], across / _dot(across, x_u)[..., None]
    bend = by_roll + by_l * _dot(along, over) + by_u * _dot(across, over)
    # Dividing by the magnitude leads to the minimum of the distance, also from negative curvature. The step
    # is limited to half a pitch.
    step = -(meshing + by_l * _dot(along, off) + by_u * _dot(across, off)) / np.abs(bend)
    most = np.pi / float(mate.design.pinion.teeth)
    step = np.clip(step, -most, most)
    moved = off + step[..., None] * over
    # Beyond this angle between the normals, or a module apart, the untrimmed flanks intersect without being
    # in mesh.
    least_facing_cosine = float(np.cos(np.radians(30.0)))
    nearest = (bend > 0.0) & (facing < -least_facing_cosine) & (patch.regularity > 0.0)
    return gap, np.stack((step, _dot(along, moved), _dot(across, moved))), nearest


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the scalar products (...) of vectors (..., 3)."""
    return np.asarray((first * second).sum(axis=-1))
