"""Inputs of a contact analysis: tool, members, pair, assembly errors.

Lengths are in mm and angles in rad. Every physical quantity may be a number or an array. All arrays of a
design broadcast together to its *batch shape*, so that one call analyses many members, coefficients or
misalignments at once.

Values are checked against the limits of `field_limits` and become float64. Arrays are copied, and the copies
are read-only. Two inputs are equal if all their values are equal. Inputs of plain numbers are hashable,
inputs with arrays are not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from ..arrays import FloatArray, Quantity, T
from ..support.array_repr import call_repr, html_table
from ..support.frozen_arrays import equal
from .field_limits import DesignError, Input, base_pitch_fault, in_radians, require_classes
from .member import Member, stacked
from .written_numbers import refused

ErrorsAt: TypeAlias = Literal["perpendicular", "mesh"]
"""Where assembly errors are measured: about the common perpendicular of the axes, or at the mesh."""

PARALLEL_AXES_SINE = 1e-9
"""Sine of the shaft angle up to which the axes count as parallel."""
NORMAL_MATCH_TOLERANCE = 1e-9
"""Sum of the axial components of the normals of two flanks up to which they count as opposite. Flanks on
parallel axes with opposite components have a common normal."""


def from_degrees(kind: type[T], **values: Any) -> T:
    """Return a Tool, Member, Pair, Errors or MeshErrors from angles in degrees.

    Parameters
    ----------
    kind : type
        Class of the result.
    **values
        Arguments of the class. The name of an angle in degrees has the suffix `_deg`, as in a design file.

    Returns
    -------
    Tool, Member, Pair, Errors or MeshErrors
        Object of the class `kind`, in mm and rad.

    Raises
    ------
    DesignError
        If a value is outside its limits, if a name with the suffix `_deg` is not an angle, or if an angle is
        given twice.

    Examples
    --------
    >>> from beveloid_geom import Errors, from_degrees
    >>> round(from_degrees(Errors, shaft_angle_deg=0.01).shaft_angle, 9)
    0.000174533
    """
    return kind(**in_radians(kind.__name__, values))


@dataclass(frozen=True)
class Pair(Input):
    """Layout of the axes.

    Parameters
    ----------
    offset : float or array
        Shortest distance of the axes, mm.
    shaft_angle : float or array
        Magnitude of the shaft angle, rad. With a negative value the axes are inclined in the other sense. At
        offset 0 this is the same pair, rotated by half a turn. Otherwise no contact is found, unless the
        helix angles nearly cancel.
    pinion_mounting, gear_mounting : float, array or None
        Distance along the axis from the common perpendicular to mid-face, mm. If None, it is computed from
        the pitch point (`pair.mounting`).
    """

    offset: Quantity
    shaft_angle: Quantity
    pinion_mounting: Quantity | None = None
    gear_mounting: Quantity | None = None

    __eq__ = equal
    __repr__ = call_repr


@dataclass(frozen=True)
class Errors(Input):
    """Assembly errors about the common perpendicular of the axes (Fig. 5 of the paper).

    Parameters
    ----------
    offset : float or array
        Error of the offset, mm; it is added to the offset.
    shaft_angle : float or array
        Error of the shaft angle, rad; it is added to the magnitude of the shaft angle.
    pinion_axial, gear_axial : float or array
        Displacement of the member along its axis, mm; positive towards +z.
    """

    offset: Quantity = 0.0
    shaft_angle: Quantity = 0.0
    pinion_axial: Quantity = 0.0
    gear_axial: Quantity = 0.0

    __eq__ = equal
    __repr__ = call_repr


@dataclass(frozen=True)
class MeshErrors(Input):
    """Assembly errors at the mesh: the gear is turned about the pitch point.

    `pair.misalignment_at_mesh` converts them to `Errors`.

    Parameters
    ----------
    centre_distance : float or array
        Increase of the distance between the two points of the axes that are nearest to the pitch point, mm.
    in_plane : float or array
        Rotation in the plane parallel to both axes, rad; it is added to the magnitude of the shaft angle.
    out_of_plane : float or array
        Rotation that moves the +z end of the gear in the direction from pinion axis to gear axis (+x of the
        fixed frame), rad.
    pinion_axial, gear_axial : float or array
        Displacement of the member along its axis, mm; positive towards +z.
    """

    centre_distance: Quantity = 0.0
    in_plane: Quantity = 0.0
    out_of_plane: Quantity = 0.0
    pinion_axial: Quantity = 0.0
    gear_axial: Quantity = 0.0

    __eq__ = equal
    __repr__ = call_repr


@dataclass(frozen=True)
class Design(Input):
    """A pair of beveloid gears as mounted.

    Parameters
    ----------
    pinion, gear : Member
        Driving and driven member. Their base pitches must agree.
    pair : Pair
        Layout of the axes.
    errors : Errors
        Assembly errors about the common perpendicular.
    errors_at : {'perpendicular', 'mesh'}
        Errors that sensitivities, tolerances and maps of this design use by default: `Errors` or
        `MeshErrors`.
    """

    pinion: Member
    gear: Member
    pair: Pair
    errors: Errors = field(default_factory=Errors)
    errors_at: ErrorsAt = "perpendicular"

    __eq__ = equal
    __repr__ = call_repr
    _repr_html_ = html_table

    def __post_init__(self) -> None:
        """Check the classes of the fields and the base pitches. Raises DesignError."""
        # Python users may enter module and angles with few digits; files must have equal base pitches.
        base_pitch_tolerance = 1e-4
        require_classes(self, pinion=Member, gear=Member, pair=Pair, errors=Errors)
        if self.errors_at not in (places := get_args(ErrorsAt)):
            limit = f"be {' or '.join(map(repr, places))}"
            cure = "it selects where errors are measured"
            raise DesignError([f"errors_at {refused(limit, self.errors_at, cure)}"], "Design")
        pinion, gear = (m.tool.normal_module * np.cos(m.tool.normal_pressure_angle) for m in self.members)
        if fault := base_pitch_fault((pinion, gear), base_pitch_tolerance, "", "", "the pinion"):
            raise DesignError([f"gear {fault}"], "Design")

    @property
    def sense(self) -> FloatArray:
        """Sense of the shaft angle, 1 or -1 (batch shape).

        It is the sign of the sum of the helix angles, or of the pinion's helix angle if the sum is zero, and
        1 for straight teeth."""
        helix_sum_tolerance_rad = 1e-9
        first, second = np.asarray(self.pinion.helix_angle), self.gear.helix_angle
        total = first + second
        sign_of = np.where(np.abs(total) < helix_sum_tolerance_rad, first, total)
        return np.where(sign_of < 0.0, -1.0, 1.0)

    @property
    def members(self) -> tuple[Member, Member]:
        """Pinion and gear, in this order."""
        return self.pinion, self.gear

    @cached_property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape to which all array-valued inputs broadcast; `()` for a single design."""
        arrays = [value for value in self._quantities() if not isinstance(value, (int, float))]
        return np.broadcast_shapes(*(np.shape(value) for value in arrays)) if arrays else ()

    def _quantities(self) -> Iterator[Quantity]:
        for member in self.members:
            yield from member.quantities()
        for part in (self.pair, self.errors):
            yield from (value for value in vars(part).values() if value is not None)

    @property
    def has_parabola(self) -> bool:
        """Whether the parabola coefficient of any flank is not zero, in any case of a batch."""
        return any(member.tool.has_parabola for member in self.members)

    def stacked_members(self) -> Member:
        """Return pinion and gear as one batched member, see `stacked`."""
        return stacked(self.pinion, self.gear, self.batch_shape)

    def with_parabola(self, pinion: Quantity | None = None, gear: Quantity | None = None) -> Design:
        """Return the design with other parabola coefficients (1/mm) of both flanks of a member."""
        given = ("pinion", self.pinion, pinion), ("gear", self.gear, gear)
        members: dict[str, Any] = {
            name: replace(member, tool=member.tool.with_parabola(parabola))
            for name, member, parabola in given
            if parabola is not None
        }
        return replace(self, **members)

    def unmodified(self) -> Design:
        """Return the design without parabolas and without modifications."""
        return replace(self, pinion=self.pinion.unmodified(), gear=self.gear.unmodified())

    @property
    def measured(self) -> bool:
        """Whether flanks have measured deviations, apart from those of pitches."""
        return any(one.deviations is not None for member in self.members for one in member.modifications)

    def nominal(self) -> Design:
        """Return the design without measured deviations of flanks and pitches."""
        return replace(self, pinion=self.pinion.nominal(), gear=self.gear.nominal())

    def without_modifications(self) -> Design:
        """Return the design without modifications, with its parabolas."""
        if not any(m.modifications for m in self.members):
            return self
        return replace(self, pinion=self.pinion.modified(None), gear=self.gear.modified(None))

    def bare(self) -> Design:
        """Return the design without parabolas, modifications and errors."""
        return replace(self, pinion=self.pinion.unmodified(), gear=self.gear.unmodified(), errors=Errors())

    def with_errors(self, errors: Errors) -> Design:
        """Return the design with other assembly errors."""
        return replace(self, errors=errors)
