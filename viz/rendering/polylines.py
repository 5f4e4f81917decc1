"""Polylines: dashes, and fewer points for tubes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]


def dashed(points: FloatArray, pattern: Sequence[float]) -> Iterable[FloatArray]:
    """Return pieces of a polyline (n, 3) with lengths of dash, gap, dash, gap, ... in mm; the complete line
    without a pattern."""
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    if not pattern or along[-1] <= pattern[0]:
        yield points
        return
    ends = np.cumsum(pattern)
    for start in np.arange(0.0, along[-1], ends[-1]):
        for first, last in zip((0.0, *ends[1::2]), ends[::2], strict=False):
            begin, end = start + first, min(start + last, along[-1])
            if begin >= end:
                return
            inside = along[(along > begin) & (along < end)]
            at = np.concatenate(([begin], inside, [end]))
            yield np.stack([np.interp(at, along, column) for column in points.T], axis=-1)


def spaced(points: FloatArray, least: float) -> FloatArray:
    """Remove points (n, 3) closer than `least`, mm, to the previous point, except the last. Otherwise a tube
    that turns within its width would have spikes."""
    indices = [0]
    for number in range(1, len(points)):
        if np.linalg.norm(points[number] - points[indices[-1]]) >= least:
            indices.append(number)
    indices = indices[:-1] if 0 < indices[-1] < len(points) - 1 else indices
    return points[list(dict.fromkeys((*indices, len(points) - 1)))]


def simplified(points: FloatArray, tolerance: float) -> FloatArray:
    """Return the points of a polyline (n, 3) that keep it within a tolerance, mm, of the original (algorithm
    of Ramer, Douglas and Peucker)."""
    indices, parts = {0, len(points) - 1}, [(0, len(points) - 1)]
    while parts:
        first, last = parts.pop()
        away, chord = points[first : last + 1] - points[first], points[last] - points[first]
        square = float(chord @ chord)  # zero for a closed line
        share = np.clip(away @ chord / square, 0.0, 1.0) if square else np.zeros(len(away))
        distance = np.linalg.norm(away - share[:, None] * chord, axis=1)
        worst = first + int(np.argmax(distance))
        if distance.max() > tolerance:
            indices.add(worst)
            parts += [(first, worst), (worst, last)]
    return points[sorted(indices)]
