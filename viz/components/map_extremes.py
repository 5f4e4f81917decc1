"""Extremes of contact ratio and shift over the parabola coefficients.

They are marked in the map of the figure `map-parabola`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beveloid_geom import Design, Errors, MeshErrors, contact_ratio
from beveloid_geom.analysis.optimise import Aim, objectives_of, optimise_parabola
from beveloid_geom.arrays import FloatArray

from . import paths_table


@dataclass(frozen=True, eq=False)
class Extreme:
    """Coefficients, 1/mm, at which a quantity has its extreme `value`; NaN if it was not found."""

    pinion: float = math.nan
    gear: float = math.nan
    value: float = math.nan


def most_ratio(design: Design, flank: str, largest: float) -> Extreme:
    """Return the largest contact ratio within the range of the map, for sums of coefficients up to 0.

    A sum above 0 gives flanks with a negative relative curvature. `largest`: largest coefficient of
    the map, 1/mm (`analysis.maps.usual_bounds`). Sums are searched from -0.5 to 0 times, differences from -2
    to 2 times this coefficient.

    The ridge of the ratio has a kink, so the search begins at the best of 101 sums times 21 differences. Then
    it computes smaller and smaller grids around the best point."""

    def coefficients(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return both coefficients, 1/mm, from sum and difference (2, n) in units of `largest`."""
        return 0.5 * largest * (x[0] + x[1]), 0.5 * largest * (x[0] - x[1])

    def grid(low: FloatArray, high: FloatArray, counts: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return points (2, n) between two corners, and their contact ratios, zero without a path."""
        axes = [np.linspace(a, b, count) for a, b, count in zip(low, high, counts, strict=True)]
        points = np.reshape(np.meshgrid(*axes), (2, -1))
        return points, np.nan_to_num(contact_ratio(design.with_parabola(*coefficients(points)), flank))

    lowest, highest = np.array([-0.5, -2.0]), np.array([0.0, 2.0])
    points, values = grid(lowest, highest, (101, 21))
    if not values.any():
        return Extreme()
    best, greatest, reach = points[:, values.argmax()], values.max(), np.array([0.005, 0.2])
    # Number of grids in the search of the largest contact ratio, and ratio of their sizes.
    grids, shrinkage = 14, 0.4
    for _ in range(grids):
        points, values = grid(np.maximum(best - reach, lowest), np.minimum(best + reach, highest), (15, 15))
        if values.max() > greatest:  # on parallel axes, only one point has lines of contact
            best, greatest = points[:, values.argmax()], values.max()
        reach *= shrinkage
    pinion, gear = coefficients(best)
    return Extreme(float(pinion), float(gear), float(greatest))


def least_shift(
    design: Design, flank: str, errors: Errors | MeshErrors, ratio: float, most: float, largest: float
) -> Extreme:
    """Return the coefficients with the least shift of the path under `errors`, mm.

    Condition: the contact ratio is not below `ratio`, that of the design as given. Coefficients are searched
    between -`largest` and `largest`, 1/mm. `most`: largest contact ratio of the map. If no coefficients have
    a larger ratio than the given ones, as for unmodified flanks on parallel axes, only the given ones meet
    the condition, and nothing is searched."""
    if not ratio > 0.0:
        return Extreme()
    face = float(design.pinion.face_width)
    bounds = (-largest, largest)
    aim = Aim(errors, ratio, off_centre=face, pinion_parabola=bounds, gear_parabola=bounds)
    if not _is_exceeded(design, flank, ratio, most, largest):
        given = paths_table.parabolas(design, flank)
        shift = float(objectives_of(design, flank, aim, *(np.asarray(one) for one in given)).shift)
        return Extreme() if math.isnan(shift) else Extreme(*given, shift)
    try:
        optimum = optimise_parabola(design, aim, flank)
    except ValueError:  # no coefficients meet the condition
        return Extreme()
    return Extreme(optimum.pinion_parabola, optimum.gear_parabola, float(optimum.optimum.shift))


def _is_exceeded(design: Design, flank: str, ratio: float, most: float, largest: float) -> bool:
    """Return True if any coefficients with a sum up to 0 have a larger contact ratio than `ratio`."""
    least_gain = 1e-6
    first, second = np.meshgrid(*2 * [largest * np.linspace(-1.0, 1.0, 21)])
    full = first + second <= 0.0
    values = contact_ratio(design.with_parabola(first[full], second[full]), flank)
    return bool(np.fmax(most, np.fmax.reduce(values)) > (1.0 + least_gain) * ratio)
