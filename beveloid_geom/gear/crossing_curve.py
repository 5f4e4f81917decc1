"""The curve on which flank and fillet of an undercut tooth intersect, as a series along the face.

In each plane z the tooth consists of the flank above the intersection and of the fillet below it. Both
meet at one radius r(z), at the profile coordinate `start` of the flank and `end` of the fillet
(`tooth_surface`). The three are Chebyshev series over the undercut part of the face and its
continuation. `crossing` computes them.

Where undercut begins within the face, all three are continued into the planes without undercut, so that
limits based on them have a continuous slope. `start` is continued along its tangent, so that it does not
limit the flank there; `end` and r(z) are continued as constants.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, Mask
from ..support.chebyshev import polynomials, with_derivative

START, END, RADIUS = 0, 1, 2
"""Rows of a curve."""


@dataclass(frozen=True, eq=False)
class FacePart:
    """A part of the face that is undercut, from `low` to `high` (mm from mid-face).

    `series` (9, degree + 1): `start`, `end` and radius (mm), and their first and second derivatives by the
    variable of the series. `onset` states whether undercut begins at `low` and at `high`; there the series
    are continued as described above, and elsewhere beyond toe and heel as constants. `bottom` (mm) is the
    end of the fillet, below which `start` is not continued.
    """

    low: float
    high: float
    series: FloatArray
    onset: tuple[bool, bool]
    bottom: float

    def rows(self, z: FloatArray) -> FloatArray:
        """Return `start`, `end` and radius with first and second derivatives by z: (3, 3, n)."""
        half = 0.5 * (self.high - self.low)
        # Evaluate the series inside the part.
        inside = np.minimum(np.maximum(z, self.low), self.high)
        x = (inside - 0.5 * (self.low + self.high)) / half
        values = (self.series @ polynomials(x, self.series.shape[-1] - 1)).reshape(3, 3, -1)
        rows = values.swapaxes(0, 1) / np.array((1.0, half, half * half))[:, None]
        # Continue beyond its ends: along the tangent where undercut begins, else as constants.
        beyond = z != inside
        if beyond.any():
            into_sound = ((z < self.low) & self.onset[0]) | ((z > self.high) & self.onset[1])
            slope = np.where(into_sound, rows[START, 1], 0.0)
            rows[:, 1:, beyond] = 0.0
            start = rows[START, 0] + slope * (z - inside)
            above_bottom = beyond & (start > self.bottom)
            rows[START, 1, above_bottom] = slope[above_bottom]
            rows[START, 0] = np.maximum(start, self.bottom)
        return np.asarray(rows)


@dataclass(frozen=True, eq=False)
class CrossingCurve:
    """Curve on which flank and fillet of an undercut tooth intersect, in one or two `parts` of the face, from
    low to high z.
    """

    parts: tuple[FacePart, ...]

    def rows(self, z: FloatArray) -> FloatArray:
        """Return `start`, `end` and radius (mm) with first and second derivatives by z, in the planes `z`
        (n,), mm: (3, 3, n)."""
        rows = self.parts[0].rows(z)
        for before, part in zip(self.parts[:-1], self.parts[1:], strict=True):
            after = z > 0.5 * (before.high + part.low)
            rows = np.where(after, part.rows(z), rows)
        return rows

    def start(self, z: FloatArray) -> FloatArray:
        """Return the profile coordinate of the flank on the curve in the planes `z` (...), mm."""
        return self._row(START, z)

    def plane(self, start: FloatArray, half: float) -> FloatArray:
        """Return the planes z (n,), mm, in which the flank begins at the profile coordinates `start` (n,).

        `start` (mm) must lie between its values at the ends of the face, -`half` and `half` (mm). Newton's
        method is used inside a bracket, starting from chords of the curve.
        """
        # Newton step, relative to half the face width, below which the iteration ends: the error is
        # its square.
        last_plane_step = 1e-9
        # Number of chords from which the search for a plane starts, and maximum steps of this search.
        chord_count, newton_max_steps = 64, 60
        z = half * np.linspace(-1.0, 1.0, chord_count + 1)
        values = self.start(z)
        rising = bool(values[-1] > values[0])
        # Start from the chords, then Newton's method with a bracket.
        order = slice(None, None, 1 if rising else -1)
        result = np.interp(start, np.maximum.accumulate(values[order]), z[order])
        low, high = np.full_like(start, -half), np.full_like(start, half)
        for _ in range(newton_max_steps):
            value, rate = self.rows(result)[START, :2]
            higher = (value < start) == rising
            low, high = np.where(higher, result, low), np.where(higher, high, result)
            with np.errstate(divide="ignore", invalid="ignore"):
                following = result + (start - value) / rate
            within = (following >= low) & (following <= high)
            following = np.where(within, following, 0.5 * (low + high))
            step, result = np.abs(following - result).max(initial=0.0), following
            if step <= last_plane_step * half:
                break
        return result

    def end(self, z: FloatArray) -> FloatArray:
        """Return the profile coordinate of the fillet on the curve in the planes `z` (...), mm."""
        return self._row(END, z)

    def radius(self, z: FloatArray) -> FloatArray:
        """Return the radius of the curve in the planes `z` (...), mm."""
        return self._row(RADIUS, z)

    def undercut(self, z: FloatArray) -> Mask:
        """Return whether the planes `z` (...), mm, are undercut."""
        result = np.zeros(np.shape(z), dtype=bool)
        for part in self.parts:
            result |= ((z > part.low) | (not part.onset[0])) & ((z < part.high) | (not part.onset[1]))
        return result

    def _row(self, row: int, z: FloatArray) -> FloatArray:
        z = np.asarray(z, dtype=float)
        return np.asarray(self.rows(z.ravel())[row, 0].reshape(z.shape))


def face_part(
    low: float, high: float, values: FloatArray, onset: tuple[bool, bool], bottom: float
) -> FacePart:
    """Return the part of the face between `low` and `high` with these `values` (3, nodes) of `start`, `end`
    and radius at the nodes of `curve_nodes`.
    """
    order, nodes = np.arange(values.shape[1]), curve_nodes(values.shape[1])
    fit = 2.0 / order.size * np.cos(np.multiply.outer(np.arccos(nodes), order))
    fit[:, 0] *= 0.5
    series = values @ fit
    both = with_derivative(series)
    return FacePart(low, high, np.concatenate((both, with_derivative(both)[-3:])), onset, bottom)


def curve_nodes(count: int) -> FloatArray:
    """Return the zeros of the Chebyshev polynomial of this degree. No zero is at an end, where flank and
    fillet do not intersect if undercut begins there.
    """
    return np.asarray(-np.cos((np.arange(count) + 0.5) * np.pi / count))
