"""Modified flanks: the modification as a rotation of flank points about the axis of the gear.

A point of the generated flank at the depth delta (`design.modification`) is rotated by

    psi = delta / r_b

into the tooth, with the base radius r_b of its flank: theta -> theta - sigma psi, with sigma = +1 on right
and -1 on left flanks. Radius and z do not change, so that the limits of the flank, its joint with the fillet
and undercut are those of the generated flank. An amount d_n along the normal of the generated flank
corresponds to psi = d_n / |r_P n_y|.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import FloatArray, Mask, Quantity
from ..design.deviations import DeviationShape, Shape
from ..design.modification import Modification, QuadraticShape
from .rack import Numbers


@dataclass(frozen=True, eq=False)
class FlankExtent:
    """Extent of an active flank at mid-face.

    `start` and `tip` (mm of l), half the face width `half` (mm), base radius (mm), `lever` (mm) of a force
    along the normal, m_n N cos(alpha_n) / 2, and the `flank` with `sigma`, +1 on right and -1 on left flanks.
    """

    start: Quantity
    tip: Quantity
    half: Quantity
    base_radius: Quantity
    lever: Quantity
    flank: str
    sigma: float


@dataclass(frozen=True, eq=False)
class Term:
    """One kind of modification on a flank.

    The rotation -sigma psi (rad) is `scale` times the value of the `shape`. The coordinates of the shape are
    `rate[0] (l - origin[0])` and `rate[1] (z - origin[1])`. `relief` is the number of the coordinate that is
    0 where a relief begins, None for other kinds.
    """

    shape: Shape
    scale: Quantity
    origin: tuple[Quantity, Quantity]
    rate: tuple[Quantity, Quantity]
    relief: int | None = None

    def values(self, l: Numbers, z: Numbers, on: Mask | None = None) -> tuple[Any, ...]:
        """Return the values of the shape at flank parameters l in the planes z, mm.

        `on` states where the shape of a relief applies; by default, where the relief has begun.
        """
        places = (l - self.origin[0]) * self.rate[0], (z - self.origin[1]) * self.rate[1]
        values = self.shape(*places)
        if self.relief is None:
            return values
        begun = np.asarray(places[self.relief] > 0.0 if on is None else on, dtype=float)
        return tuple(begun * value for value in values)

    @cached_property
    def quadratic(self) -> tuple[Quantity, ...] | None:
        """The rotation as coefficients of 1, l and z, and second derivatives by l l, l z and z z; None for
        reliefs and for shapes that are not quadratic."""
        if self.relief is not None or not isinstance(self.shape, QuadraticShape):
            return None
        at_origin = self.shape(*(-rate * start for rate, start in zip(self.rate, self.origin, strict=True)))
        return tuple(factor * value for factor, value in zip(self.factors, at_origin, strict=True))

    @cached_property
    def quadratic_relief(self) -> tuple[int, Quantity, np.ufunc, Quantity] | None:
        """For a relief that is quadratic in its coordinate, otherwise None: number and origin of this
        coordinate, the comparison with the origin that shows where the relief has begun, and the second
        derivative of the rotation (rad/mm^2)."""
        square = QuadraticShape(xx=1.0), QuadraticShape(yy=1.0)
        if self.relief is None or self.shape != square[self.relief]:
            return None
        rate = self.rate[self.relief]
        compare = np.greater if np.all(rate > 0.0) else np.less
        return self.relief, self.origin[self.relief], compare, 2.0 * self.scale * rate**2

    @cached_property
    def factors(self) -> tuple[Quantity, ...]:
        """Factors that turn the values of the shape into a rotation (rad) and its derivatives by l and z."""
        (across, along), scale = self.rate, self.scale
        by_place = 1.0, across, along, across * across, across * along, along * along
        return tuple(scale * factor for factor in by_place)

    def past(self, l: FloatArray, z: FloatArray) -> FloatArray:
        """Return the distance (mm) of points from the beginning of a relief, positive on the relief."""
        assert self.relief is not None
        place = (l, z)[self.relief] - self.origin[self.relief]
        return np.asarray(np.sign(self.rate[self.relief]) * place)


@dataclass(frozen=True, eq=False)
class FlankModification:
    """Modification of one flank, by its `terms`."""

    terms: tuple[Term, ...]

    def turn(self, l: Numbers, z: Numbers) -> Numbers:
        """Return the rotation -sigma psi (rad) of points (l, z), mm, about +z."""
        total: Any = 0.0
        for term in self.terms:
            total = total + term.scale * term.values(l, z)[0]
        return np.asarray(total)

    @property
    def measured(self) -> bool:
        """Whether the flank has measured deviations."""
        return any(isinstance(term.shape, DeviationShape) for term in self.terms)

    @property
    def reliefs(self) -> tuple[Term, ...]:
        """Reliefs, at whose beginning the second derivatives jump."""
        return tuple(term for term in self.terms if term.relief is not None)

    def rows(self, l: Numbers, z: Numbers, on: Mask | None = None) -> Numbers:
        """Return `turn` and its derivatives by l, z, l l, l z and z z: (6, ...).

        `on` (reliefs, ...) states for each point which reliefs apply, whether or not the point is past the
        beginning of the relief. A relief that applies is also added before its beginning, by the same
        formula. A relief that does not apply is left out, also after its beginning.
        """
        shape = np.broadcast_shapes(self.batch_shape, np.shape(l), np.shape(z))
        rows = np.empty((6, *shape), dtype=np.result_type(l, z, float))
        constant, by_l, by_z, *bends = self._quadratic
        rows[1], rows[2] = by_l + bends[0] * l + bends[1] * z, by_z + bends[1] * l + bends[2] * z
        rows[0] = constant + 0.5 * (l * (by_l + rows[1]) + z * (by_z + rows[2]))
        rows[3], rows[4], rows[5] = bends
        each = iter(() if on is None else on)
        for term in self.terms:
            begun = None if term.relief is None else next(each, None)
            if term.quadratic_relief is not None:
                coordinate, origin, compare, second = term.quadratic_relief
                past = (l, z)[coordinate] - origin
                bend = (compare(past, 0.0) if begun is None else begun) * second
                slope = bend * past
                rows[0] += 0.5 * slope * past
                rows[1 + coordinate] += slope
                rows[3 + 2 * coordinate] += bend
            elif term.quadratic is None:
                values = term.values(l, z, begun)
                for row, factor, value in zip(rows, term.factors, values, strict=True):
                    row += factor * value
        return rows

    @cached_property
    def _quadratic(self) -> tuple[Quantity, ...]:
        """Sum of the `Term.quadratic` of all terms."""
        parts = [term.quadratic for term in self.terms if term.quadratic is not None]
        return tuple(sum(column, start=0.0) for column in zip(*parts, strict=True)) or (0.0,) * 6

    @cached_property
    def batch_shape(self) -> tuple[int, ...]:
        """Broadcast shape of all amounts, lengths and extents."""
        numbers = [(term.scale, *term.origin, *term.rate) for term in self.terms]
        return np.broadcast_shapes(*(np.shape(number) for row in numbers for number in row))


def flank_modification(modification: Modification, extent: FlankExtent) -> FlankModification:
    """Return the modification of a flank of this extent."""
    start, tip, half = extent.start, extent.tip, extent.half
    terms = []
    for kind, amount, length in modification.terms():
        # Origin and rate of the coordinates: lam and zeta, or t of a relief from its beginning to the edge.
        depth: tuple[Quantity, Quantity] = (0.5 * (start + tip), 2.0 / (tip - start))
        face: tuple[Quantity, Quantity] = (0.0, 1.0 / half)
        relief = None
        if length is not None:
            relief = 0 if kind.profile != "active" else 1
            ends = {
                "tip": (tip - length, 1.0 / length),
                "root": (start + length, -1.0 / length),
                "heel": (half - length, 1.0 / length),
                "toe": (length - half, -1.0 / length),
            }
            depth, face = ends.get(kind.profile, depth), ends.get(kind.face, face)
        if isinstance(kind.shape, QuadraticShape):
            # The profile has no extent (NaN) if the flank does not reach its tip. Omit unused coordinates.
            used = zip((depth, face), kind.shape.axes, strict=True)
            depth, face = (place if needed else (0.0, 0.0) for place, needed in used)
        scale = -extent.sigma * 1e-3 * amount / extent.base_radius
        terms.append(Term(kind.shape, scale, (depth[0], face[0]), (depth[1], face[1]), relief))
    if (given := modification.deviations) is not None:
        # Excess material, a function of l and z themselves.
        terms.append(
            Term(given.shape(extent.flank), extent.sigma * 1e-3 / extent.lever, (0.0, 0.0), (1.0, 1.0))
        )
    return FlankModification(tuple(terms))


def turned_normal(
    normal: tuple[Any, Any, Any], first: tuple[Any, Any], second: tuple[Any, Any]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the unit normals of a surface over a profile coordinate and z from its tangents.

    Parameters
    ----------
    normal : tuple
        Vectors on the outer side of the surface, by components.
    first, second : tuple
        x and y of the tangents by the profile coordinate, at constant z, and by z.
    """
    x, y, z = first[1], -first[0], first[0] * second[1] - first[1] * second[0]
    outwards = np.sign(x * normal[0] + y * normal[1] + z * normal[2])
    size = outwards / np.sqrt(x * x + y * y + z * z)
    return x * size, y * size, z * size
