"""Measured deviations of both flanks of a tooth, as a modification.

`workshop.measured` computes them from measured points. The deviation at the flank parameters (l, z) is the
angle by which the flank is rotated out of the tooth, times the lever m_n N cos(alpha_n) / 2. This is the
deviation along the normal: exactly on straight tools, and to first order with a parabola. The rotated flank
passes through the measured points.

Along the profile, the coordinate of the spline (`support.tensor_spline`) is the position t between the first
and the last row of the grid, t = (l - a(z)) / b(z). a and b are linear in z, because the tip of a beveloid
rises along the face.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray
from ..support.array_repr import short_repr
from ..support.frozen_arrays import cached, restored
from ..support.tensor_spline import spline_through
from .field_limits import DesignError, Fault

Shape: TypeAlias = Callable[[Any, Any], tuple[Any, ...]]
"""Function of a profile and a face coordinate. It returns an amount and its derivatives: by profile, by face,
twice by profile, by both, twice by face."""
_ARRAYS = ("l", "z", "deviation_um")


@dataclass(frozen=True, eq=False)
class FlankDeviations:
    """Measured deviations of right and left flank, an input of `Modification`.

    `Deviations.on_flanks` returns them for measured points.

    Parameters
    ----------
    l, z : array, shape (2, rows, columns)
        Positions on the right and on the left flank, mm: flank parameter and distance from mid-face. Rows run
        from root to tip, columns towards +z.
    deviation_um : array, shape (2, rows, columns)
        Deviation along the normal, um, positive for excess material.
    file : str
        Absolute path of the file from which they were read; empty if there is none.
    border : str
        Distance of the outermost points of this file from the edges of the flank, as a share of flank depth
        and face width ('10%') or as a length ('2mm').
    nominal : Member or None
        Member whose flanks were compared with the points of this file.
    teeth : tuple of FlankDeviations
        Tables of single teeth, tooth 0 first. These deviations are their mean (`mean_deviations`).
        `pitch_cycle` uses them. Empty if one table holds for all teeth.

    Raises
    ------
    DesignError
        If the arrays do not have this shape, or have missing or too large values, or another order.
    """

    __repr__ = short_repr

    l: FloatArray
    z: FloatArray
    deviation_um: FloatArray
    file: str = ""
    border: str = ""
    nominal: Any = None
    teeth: tuple[FlankDeviations, ...] = ()

    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check and copy the arrays. Raises DesignError."""
        max_deviation_um = 1e5
        # Largest number of points on a flank.
        max_points = 20_000
        values = vars(self)
        for name in _ARRAYS:
            array = np.array(values[name], dtype=float)
            if (
                array.ndim != 3
                or array.shape[0] != 2
                or min(array.shape) < 2
                or array.shape != np.shape(self.l)
            ):
                limit = "must have the shape of l, (2, rows, columns) with at least 2 rows and 2 columns"
                text = f"{limit}, got {array.shape}: give one value for each point of the grid"
                raise DesignError([Fault("", name, text)], "FlankDeviations")
            if not np.isfinite(array).all():
                text = "must contain finite numbers only: measure the missing points again"
                raise DesignError([Fault("", name, text)], "FlankDeviations")
            array.flags.writeable = False
            values[name] = array
        if self.l[0].size > max_points:
            limit = f"must have at most {max_points} points on a flank, got {self.l[0].size}"
            raise DesignError([Fault("", "deviation_um", f"{limit}: use a coarser grid")], "FlankDeviations")
        if (largest := float(np.abs(self.deviation_um).max())) > max_deviation_um:
            limit = f"must be at most {max_deviation_um:g} um in magnitude, got {largest:g}: give it in um"
            raise DesignError([Fault("", "deviation_um", limit)], "FlankDeviations")
        for flank in FLANK_SIGN:
            try:
                deviation_shape(self, flank)
            except ValueError as error:
                order = f"{error}: order the rows from root to tip and the columns towards +z"
                raise DesignError([Fault("", "deviation_um", order)], "FlankDeviations") from None

    @property
    def _key(self) -> tuple[Any, ...]:
        """Values by which deviations are compared."""
        arrays = (self.l.tobytes(), self.z.tobytes(), self.deviation_um.tobytes())
        return self.l.shape, self.file, self.border, self.teeth, *arrays

    def __eq__(self, other: object) -> bool:
        """Return whether all values and the file are equal. `nominal` is not compared."""
        if not isinstance(other, FlankDeviations):
            return NotImplemented
        return self is other or self._key == other._key

    def __hash__(self) -> int:
        """Return the hash of the values that are compared."""
        if "_hash" not in vars(self):
            vars(self)["_hash"] = hash(self._key)
        return int(vars(self)["_hash"])

    def __getstate__(self) -> dict[str, Any]:
        """Return the values without the hash, which differs between processes."""
        return {name: value for name, value in vars(self).items() if name != "_hash"}

    @property
    def empty(self) -> bool:
        """Whether all deviations are zero, also those of single teeth."""
        return not self.deviation_um.any() and all(tooth.empty for tooth in self.teeth)

    def shape(self, flank: str) -> Shape:
        """Return the deviation (um) of a flank as a function of l and z, mm, with its derivatives."""
        return deviation_shape(self, flank)

    @property
    def files(self) -> tuple[str, ...]:
        """Files from which they were read; an empty one if there is none."""
        return tuple(tooth.file for tooth in self.teeth or (self,))

    @property
    def reference(self) -> dict[str, Any]:
        """The file, or those of single teeth, and its grid, as in a design file."""
        rows, columns = self.l.shape[1:]
        file = list(self.files) if self.teeth else self.file
        return {"file": file, "rows": rows, "columns": columns, "border": self.border}


def mean_deviations(teeth: Sequence[FlankDeviations]) -> FlankDeviations:
    """Return the mean of the tables of single teeth, as an input of `Modification`.

    Parameters
    ----------
    teeth : sequence of FlankDeviations
        Tables of one grid. Tooth k has table k; after the last table the first one is used again.

    Returns
    -------
    FlankDeviations
        The mean, with the tables as `teeth`. All functions use the mean, except `pitch_cycle`, which uses the
        tables.

    Raises
    ------
    DesignError
        If there is no table, or if their grids differ.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> import numpy as np
    >>> grid = bg.measuring_grid(bg.builtin_design("ni-2017").pinion, rows=2, columns=2)
    >>> l, z = grid.l, np.broadcast_to(grid.point[..., 2], grid.l.shape)
    >>> teeth = [bg.FlankDeviations(l, z, np.full_like(l, amount)) for amount in (1.0, 2.0)]
    >>> float(bg.mean_deviations(teeth).deviation_um.mean())
    1.5
    """
    shapes = {one.l.shape for one in teeth}
    if len(shapes) != 1:
        text = f"must be one or more tables of the same grid, got grids of the shapes {sorted(shapes)}"
        text += ": measure all teeth on the same grid"
        raise DesignError([Fault("", "teeth", text)], "FlankDeviations")
    l, z, amount = (np.mean([getattr(one, name) for one in teeth], axis=0) for name in _ARRAYS)
    first = teeth[0]
    return FlankDeviations(l, z, amount, border=first.border, nominal=first.nominal, teeth=tuple(teeth))


@dataclass(frozen=True, eq=False)
class DeviationShape:
    """Deviation (um) of one flank over l and z, mm.

    `profile` has the position and length of the grid along l: a (mm) at z = 0, da/dz, b (mm) at z = 0 and
    db/dz, with a and b as in the docstring of the module.
    """

    profile: tuple[float, float, float, float]
    spline: Any

    @property
    def rows(self) -> list[tuple[float, float]]:
        """Lines l = first + second z (mm) across which the third derivatives jump."""
        start, start_z, length, length_z = self.profile
        return [(start + t * length, start_z + t * length_z) for t in self.spline.breaks[0].tolist()]

    @property
    def columns(self) -> FloatArray:
        """Planes z (mm) across which the third derivatives jump."""
        return np.asarray(self.spline.breaks[1])

    def __call__(self, l: FloatArray, z: FloatArray) -> tuple[FloatArray, ...]:
        """Return the deviation and its derivatives as a `Shape` of `modification`."""
        l, z = np.broadcast_arrays(np.asarray(l, dtype=float), np.asarray(z, dtype=float))
        start, start_z, length, length_z = self.profile
        # Far outside the face, where tip and root of a steep cone meet, the length is kept.
        least = 0.2 * length
        size = length + length_z * z
        slope = np.where(size > least, length_z, 0.0)
        size = np.maximum(size, least)
        t = (l - start - start_z * z) / size
        t_z = -(start_z + t * slope) / size
        t_lz, t_zz = -slope / size**2, -2.0 * slope * t_z / size
        value, by_t, by_s, by_tt, by_ts, by_ss = self.spline.rows(t, z)
        return (
            value,
            by_t / size,
            by_t * t_z + by_s,
            by_tt / size**2,
            (by_tt * t_z + by_ts) / size + by_t * t_lz,
            (by_tt * t_z + 2.0 * by_ts) * t_z + by_ss + by_t * t_zz,
        )


@cached(32)
def deviation_shape(deviations: FlankDeviations, flank: str) -> DeviationShape:
    """Return the deviation of a flank as a function of l and z. Raises ValueError for another order."""
    side = tuple(FLANK_SIGN).index(flank)
    l, z = deviations.l[side], deviations.z[side]
    # a and b by least squares from the first and the last row.
    (start_z, start), (end_z, end) = (np.polyfit(z[row], l[row], 1) for row in (0, -1))
    length, length_z = end - start, end_z - start_z
    if not (length + length_z * z > 0.2 * length).all():
        raise ValueError("has a first and a last row that cross each other")
    t = (l - start - start_z * z) / (length + length_z * z)
    spline = spline_through(t, z, deviations.deviation_um[side])
    return DeviationShape((float(start), float(start_z), float(length), float(length_z)), spline)


@dataclass(frozen=True, eq=False)
class StackedDeviations:
    """Deviations of stacked members (`member.stacked`); None for a member without deviations."""

    members: tuple[FlankDeviations | None, ...]

    @property
    def empty(self) -> bool:
        """Whether all deviations are zero."""
        return all(one is None or one.empty for one in self.members)

    def shape(self, flank: str) -> Shape:
        """Return the deviation of a flank over l and z, with the members on the first axis."""

        def shape(l: FloatArray, z: FloatArray) -> tuple[FloatArray, ...]:
            """Return the deviation of each member and its derivatives."""
            l, z, _ = np.broadcast_arrays(l, z, np.empty((len(self.members), 1, 1)))
            rows = np.zeros((6, *l.shape))
            for k, one in enumerate(self.members):
                if one is not None:
                    rows[:, k] = one.shape(flank)(l[k], z[k])
            return tuple(rows)

        return shape
