"""Tangency of two flanks given as surfaces (s, z), with its derivatives.

A flank point of the pinion is rotated by its roll rho and seen from the fixed frame of the gear, where it has
the position P(s1, z1, rho). P_s and P_z are its derivatives by s1 and z1. The gear touches this point at
z2 = k2.P - c2, where k2 is the unit vector along the gear axis and c2 the mounting distance of the gear's
mid-face with the axial error, with the profile coordinate s2 and the gear roll that give the same radius and
angle. With the normal G of the gear at the touched point, rotated by the gear roll, the flanks are tangent if

    |P|^2 - r2(s2, z2)^2 = 0  (distance from the gear axis),   G.P_s = 0,   G.P_z = 0.

These are three equations for s1, z1, rho, s2. The first one eliminates the step of s2, because r2 increases
along the profile. The two others have gradients h_1, h_2 in (s1, z1, rho). A condition c = 0 with the
gradient w selects a point of the curve of contact, and Newton's step follows from Cramer's rule,

    d = -[q_1 (h_2 x w) + q_2 (w x h_1) + c (h_1 x h_2)] / (h_1.(h_2 x w)),

with the residuals q. The tangent of the curve is h_1 x h_2. The equations do not require that the normal
depends on s alone, or that the axes are crossed: they hold for modified flanks and on parallel axes.

In the section frames, rotated by the angle phi of Eq. 6 from the frame of the member, a point (x, y) has the
derivatives D_s = (x_s - phi_s y, y_s + phi_s x, 0) and D_z = (x_z - phi_z y, y_z + phi_z x, 1). The normal
is D_s x D_z. All arrays have the contacts on the last axis, (..., n).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.tooth_side import ToothSurface, cut_at, cut_with_bends, profile_at, tangents_of

NEWTON_MAX_STEPS = 40
"""Largest number of Newton steps from starting values that may be far away."""


@dataclass(frozen=True, eq=False)
class Jet:
    """Points of a surface with derivatives, in the section frame.

    `phi` (n,) is the angle (rad) of the section frame, and `plane` (6, 2, n) has the x and y components of
    the point and of its derivatives by s, z, ss, sz and zz, in mm.
    """

    phi: FloatArray
    plane: FloatArray


def jet_at(surface: ToothSurface, s: FloatArray, z: FloatArray) -> Jet:
    """Return points of a surface at (s, z), mm, with first and second derivatives."""
    cut, bends = cut_with_bends(surface, s, z)
    return Jet(cut.phi, tangents_of(cut, bends))


def normals_of(jet: Jet) -> FloatArray:
    """Return D_s x D_z and its derivatives by s and z, (3, 3, n)."""
    _, (a, b), (c, d), (e, f), (g, h), (p, q) = jet.plane
    return np.array(
        (
            (b, -a, a * d - b * c),
            (f, -e, e * d - f * c + a * h - b * g),
            (h, -g, g * d - h * c + a * q - b * p),
        )
    )


@dataclass(frozen=True, eq=False)
class PairPlacement:
    """Axes and mid-faces (n,): cosine and sine of the shaft angle, offset, axial `position` (2, n) and pitch
    point (3, n) in S_f, mm.
    """

    cos: FloatArray
    sin: FloatArray
    offset: FloatArray
    position: FloatArray
    pitch_point: FloatArray

    def take(self, index: Integers | Mask) -> PairPlacement:
        """Return the placements at `index`."""
        return PairPlacement(*(value[..., index] for value in vars(self).values()))

    def of_cases(self, cases: Integers) -> PairPlacement:
        """Return the placements of contacts of `cases` (n,). A single placement, (1,), is not repeated."""
        return self if self.offset.size == 1 else self.take(cases)


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Both flanks of a pair of single members, continued beyond their limits, and lengths of the pair.

    `ratio` is N1/N2. `largest` (3,) are the flank depth and the face width of the pinion (mm) and its pitch
    (rad): the largest Newton steps in s1, z1 and roll, and the units of `Problem.scale`.
    """

    pinion: ToothSurface
    gear: ToothSurface
    ratio: float
    largest: FloatArray

    @property
    def measured(self) -> bool:
        """Whether a flank has measured deviations."""
        both = (self.pinion.modification, self.gear.modification)
        return any(one is not None and one.measured for one in both)


@dataclass(frozen=True, eq=False)
class Contacts:
    """States (s1, z1, rho, s2) with residuals and derivatives; mm and rad.

    `state` (4, n); `residual` (2, n) and `gradient` (2, 3, n) of both tangency equations after s2 is
    eliminated; `follow` (4, n): the step of s2 is follow[0] + follow[1:].(ds1, dz1, drho); `z2` (n,), mm:
    axial coordinate of the touched point of the gear from mid-face; `jets`: surface points of pinion and
    gear. In the fixed frame of the gear: `point` (3, n); `moves` (3, 3, n), derivatives of the point of the
    pinion by s1, z1 and rho, by component and derivative; `product` (3, n), D_s x D_z of the gear. `turn` has
    the cosine and sine of the angle of the section frame of the gear in its fixed frame. `sigma` is +1 on
    right and -1 on left flanks.
    """

    state: FloatArray
    residual: FloatArray
    gradient: FloatArray
    follow: FloatArray
    z2: FloatArray
    moves: FloatArray
    point: FloatArray
    product: FloatArray
    turn: tuple[FloatArray, FloatArray]
    jets: tuple[Jet, Jet]
    sigma: float

    @property
    def normal(self) -> FloatArray:
        """Unit normal (3, n) out of the gear tooth in the fixed frame of the gear."""
        return np.asarray(-self.sigma * self.product / np.sqrt((self.product**2).sum(axis=0)))

    @property
    def error(self) -> FloatArray:
        """The relative difference of the radii or the sine of the angle between the flanks (n,), whichever is
        larger."""
        square, gear_square = ((x * x).sum(axis=0) for x in (self.point[:2], self.jets[1].plane[0]))
        tangents = self.moves[:, :2]
        sines = (self.normal[:, None] * tangents).sum(axis=0) / np.sqrt((tangents * tangents).sum(axis=0))
        return np.asarray(np.maximum(0.5 * np.abs(square - gear_square) / square, np.abs(sines).max(axis=0)))

    @property
    def opposed(self) -> Mask:
        """Whether the normals of both flanks point against each other (n,)."""
        # P_s x P_z is opposed to D_s x D_z of the gear; mirrored frames do not occur.
        return np.asarray((cross(self.moves[:, 0], self.moves[:, 1]) * self.product).sum(axis=0) < 0.0)

    @property
    def tangent(self) -> FloatArray:
        """Direction (3, n) of the curve of contact in (s1, z1, rho)."""
        return cross(self.gradient[0], self.gradient[1])

    def along(self, direction: FloatArray) -> FloatArray:
        """Return steps (4, n) of the state from steps (3, n) of s1, z1 and rho on the curve."""
        return np.concatenate((direction, (self.follow[1:] * direction).sum(axis=0)[None]))


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross product of vectors (3, n)."""
    return np.array((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


def _in_gear_frame(jet: Jet, z1: FloatArray, roll: FloatArray, placed: PairPlacement) -> FloatArray:
    """Return points of the pinion and their derivatives in the frame of the gear, (3, 9, n): P, P_s, P_z,
    P_ss, P_sz, P_zz, and P_r, P_sr, P_zr with the roll r."""
    angle = roll + jet.phi
    cos, sin, (x, y) = np.cos(angle), np.sin(angle), jet.plane.swapaxes(0, 1)
    # Rotate by roll + phi. The fixed frame of the gear has X2 = -x and Z2 = k2.
    moved, across = np.empty((3, 9, len(z1))), sin * x + cos * y
    moved[0, :6] = sin * y - cos * x
    moved[1, :6], moved[2, :6] = -placed.cos * across, placed.sin * across
    # The derivatives by the roll are k x the vector.
    moved[0, 6:] = across[:3]
    moved[1, 6:], moved[2, 6:] = placed.cos * moved[0, :3], -placed.sin * moved[0, :3]
    along = z1 + placed.position[0]
    moved[0, 0] += placed.offset
    moved[1, 0] += placed.sin * along
    moved[2, 0] += placed.cos * along
    moved[1, 2] += placed.sin
    moved[2, 2] += placed.cos
    return moved


def turned_about_gear(vectors: FloatArray, turn: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return vectors (k, 3, n) rotated about the axis of the gear, as (3, k, n). `turn` has the cosine and
    sine of the angle."""
    cos, sin = turn
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    return np.array((cos * x - sin * y, sin * x + cos * y, z))


def contacts_at(surfaces: Surfaces, placed: PairPlacement, state: FloatArray) -> Contacts:
    """Return residuals and derivatives at states (4, n)."""
    s1, z1, roll, s2 = state
    jet = jet_at(surfaces.pinion, s1, z1)
    moved = _in_gear_frame(jet, z1, roll, placed)
    x, y = moved[:2, 0]
    z2 = moved[2, 0] - placed.position[1]
    # Gear: the touched point, its angle about the axis and its normal.
    other = jet_at(surfaces.gear, s2, z2)
    (px, py), (sx, sy), (zx, zy) = other.plane[:3]
    square, gear_square = x * x + y * y, px * px + py * py
    half_square_s, half_square_z = px * sx + py * sy, px * zx + py * zy
    scale = 1.0 / np.sqrt(square * gear_square)
    turn = (x * px + y * py) * scale, (y * px - x * py) * scale
    rows = turned_about_gear(normals_of(other), turn)  # (3, 3, n)
    normal = rows[:, 0]
    side = np.array((-normal[1], normal[0]))
    # Steps by s1, z1, rho: (3, 3, n), and dG by them and by s2.
    by = moved[:, [1, 2, 6]]
    spin = (x * by[1] - y * by[0]) / square - (px * zy - py * zx) / gear_square * by[2]
    change = rows[:, 2][:, None] * by[2]
    change[:2] += side[:, None] * spin
    s2_change = rows[:, 1].copy()
    s2_change[:2] -= side * ((px * sy - py * sx) / gear_square)
    # Elimination of s2.
    follow = np.empty((4, len(s1)))
    follow[0] = 0.5 * (square - gear_square)
    follow[1:] = x * by[0] + y * by[1] - half_square_z * by[2]
    follow /= half_square_s
    # Tangency by s (row 0) and by z (row 1).
    first = moved[:, 1:3]  # P_s, P_z
    value = (normal[:, None] * first).sum(axis=0)
    second = (normal[:, None] * moved[:, 3:]).sum(axis=0)  # ss, sz, zz, r, sr, zr
    gradient = (first[:, :, None] * change[:, None]).sum(axis=0) + second[[[0, 1, 4], [1, 2, 5]]]
    rate_by_s2 = (first * s2_change[:, None]).sum(axis=0)
    gradient += rate_by_s2[:, None] * follow[1:]
    residual = value + rate_by_s2 * follow[0]
    return Contacts(
        state=state,
        residual=residual,
        gradient=gradient,
        follow=follow,
        z2=z2,
        moves=by,
        point=moved[:, 0],
        product=normal,
        turn=turn,
        jets=(jet, other),
        sigma=surfaces.gear.sigma,
    )


Condition: TypeAlias = Callable[[Contacts, Integers], tuple[FloatArray, FloatArray]]
"""Function that returns values (n,) and gradients (3, n) in (s1, z1, rho) of the condition that selects a
point of the curve of contact, for the contacts with the numbers (n,).
"""


def given_row(row: int, values: FloatArray) -> Condition:
    """Return the condition that s1 (`row` 0, mm), z1 (1, mm) or the pinion roll (2, rad) has the `values`."""
    unit = np.eye(3)[row][:, None]

    def condition(met: Contacts, index: Integers) -> tuple[FloatArray, FloatArray]:
        return met.state[row] - values[index], np.broadcast_to(unit, (3, index.size))

    return condition


def solve(
    surfaces: Surfaces,
    placed: PairPlacement,
    state: FloatArray,
    condition: Condition,
    reach: FloatArray | None = None,
    max_steps: int = NEWTON_MAX_STEPS,
) -> tuple[Contacts, Mask]:
    """Solve for contacts that satisfy a condition.

    Parameters
    ----------
    surfaces : Surfaces
    placed : PairPlacement
    state : ndarray, shape (4, n)
        Starting values of s1, z1 (mm), roll (rad) and s2 (mm).
    condition : Condition
    reach : ndarray, shape (n,), optional
        Largest step of Newton's method, in units of `Surfaces.largest`, for starting values that are close to
        the contact.
    max_steps : int
        Largest number of steps; a few suffice from starting values on a tangent of the curve.

    Returns
    -------
    met : Contacts
        Its state is NaN where not solved.
    good : ndarray of bool, shape (n,)
    """
    # Newton step in mm after which the iteration ends: the error is its square over a length of the
    # pair.
    last_step_mm = 1e-9
    # Sine of the angle between the flanks, and radius error relative to the radius, of a solved
    # contact.
    residual_tolerance = 1e-12
    state, final = state.copy(), np.zeros(state.shape[1], dtype=bool)
    active = np.flatnonzero(np.isfinite(state).all(axis=0))
    limits, farthest = surfaces.largest[:, None], np.ones(final.size) if reach is None else reach
    lever = surfaces.pinion.pitch_radius
    short, before = np.zeros(state.shape[1], dtype=int), np.full(state.shape[1], np.inf)
    previous, halvings = np.zeros((3, state.shape[1])), np.zeros(state.shape[1], dtype=int)
    # A step below `small_step_mm` also ends the iteration if the next one, predicted from the last two steps,
    # is below `next_step_mm`.
    small_step_mm, next_step_mm = 1e-6, 1e-12
    # Newton step in mm that may consist of rounding near line contact, and number of such steps that end the
    # iteration.
    rounding_step_mm, max_short_steps = 1e-6, 4
    for _ in range(max_steps):
        if not active.size:
            break
        met = contacts_at(surfaces, placed.of_cases(active), state[:, active])
        value, normal = condition(met, active)
        (h1, h2), (q1, q2) = met.gradient, met.residual
        across = cross(h2, normal)
        step = -(q1 * across + q2 * cross(normal, h1) + value * cross(h1, h2)) / (h1 * across).sum(axis=0)
        # Steps are limited, and the state follows them; s2 by the equation of equal radius.
        step, back = _limited(step / limits, farthest[active], previous[:, active], halvings[active])
        previous[:, active], halvings[active] = step, halvings[active] + back
        step = step * limits
        moved = met.state.copy()
        moved[:3] += step
        other = met.follow[0] + (met.follow[1:] * step).sum(axis=0)
        moved[3] += other
        size = np.maximum(np.abs(step[:2]).max(axis=0), np.maximum(np.abs(other), lever * np.abs(step[2])))
        # Steps that stay small without vanishing are rounding.
        short[active] += size <= rounding_step_mm
        # The convergence is quadratic: the ratio of two steps is squared from step to step.
        following = size * (size / before[active]) ** 2
        last = (size <= small_step_mm) & (before[active] < np.inf) & (following <= next_step_mm)
        last |= (size <= last_step_mm) | (short[active] > max_short_steps)
        before[active] = size
        known = np.isfinite(moved).all(axis=0)
        state[:, active] = np.where(known, moved, met.state)
        done = last & known
        final[active[done]] = True
        active = active[known & ~done]
    met = contacts_at(surfaces, placed, state)
    value, _ = condition(met, np.arange(final.size))
    good = final & (met.error <= residual_tolerance) & met.opposed & np.isfinite(value)
    state[:, ~good] = np.nan
    return met, good


def _limited(
    step: FloatArray, farthest: FloatArray, previous: FloatArray, halvings: Integers
) -> tuple[FloatArray, Mask]:
    """Return a step (3, n) that is not longer than `farthest` (n,), and whether it was halved.

    Where the second derivatives jump, as at a relief, steps may go forth and back without end: a step that
    takes back at least half of the `previous` one (3, n) is halved, once more each time. `halvings` (n,)
    counts the times before. Each time the longest step is halved as well: steps forth are too long where the
    flanks nearly touch along a line."""
    longest = farthest * 0.5**halvings if halvings.any() else farthest
    step = step * np.minimum(1.0, longest / np.abs(step).max(axis=0))
    back = (step * previous).sum(axis=0) < -0.5 * (previous**2).sum(axis=0)
    return step * np.where(back, 0.5 ** (halvings + 1), 1.0) if back.any() else step, back


def meshing_start(surfaces: Surfaces, placed: PairPlacement, s1: FloatArray, z1: FloatArray) -> FloatArray:
    """Return starting states (4, n) for contacts at the flank points (s1, z1) of the pinion, mm.

    The roll satisfies the equation of meshing n.(v1 - v2) = 0 of gears that turn in the ratio of their teeth.
    With k2.((P - E i) x n) written out, this equation is A cos(theta) + B sin(theta) = D for the angle theta
    of the section frame.
    """
    cut = cut_at(surfaces.pinion, s1, z1)
    x, y, nx, ny, nz = cut.x, cut.y, cut.nx, cut.ny, cut.nz
    ratio, along = surfaces.ratio, z1 + placed.position[0]
    moment = x * ny - y * nx
    by_cos = ratio * (placed.sin * (along * nx - x * nz) - placed.cos * placed.offset * ny)
    by_sin = ratio * (placed.sin * (y * nz - along * ny) - placed.cos * placed.offset * nx)
    level = -(moment + ratio * (placed.cos * moment + placed.sin * placed.offset * nz))
    middle = np.arctan2(by_sin, by_cos)
    half = np.arccos(np.clip(level / np.hypot(by_cos, by_sin), -1.0, 1.0))
    # Use the solution that is closer to the pitch point.
    best = np.full(s1.shape, np.inf)
    angle = middle
    for tried in (middle - half, middle + half):
        cos, sin = np.cos(tried), np.sin(tried)
        point = np.array((cos * x - sin * y, sin * x + cos * y, along))
        far = ((point - placed.pitch_point) ** 2).sum(axis=0)
        angle, best = np.where(far < best, tried, angle), np.minimum(far, best)
    angle -= 2.0 * np.pi * np.rint(angle / (2.0 * np.pi))
    # The radius about the gear axis gives s2.
    cos, sin = np.cos(angle), np.sin(angle)
    across = sin * x + cos * y
    x2 = placed.offset - (cos * x - sin * y)
    y2 = placed.sin * along - placed.cos * across
    z2 = placed.sin * across + placed.cos * along - placed.position[1]
    s2 = profile_at(surfaces.gear, x2 * x2 + y2 * y2, z2)
    # Below the base cylinder: halfway between l = 0 and the tip.
    s2 = np.where(np.isnan(s2), 0.5 * surfaces.gear.highest, s2)
    return np.array((s1, z1, angle - cut.phi, s2))
