"""The contacts of one flank pair as a curve: five equations in six unknowns (Eq. 15).

Points and unit normals of both flanks (Eq. 6) are transformed to S_f (Eqs. 7-14). R1 = R2 and two components
of n1 = -n2 are five equations in l1, u1, l2, u2 and both rolls, which the paper solves at given pinion rolls.
Here the sixth equation is a plane that the curve of contacts crosses: the curve is followed by its length
(pseudo-arclength continuation). Therefore the points at which the pinion roll or l1 turns back, or n_x of the
common normal vanishes, are regular.

The unknowns are scaled before lengths along the curve are computed: l by the module, u by half the face
width, rolls by the pitch angle. The Jacobian is computed by complex steps. SciPy's `fsolve` computes the
corrections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, fsolve

from ..arrays import COMPLEX_STEP, FloatArray, Integers
from ..design.arguments import require_unmodified
from ..design.model import Design
from ..gear.crossing_curve import CrossingCurve
from ..gear.flank import generated
from ..gear.flank_limits import highest_parameter, root_parameter
from ..gear.rack import Numbers, Rack, rack_normal, rack_of, rack_point, reference_radius
from ..gear.tooth_side import undercut_edge
from ..pair.frames import layout_of, member_frame
from ..pair.mounting import mounting_of

LARGEST_STEP = 0.1
"""Largest step along the curve, in scaled unknowns."""


class Unknown(IntEnum):
    """Unknowns of the five equations, of which the pinion roll or another one is given."""

    L1 = 0
    U1 = 1
    L2 = 2
    U2 = 3
    GEAR_ROLL = 4
    PINION_ROLL = 5


@dataclass(frozen=True, eq=False)
class FivePositions:
    """Contacts of the five equations: `unknowns` (..., 6) l1, u1, l2, u2 (mm), gear roll, pinion roll (rad);
    `member_points` (2, ..., 3) in the frames of the members; `point` and `normal` (2, ..., 3) in S_f."""

    unknowns: Numbers
    member_points: Numbers
    point: Numbers
    normal: Numbers


@dataclass(frozen=True, eq=False)
class FiveEquations:
    """The five equations of one flank pair and the limits of its flanks.

    `rack`: flanks of the racks of pinion and gear; vectors have the shape (3, 2, 1, 1), numbers (2, 1, 1).
    `rotation` (2, 3, 3) and `origin` (2, 3), mm, transform the rotated members to S_f. The unknowns are
    divided by `scale` (6,), mm and rad. `limits` (4, 2) of pinion and gear: smallest l (mm), radius of the
    tip cone at mid-face (mm), tangent of its angle, half the face width (mm). `reach` (8,): distances beyond
    the limits, in the order of `Limit`, to which a curve is followed, mm. `edges`: line at which undercut
    ends the flank, for each member; None without undercut."""

    rack: Rack
    rotation: FloatArray
    origin: FloatArray
    scale: FloatArray
    limits: FloatArray
    reach: FloatArray
    edges: tuple[CrossingCurve | None, ...] = (None, None)

    XTOL: ClassVar = 1e-14
    """Relative step at which `fsolve` ends for results."""

    def at(self, unknowns: Numbers) -> FivePositions:
        """Return points and normals at unknowns (..., 6), real or complex."""
        flat, shape = unknowns.reshape(-1, 6).T, (2, *unknowns.shape[:-1], 3)
        l, u, roll = (flat[rows, None] for rows in ([0, 2], [1, 3], [5, 4]))
        trace, normal = self.rack.trace, rack_normal(self.rack, l)
        member_points, normal = generated(self.rack, rack_point(self.rack, l) + u * trace, normal)
        point = self._to_fixed(member_points, roll) + self.origin[:, None]  # Eq. (7)
        normal = self._to_fixed(normal, roll)  # Eq. (8)
        return FivePositions(
            unknowns, member_points.reshape(shape), point.reshape(shape), normal.reshape(shape)
        )

    def _to_fixed(self, vectors: Numbers, roll: Numbers) -> Numbers:
        """Return vectors (2, 1, positions, 3) of members rotated by `roll` in S_f, (2, positions, 3)."""
        cos, sin = np.cos(roll), np.sin(roll)
        x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
        turned = np.stack((cos * x - sin * y, sin * x + cos * y, z), axis=-1)
        return np.asarray(turned[:, 0] @ self.rotation.transpose(0, 2, 1))

    def residual(self, scaled: Numbers, components: Integers) -> Numbers:
        """Return R1 - R2 and two components of n1 + n2 (Eq. 15), (..., 5)."""
        here = self.at(scaled * self.scale)
        both = (here.point[0] - here.point[1], (here.normal[0] + here.normal[1])[..., components])
        return np.concatenate(both, axis=-1)

    def jacobian(self, scaled: FloatArray, components: Integers) -> FloatArray:
        """Return the derivatives (5, 6) of the residual by the scaled unknowns, exact to rounding."""
        return _slopes(lambda steps: self.residual(steps, components), scaled)

    def compared(self, scaled: FloatArray) -> Integers:
        """Return the two components of the normals to compare: all but the largest, which is the least
        sensitive."""
        return np.sort(np.argsort(np.abs(self.at(scaled * self.scale).normal[0]))[:2])

    def tangent(self, scaled: FloatArray, along: FloatArray | None = None) -> FloatArray | None:
        """Return the unit tangent (6,) of the curve of contacts, in the sense of `along`; None if the flanks
        have none."""
        slopes = self.jacobian(scaled, self.compared(scaled))
        if not np.isfinite(slopes).all():
            return None
        tangent = np.linalg.svd(slopes)[2][-1]
        return np.asarray(tangent if along is None or tangent @ along >= 0.0 else -tangent)

    def correct(self, start: FloatArray, across: FloatArray, xtol: float = XTOL) -> FloatArray | None:
        """Return the contact (6,) in the plane through `start` perpendicular to `across`, both scaled; None
        if the solver fails."""
        return self._solved(start, lambda scaled: (scaled - start) @ across, xtol)

    def meet_limit(self, start: FloatArray, limit: int) -> FloatArray | None:
        """Return the contact (6,) near `start`, scaled, at which a limit is met; None if the solver fails."""
        return self._solved(start, lambda scaled: self.margins(scaled)[..., limit], self.XTOL)

    def _solved(
        self, start: FloatArray, sixth: Callable[[Numbers], Numbers], xtol: float
    ) -> FloatArray | None:
        """Return the zero of the five equations and a sixth one, of unknowns (..., 6), real or complex."""
        components = self.compared(start)

        def six(scaled: Numbers) -> Numbers:
            return np.concatenate((self.residual(scaled, components), sixth(scaled)[..., None]), axis=-1)

        # Largest residual, mm and 1, of an accepted position. The status of `fsolve` is not used, because it
        # reports rounding noise at this xtol as lack of progress.
        residual_limit = 1e-9
        with np.errstate(all="ignore"):
            try:
                solution = fsolve(six, start, fprime=partial(_slopes, six), xtol=xtol, full_output=True)[0]
            except ValueError:  # NaN in an iteration
                return None
            left = *self.misfit(solution * self.scale), abs(float(sixth(solution)))
            return solution if max(left) <= residual_limit else None

    def misfit(self, unknowns: FloatArray) -> tuple[float, float]:
        """Return the largest component of R1 - R2 (mm) and of n1 + n2 at unknowns (6,); infinite for NaN."""
        here = self.at(unknowns)
        gap = float(np.abs(here.point[0] - here.point[1]).max())
        normal_gap = float(np.abs(here.normal[0] + here.normal[1]).max())
        return (gap, normal_gap) if np.isfinite(gap + normal_gap) else (np.inf, np.inf)

    def margins(self, scaled: Numbers) -> Numbers:
        """Return the distances (..., 8) inside the limits, in the order of `Limit`, mm."""
        unknowns = scaled * self.scale
        low, tip, taper, half = self.limits
        member_points = self.at(unknowns).member_points
        x, y, z = (np.moveaxis(member_points[..., k], 0, -1) for k in range(3))
        l = np.stack((unknowns[..., 0], unknowns[..., 2]), axis=-1)
        above = l - low
        for j, curve in enumerate(self.edges):
            if curve is not None:  # undercut ends the flank; complex steps need the slope of this limit
                start, slope, _ = curve.rows(z[..., j].real.ravel())[0].reshape(3, *z.shape[:-1])
                beyond = l[..., j] - start - slope * (z[..., j] - z[..., j].real)
                above[..., j] = np.where(beyond.real < above[..., j].real, beyond, above[..., j])
        parts = (above, tip + taper * z - np.sqrt(x * x + y * y), half + z, half - z)
        return np.concatenate(parts, axis=-1)


def _slopes(function: Callable[[Numbers], Numbers], scaled: FloatArray) -> FloatArray:
    """Return the derivatives (k, 6) of equations (..., k) by the scaled unknowns (6,), exact to rounding."""
    steps = scaled + np.diag(np.full(6, COMPLEX_STEP * 1j))
    return np.asarray(function(steps).imag.T / COMPLEX_STEP)


def five_equations_of(design: Design, flank: str) -> FiveEquations:
    """Return the five equations of a single design."""
    require_unmodified(flank, "the five equations", pinion=design.pinion, gear=design.gear)
    layout, errors, distance = layout_of(design), design.errors, mounting_of(design).distance
    position = (distance[0] + errors.pinion_axial, distance[1] + errors.gear_axial)
    frames = [member_frame(layout, j, 0.0, position[j]) for j in range(2)]
    scale, limits, reach = [], [], []
    for member in design.members:
        low, high = root_parameter(member, flank), highest_parameter(member, flank)
        height = (member.profile_shift + member.tip_height) * member.tool.normal_module
        tip, half = reference_radius(member) + height, 0.5 * member.face_width
        scale.append((member.tool.normal_module, half, 2.0 * np.pi / member.teeth))
        limits.append((low, tip, np.tan(member.cone_angle), half))
        reach.append((high - low, high - low, 2.0 * half, 2.0 * half))
    (m1, b1, p1), (m2, b2, p2) = scale
    return FiveEquations(
        rack=rack_of(design.stacked_members(), flank),
        rotation=np.array([rotation for rotation, _ in frames]),
        origin=np.array([origin for _, origin in frames]),
        scale=np.array((m1, b1, m2, b2, p2, p1), dtype=float),
        limits=np.array(limits, dtype=float).T,
        reach=np.array(reach, dtype=float).T.ravel(),
        edges=(undercut_edge(design.pinion, flank), undercut_edge(design.gear, flank)),
    )


@dataclass(frozen=True, eq=False)
class FiveCurve:
    """A curve of contacts: a spline through nodes, by the length `s` along the curve.

    `s` (nodes,); `margins` of the nodes and their `rates` by s (nodes, 8); `spline` of the scaled
    unknowns."""

    system: FiveEquations
    s: FloatArray
    margins: FloatArray
    rates: FloatArray
    spline: CubicHermiteSpline[Any]

    def at(self, s: float) -> FloatArray:
        """Return the scaled unknowns (6,) at length s, in the plane perpendicular to the spline."""
        start, along = self.spline(s), self.spline(s, 1)
        contact = self.system.correct(start, along / np.linalg.norm(along))
        if contact is None:
            raise ArithmeticError("the five equations lose the contact between two known positions")
        return contact

    def end(self, s: float) -> FloatArray:
        """Return the scaled unknowns (6,) where a limit is met at length s, with the limit met to rounding.
        `at(s)` alone would miss it by the rounding error of an ill-conditioned contact."""
        # Largest change of the scaled unknowns of an end when its limit is met.
        end_tolerance = 1e-6
        start = self.at(s)
        contact = self.system.meet_limit(start, int(self.system.margins(start).argmin()))
        near = contact is not None and np.linalg.norm(contact - start) < end_tolerance
        return contact if contact is not None and near else start

    def least_margin(self, s: float) -> float:
        """Return the smallest distance (mm) inside the limits at s."""
        return float(self.system.margins(self.at(s)).min())

    def rate(self, s: float, row: int) -> float:
        """Return the rate of one unknown along the curve at s."""
        tangent = self.system.tangent(self.at(s), self.spline(s, 1))
        return np.nan if tangent is None else float(tangent[row])

    def pieces(self) -> FloatArray:
        """Return the lengths at which the curve enters and leaves the flanks, (segments, 2) in s, ascending.

        The roots of the cubics through the margins, and their extrema close to zero, are the starting
        intervals. The results are roots of the exact smallest margin."""
        # Extrema of a margin closer to zero are probed for two crossings.
        near_zero_mm = 0.02
        cubics = CubicHermiteSpline(self.s, self.margins, self.rates)
        roots = np.concatenate(list(cubics.roots(extrapolate=False)))
        turns = [
            np.array([x for x in extrema if abs(float(cubics(x)[k])) < near_zero_mm])
            for k, extrema in enumerate(cubics.derivative().roots(extrapolate=False))
        ]
        cuts = np.concatenate((roots, *turns))
        edges = _sign_changes(self.least_margin, cuts, (self.s[0], self.s[-1]), np.concatenate(turns))
        if len(edges) % 2 or self.least_margin(self.s[0]) > 0.0:
            raise ArithmeticError("the contact is a closed curve on the flanks without an end")
        return edges.reshape(-1, 2)

    def turns(self, row: int, piece: tuple[float, float]) -> FloatArray:
        """Return the positions s (lengths along the curve) in the range `piece` at which an unknown turns
        back."""
        extrema = np.asarray(self.spline.derivative().roots(extrapolate=False)[row])
        return _sign_changes(lambda s: self.rate(s, row), extrema, piece, np.empty(0))


def _sign_changes(
    value: Callable[[float], float], cuts: FloatArray, ends: tuple[float, float], extra: FloatArray
) -> FloatArray:
    """Return roots of `value` between `ends`: one in each interval between probes in which the sign changes.
    The probes are the ends, the middles between neighbouring `cuts`, and `extra`."""
    low, high = ends
    stops = np.concatenate(([low], np.sort(cuts[(cuts > low) & (cuts < high)]), [high]))
    probes = np.unique(np.concatenate((ends, 0.5 * (stops[1:] + stops[:-1]), extra)))
    values = [value(float(s)) for s in probes]
    return np.array(
        [
            brentq(value, probes[k], probes[k + 1], xtol=1e-15, rtol=1e-14)
            for k in range(len(probes) - 1)
            if (values[k] > 0.0) != (values[k + 1] > 0.0)
        ]
    )


def _trace(
    system: FiveEquations, start: FloatArray, tangent: FloatArray, reach: FloatArray
) -> tuple[list[FloatArray], list[FloatArray], bool]:
    """Return nodes and tangents from `start` to beyond the limits by `reach`, to the end of contact outside
    them, or back to the start, and whether the last node is the first."""
    nodes, tangents, step = [start], [tangent], 0.05
    max_steps = 3000
    least_step = 1e-6
    for _ in range(max_steps):
        here, along = nodes[-1], tangents[-1]
        margins = system.margins(here)
        if (margins < -reach).any():
            return nodes, tangents, False
        ahead = _ahead(system, here, along, step)
        if ahead is None:
            step *= 0.5
            if step >= least_step:
                continue
            if margins.min() < 0.0:
                return nodes, tangents, False
            raise ArithmeticError(_lost(here * system.scale))
        node = ahead[0]
        back, on = (start - here) @ tangent, (start - node) @ tangent
        if len(nodes) > 2 and back >= 0.0 >= on and np.linalg.norm(start - here) < 2.0 * step:
            return [*nodes, start], [*tangents, tangent], True
        nodes.append(node)
        tangents.append(ahead[1])
        step = min(1.5 * step, LARGEST_STEP)
    text = f"the curve of contacts of the five equations does not end within {max_steps} steps"
    raise ArithmeticError(f"{text}: use the one-equation method")


def _ahead(
    system: FiveEquations, here: FloatArray, along: FloatArray, step: float
) -> tuple[FloatArray, FloatArray] | None:
    """Return the contact one step ahead and its tangent; None if the step is too long."""
    guess = here + step * along
    # Relative step at which `fsolve` ends for nodes of the curve.
    node_xtol = 1e-8
    node = system.correct(guess, along, node_xtol)
    # Limits between neighbouring nodes: cosine of the angle between their tangents, and correction relative
    # to the step. A step outside these limits may have changed to another branch and is halved.
    smallest_tangent_cosine, largest_correction = 0.98, 0.2
    if node is None or np.linalg.norm(node - guess) > largest_correction * step:
        return None
    tangent = system.tangent(node, along)
    return None if tangent is None or tangent @ along < smallest_tangent_cosine else (node, tangent)


def _lost(unknowns: FloatArray) -> str:
    roll = np.degrees(unknowns[Unknown.PINION_ROLL])
    text = f"the five equations lose the contact at pinion roll {roll:.4f} deg before a limit of the flanks"
    return f"{text} is met: use the one-equation method"


def follow_five_equations(system: FiveEquations, start: FloatArray) -> FiveCurve:
    """Return the curve of contacts through a contact (6,), scaled, followed in both directions.

    Raises ArithmeticError if the contact is lost on the flanks."""
    reach = np.maximum(system.reach, -2.0 * system.margins(start))
    tangent = system.tangent(start)
    if tangent is None:
        raise ArithmeticError(_lost(start * system.scale))
    nodes, tangents, closed = _trace(system, start, tangent, reach)
    if not closed:
        back, back_tangents, _ = _trace(system, start, -tangent, reach)
        nodes = back[:0:-1] + nodes
        tangents = [-t for t in back_tangents[:0:-1]] + tangents
    if len(nodes) < 2:
        raise ArithmeticError(_lost(start * system.scale))
    y, t = np.array(nodes), np.array(tangents)
    if closed:  # start where the curve is furthest outside the flanks
        first = int(system.margins(y).min(axis=-1).argmin())
        y, t = (np.concatenate((x[first:-1], x[: first + 1])) for x in (y, t))
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(y, axis=0), axis=-1))))
    rates = system.margins(y + COMPLEX_STEP * 1j * t).imag / COMPLEX_STEP
    return FiveCurve(system, s, system.margins(y), rates, CubicHermiteSpline(s, y, t))
