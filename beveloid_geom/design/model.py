"""Inputs of a contact analysis: tool, members, pair, assembly errors.

Lengths are in mm and angles in rad. Every physical quantity may be a number or an
array; arrays broadcast together to the *batch shape* of the design, so that one call
analyses many members, coefficients or misalignments at once. Values are checked as they
enter, by the table of `field_limits`, and become float64: plain numbers, lists, arrays of
any real type are taken, and a copy is kept that cannot be written to. Inputs are equal if all their
values are; those of plain numbers can be keys of a dictionary, those that hold arrays cannot.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias, TypeVar, get_args

import numpy as np

from ..arrays import FloatArray, Quantity
from ..support.few_lines import html_table
from ..support.read_only import equal, restored
from .field_limits import DesignError, base_pitch_fault, in_radians, refused, take

T = TypeVar("T")
ErrorsAt: TypeAlias = Literal["perpendicular", "mesh"]
"""Where assembly errors are measured: about the common perpendicular of the axes, or at the mesh."""

ROUNDED_PITCH = 1e-4
"""Share by which base pitches may differ from Python, where designs are noted with a few digits."""


CANCELLING = 1e-9
"""Sum of helix angles (rad) below which it gives the shaft angle no sense."""
PARALLEL = 1e-9
"""Sine of the shaft angle up to which the axes count as parallel."""
MATCH = 1e-9
"""Sum of axial components of the normals of two flanks up to which it counts as zero on parallel axes."""


def unchecked(given: T, **values: Any) -> T:
    """Give the tool, member, pair or errors `given` with other values, float64 each, that are not checked:
    they were made of checked ones, and may pass the limits of those that users give."""
    made = object.__new__(type(given))
    vars(made).update(vars(given), **values)
    return made


def from_degrees(kind: type[T], **values: Any) -> T:
    """Make a Tool, Member, Pair or Errors of angles in degrees.

    Parameters
    ----------
    kind : type
        The class, as in `from_degrees(Errors, shaft_angle_deg=0.01)`.
    **values
        Its inputs; an angle has the suffix `_deg` where it is in degrees, as in a design file.

    Returns
    -------
    An object of the class, in mm and rad.

    Raises
    ------
    DesignError
        As the class does, and for degrees of what is no angle.
    """
    return kind(**in_radians(kind.__name__, values))


def _require(owner: object, **kinds: type) -> None:
    """Raise DesignError unless the fields are inputs of these classes."""
    faults = [
        f"{name} {refused(f'be of the class {kind.__name__}', value, f'make it by {kind.__name__}(...)')}"
        for name, kind in kinds.items()
        if not isinstance(value := getattr(owner, name), kind)
    ]
    if faults:
        raise DesignError(faults, type(owner).__name__)


@dataclass(frozen=True)
class Tool:
    """Normal section of the generating rack (Fig. 2).

    `addendum`, `dedendum` and `tip_radius` are those of the generated tooth in units of
    the normal module, as in a basic rack; `parabola` is the coefficient a_j of Eq. 1 in
    1/mm: positive makes the tooth concave, negative convex.
    """

    normal_module: Quantity
    normal_pressure_angle: Quantity
    addendum: Quantity = 1.0
    dedendum: Quantity = 1.25
    tip_radius: Quantity = 0.38
    parabola: Quantity = 0.0

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Raises DesignError as `field_limits.take`, like the other inputs."""
        take("Tool", vars(self))


@dataclass(frozen=True)
class Member:
    """One gear: the tool that cuts it, and how it is cut.

    The helix angle is signed, right hand positive. The cone angle is the half angle of
    the pitch cone: positive means that the tooth grows towards +z, the heel. The profile
    shift coefficient holds at mid-face, `z = 0`.
    """

    tool: Tool
    teeth: Quantity
    helix_angle: Quantity
    cone_angle: Quantity
    profile_shift: Quantity
    face_width: Quantity

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Raises DesignError as `Tool` does."""
        _require(self, tool=Tool)
        take("Member", vars(self))


@dataclass(frozen=True)
class Pair:
    """Layout: offset (shortest distance of the axes), magnitude of the shaft angle (negative: the
    axes lean the other way, and no contact is found), and optionally the distances along each axis
    from the common perpendicular to mid-face.
    A mounting distance left out is computed from the pitch point (see `mounting`)."""

    offset: Quantity
    shaft_angle: Quantity
    pinion_mounting: Quantity | None = None
    gear_mounting: Quantity | None = None

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Raises DesignError as `Tool` does."""
        take("Pair", vars(self))


@dataclass(frozen=True)
class Errors:
    """Assembly errors of Fig. 5. The offset error adds to the offset, the shaft-angle
    error to the magnitude of the shaft angle; axial errors move a member along its own
    axis, positive towards its heel."""

    offset: Quantity = 0.0
    shaft_angle: Quantity = 0.0
    pinion_axial: Quantity = 0.0
    gear_axial: Quantity = 0.0

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Raises DesignError as `Tool` does."""
        take("Errors", vars(self))


@dataclass(frozen=True)
class MeshErrors:
    """Assembly errors as they are measured at the mesh, for which `pair.mesh_errors` has those about
    the common perpendicular. The gear is turned about the pitch point: `in_plane` is added to the magnitude
    of the shaft angle, `out_of_plane` leans the gear's heel the way from pinion to gear axis, +x of S_f.
    `centre_distance` parts the points of both axes that are nearest to the pitch point; axial errors move a
    member along its own axis, positive towards its heel. mm and rad."""

    centre_distance: Quantity = 0.0
    in_plane: Quantity = 0.0
    out_of_plane: Quantity = 0.0
    pinion_axial: Quantity = 0.0
    gear_axial: Quantity = 0.0

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Raises DesignError as `Tool` does."""
        take("MeshErrors", vars(self))


@dataclass(frozen=True)
class Design:
    """A pair of beveloid gears, as mounted. `errors` are about the common perpendicular; `errors_at` says
    where those are measured that studies of it draw, map and differentiate by where they are not told."""

    pinion: Member
    gear: Member
    pair: Pair
    errors: Errors = field(default_factory=Errors)
    errors_at: ErrorsAt = "perpendicular"

    __eq__ = equal
    __setstate__ = restored
    _repr_html_ = html_table

    def __post_init__(self) -> None:
        """Raises DesignError for what is no input, and for members of different base pitch."""
        _require(self, pinion=Member, gear=Member, pair=Pair, errors=Errors)
        if self.errors_at not in (places := get_args(ErrorsAt)):
            limit = f"be {' or '.join(map(repr, places))}"
            cure = "it says where errors are measured"
            raise DesignError([f"errors_at {refused(limit, self.errors_at, cure)}"], "Design")
        pinion, gear = (m.tool.normal_module * np.cos(m.tool.normal_pressure_angle) for m in self.members)
        if fault := base_pitch_fault((pinion, gear), ROUNDED_PITCH, "", "", "the pinion"):
            raise DesignError([f"gear {fault}"], "Design")

    @property
    def sense(self) -> FloatArray:
        """Sense of the shaft angle, 1 or -1 (batch shape): that of the sum of the helix angles; where they
        cancel that of the pinion's; of straight teeth 1."""
        first, second = np.asarray(self.pinion.helix_angle), self.gear.helix_angle
        total = first + second
        return np.where(np.where(np.abs(total) < CANCELLING, first, total) < 0.0, -1.0, 1.0)

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
        for part in (self.pinion.tool, self.gear.tool, self.pinion, self.gear, self.pair, self.errors):
            for value in vars(part).values():
                if value is not None and not isinstance(value, Tool):
                    yield value

    def stacked_members(self) -> Member:
        """Stack pinion and gear as one batched member, as in `stacked`."""
        return stacked(self.pinion, self.gear, self.batch_shape)

    def with_parabola(self, pinion: Quantity | None = None, gear: Quantity | None = None) -> Design:
        """Give the same design with other parabola coefficients (1/mm)."""
        given = ("pinion", self.pinion, pinion), ("gear", self.gear, gear)
        members: dict[str, Any] = {
            name: replace(member, tool=replace(member.tool, parabola=parabola))
            for name, member, parabola in given
            if parabola is not None
        }
        return replace(self, **members)

    def with_errors(self, errors: Errors) -> Design:
        """Give the same design under other assembly errors."""
        return replace(self, errors=errors)


def stacked(pinion: Member, gear: Member, shape: tuple[int, ...] = ()) -> Member:
    """Stack two members as one batched member: every quantity has shape (2, cases, 1), the batch axes `shape`
    in one, ready to broadcast with flank parameters (2, cases, positions)."""

    def both(first: Quantity, second: Quantity) -> FloatArray:
        """Stack one quantity of both."""
        if not shape:
            return np.array([[[first]], [[second]]], dtype=float)
        joined = np.empty((2, *shape))
        joined[0], joined[1] = first, second
        return joined.reshape(2, -1, 1)

    tools, members = (vars(pinion.tool), vars(gear.tool)), (vars(pinion), vars(gear))
    tool = unchecked(pinion.tool, **{name: both(tools[0][name], tools[1][name]) for name in tools[0]})
    rest = {name: both(members[0][name], members[1][name]) for name in members[0] if name != "tool"}
    return unchecked(pinion, tool=tool, **rest)
