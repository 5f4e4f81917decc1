"""B-splines of degree 7 through exact points, with the fewest knots for a given distance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray

DEGREE = 7


class Break(NamedTuple):
    """Parameter `place` (0 ... 1) at which a derivative of a function jumps.

    The first `continuous` derivatives of a B-spline are continuous there. The next one may jump; 0 allows a
    kink."""

    place: float
    continuous: int


def knots_with(spans: int, breaks: Sequence[Break] = ()) -> FloatArray:
    """Return clamped knots over 0 ... 1 with a number of spans between any two `breaks`."""
    ends = np.array((0.0, *(one.place for one in breaks), 1.0))
    spaced = [np.linspace(low, high, spans + 1)[:-1] for low, high in pairwise(ends)]
    inner = [
        np.append(np.repeat(part[:1], DEGREE - 1 - one.continuous), part)
        for part, one in zip(spaced[1:], breaks, strict=True)
    ]
    return np.concatenate((np.zeros(DEGREE), spaced[0], *inner, np.ones(DEGREE + 1)))


def nodes_of(knots: FloatArray) -> FloatArray:
    """Return the interpolation points of a B-spline: Greville's, the means of DEGREE consecutive knots."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(knots[1:-1], DEGREE).mean(axis=-1))


def poles_of(knots: FloatArray, values: FloatArray, axis: int = 0) -> FloatArray:
    """Return the poles of the B-spline through values at the nodes of its knots."""
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(nodes_of(knots), values, DEGREE, knots, axis=axis)
    return np.asarray(np.moveaxis(spline.c, 0, axis))


def fitted_knots(
    values: Callable[[FloatArray], FloatArray], fit: float, breaks: Sequence[Break] = ()
) -> FloatArray:
    """Return the fewest knots for which B-splines through `values` (n, ...) are within `fit` (mm) of them.

    Raises
    ------
    ValueError
        If no number of spans suffices.
    """
    from scipy.interpolate import BSpline

    span_counts = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)
    for spans in span_counts:
        knots = knots_with(spans, breaks)
        nodes = nodes_of(knots)
        between = (nodes[:-1] + np.diff(nodes) * np.array([[0.25], [0.5], [0.75]])).ravel()
        spline = BSpline(knots, poles_of(knots, values(nodes)), DEGREE)
        if np.abs(spline(between) - values(between)).max() < fit:
            return knots
    text = f"B-splines with {span_counts[-1]} spans deviate by more than {fit:g} mm from the tooth"
    raise ValueError(f"{text}: use a narrower face, a smaller parabola or a smaller helix angle")
