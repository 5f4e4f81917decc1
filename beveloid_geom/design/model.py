"""Inputs of a contact analysis: tool, members, pair, assembly errors.

Lengths are in mm and angles in rad. Every physical quantity may be a number or an array. All arrays of a
design broadcast together to its *batch shape*, so that one call analyses many members, coefficients or
misalignments at once.

Values are checked against the limits of `field_limits` and become float64. Arrays are copied, and the copies
are read-only. Two inputs are equal if all their values are equal. Inputs of plain numbers are hashable,
inputs with arrays are not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias, TypeVar, get_args

import numpy as np

from ..arrays import FloatArray, Quantity, flank_sign
from ..support.array_repr import html_table
from ..support.frozen_arrays import equal, restored
from .deviations import StackedDeviations
from .field_limits import DesignError, base_pitch_fault, in_radians, refused, take
from .modification import PITCH, Modification, limits_of

T = TypeVar("T")
MODIFICATIONS = {"right": "modification_right", "left": "modification_left"}
"""Fields of a `Member` by flank."""
ErrorsAt: TypeAlias = Literal["perpendicular", "mesh"]
"""Where assembly errors are measured: about the common perpendicular of the axes, or at the mesh."""

PARALLEL = 1e-9
"""Sine of the shaft angle up to which the axes count as parallel."""
MATCH = 1e-9
"""Sum of the axial components of the normals of two flanks up to which they count as opposite. Flanks on
parallel axes with opposite components have a common normal."""


BY_FLANK = {"parabola_right": "right", "parabola_left": "left"}
"""Flank by quantity of a tool that is given for one flank."""


def unchecked(given: T, **values: Any) -> T:
    """Return a copy of a tool, member, pair or errors with some values replaced and without a check.

    The values, float64, were computed from checked inputs and may exceed the limits for user input."""
    made = object.__new__(type(given))
    vars(made).update(vars(given), **values)
    return made


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


def _require(owner: object, **kinds: type) -> None:
    """Raise DesignError if a field of `owner` is not an object of the class given for it."""
    faults = [
        f"{name} {refused(f'be of the class {kind.__name__}', value, f'make it by {kind.__name__}(...)')}"
        for name, kind in kinds.items()
        if not isinstance(value := getattr(owner, name), kind)
    ]
    if faults:
        raise DesignError(faults, type(owner).__name__)


@dataclass(frozen=True)
class Tool:
    """Normal section of the generating rack (Fig. 2 of the paper).

    Parameters
    ----------
    normal_module : float or array
        Normal module, mm.
    normal_pressure_angle : float or array
        Normal pressure angle, rad.
    addendum : float or array
        Addendum of the generated tooth in normal modules. It sets the height of the tip only. The active
        flank reaches down to the fillet, which follows from `dedendum` and `tip_radius`.
    dedendum : float or array
        Dedendum of the generated tooth in normal modules.
    tip_radius : float or array
        Radius of the tip round of the tool in normal modules.
    parabola : float or array
        Parabola coefficient a of Eq. 1, 1/mm, of both flanks. Positive values make the tooth concave,
        negative values convex.
    parabola_right, parabola_left : float, array or None
        Parabola coefficient of one flank, 1/mm. If None, it is `parabola`.
    parabola_apex : float or array
        Position of the apex of the parabolas along the straight flank, mm from the reference line; positive
        towards the tip of the generated tooth.

    Raises
    ------
    DesignError
        If a value is outside its limits; one line for each value. This holds for all inputs of this module.
    """

    normal_module: Quantity
    normal_pressure_angle: Quantity
    addendum: Quantity = 1.0
    dedendum: Quantity = 1.25
    tip_radius: Quantity = 0.38
    parabola: Quantity = 0.0
    parabola_right: Quantity | None = None
    parabola_left: Quantity | None = None
    parabola_apex: Quantity = 0.0

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        take("Tool", vars(self))

    def parabola_of(self, flank: str) -> Quantity:
        """Return the parabola coefficient of a flank ('right' or 'left'), 1/mm."""
        given = self.parabola_right if flank_sign(flank) > 0.0 else self.parabola_left
        return self.parabola if given is None else given

    @property
    def parabolas(self) -> dict[str, Quantity]:
        """The parabola coefficients that are used, 1/mm, by the name of their field."""
        own = {name: value for name in BY_FLANK if (value := getattr(self, name)) is not None}
        return own if len(own) == len(BY_FLANK) else {"parabola": self.parabola} | own

    @property
    def has_parabola(self) -> bool:
        """Whether the parabola coefficient of any flank is not zero, in any case of a batch."""
        return any(np.any(value) for value in self.parabolas.values())

    def with_parabola(self, parabola: Quantity) -> Tool:
        """Return the tool with another parabola coefficient (1/mm) of both flanks."""
        return replace(self, parabola=parabola, parabola_right=None, parabola_left=None)

    def straight(self) -> Tool:
        """Return the tool without parabolas."""
        return replace(self.with_parabola(0.0), parabola_apex=0.0)


@dataclass(frozen=True)
class Member:
    """One gear: the tool and the generating motion.

    Parameters
    ----------
    tool : Tool
        Generating rack.
    teeth : int or array
        Number of teeth.
    helix_angle : float or array
        Reference helix angle, rad; right hand positive.
    cone_angle : float or array
        Half angle of the pitch cone, rad. If it is positive, the tooth grows towards +z.
    profile_shift : float or array
        Profile shift coefficient at mid-face (z = 0), in normal modules.
    face_width : float or array
        Face width, mm.
    tip_alteration : float or array
        Tip alteration coefficient k of ISO 21771, in normal modules. The tip cone lies k m_n above the tip of
        the basic rack. Negative values shorten the tooth. The root does not change.
    modification_right, modification_left : Modification or None
        Modification of the right and of the left flank.
    """

    tool: Tool
    teeth: Quantity
    helix_angle: Quantity
    cone_angle: Quantity
    profile_shift: Quantity
    face_width: Quantity
    tip_alteration: Quantity = 0.0
    modification_right: Modification | None = None
    modification_left: Modification | None = None

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        _require(self, tool=Tool)
        given = [name for name in MODIFICATIONS.values() if getattr(self, name) is not None]
        _require(self, **dict.fromkeys(given, Modification))
        take("Member", vars(self))
        faults = [
            f"{name}.{PITCH} {text}"
            for name in given
            if (text := self.pitch_fault(getattr(self, name).pitch_deviations_um))
        ]
        if faults:
            raise DesignError(faults, "Member")

    def pitch_fault(self, deviations: Sequence[float] | None) -> str | None:
        """Return the message for pitch deviations (um) that are too large or not one for each tooth.

        None for others."""
        if deviations is None:
            return None
        if np.ndim(self.teeth) or len(deviations) != self.teeth:
            return f"must have one value for each tooth, {self.teeth}, got {len(deviations)}"
        # The mates of a tooth with a larger deviation are not those that can touch without it.
        largest, limit = max(map(abs, deviations)), 200.0 * float(np.min(self.tool.normal_module))
        return (
            refused(f"be within {limit:g} um, a fifth of the module", largest, "give it in um")
            if largest > limit
            else None
        )

    def pitch_deviations(self, flank: str) -> tuple[float, ...] | None:
        """Return the pitch deviations (um) of a flank of all teeth; None if they are not given."""
        flank_sign(flank)  # reject unknown names
        given: Modification | None = getattr(self, MODIFICATIONS[flank])
        return None if given is None else given.pitch_deviations_um

    def modified(self, modification: Modification | None, flank: str | None = None) -> Member:
        """Return the member with another modification of one `flank`, or of both if it is omitted."""
        if flank is not None:
            flank_sign(flank)  # reject unknown names
        names = MODIFICATIONS.values() if flank is None else (MODIFICATIONS[flank],)
        return replace(self, **dict.fromkeys(names, modification))

    @property
    def modifications(self) -> tuple[Modification, ...]:
        """The modifications that are given, of the right and of the left flank."""
        given = (getattr(self, name) for name in MODIFICATIONS.values())
        return tuple(one for one in given if one is not None)

    def modification(self, flank: str) -> Modification | None:
        """Return the modification of a flank, None if all its amounts are zero."""
        flank_sign(flank)  # reject unknown names
        given: Modification | None = getattr(self, MODIFICATIONS[flank])
        return None if given is None or given.empty else given

    def quantities(self) -> Iterator[Quantity]:
        """Yield the quantities of the member, its tool and its modifications."""
        for value in vars(self).values():
            if isinstance(value, Tool):
                yield from (part for part in vars(value).values() if part is not None)
            elif isinstance(value, Modification):
                yield from value.quantities()
            elif value is not None:
                yield value

    @property
    def tip_height(self) -> Quantity:
        """Height of the tip cone above the shifted pitch cone in normal modules, measured radially."""
        return self.tool.addendum + self.tip_alteration

    def with_tip_diameter(self, diameter: Quantity) -> Member:
        """Return the member with another tip diameter.

        Parameters
        ----------
        diameter : float or array
            Tip diameter at mid-face, mm.

        Returns
        -------
        Member
            With the tip alteration k = (d_a - d) / (2 m_n) - x - h_a (ISO 21771).

        Raises
        ------
        DesignError
            If the tip alteration is outside its limits.
        """
        module, reference = self.tool.normal_module, self.teeth / np.cos(self.helix_angle)
        height = 0.5 * (np.asarray(diameter, dtype=float) / module - reference)
        return replace(self, tip_alteration=(height - self.profile_shift - self.tool.addendum)[()])


@dataclass(frozen=True)
class Pair:
    """Layout of the axes.

    Parameters
    ----------
    offset : float or array
        Shortest distance of the axes, mm.
    shaft_angle : float or array
        Magnitude of the shaft angle, rad. With a negative value the axes are inclined in the other sense, and
        no contact is found.
    pinion_mounting, gear_mounting : float, array or None
        Distance along the axis from the common perpendicular to mid-face, mm. If None, it is computed from
        the pitch point (`pair.mounting`).
    """

    offset: Quantity
    shaft_angle: Quantity
    pinion_mounting: Quantity | None = None
    gear_mounting: Quantity | None = None

    __eq__ = equal
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        take("Pair", vars(self))


@dataclass(frozen=True)
class Errors:
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
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        take("Errors", vars(self))


@dataclass(frozen=True)
class MeshErrors:
    """Assembly errors at the mesh: the gear is turned about the pitch point.

    `pair.misalignment_at_mesh` converts them to `Errors`.

    Parameters
    ----------
    centre_distance : float or array
        Increase of the distance of the two axis points that are nearest to the pitch point, mm.
    in_plane : float or array
        Rotation that is added to the magnitude of the shaft angle, rad.
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
    __setstate__ = restored

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        take("MeshErrors", vars(self))


@dataclass(frozen=True)
class Design:
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
    __setstate__ = restored
    _repr_html_ = html_table

    def __post_init__(self) -> None:
        """Check the classes of the fields and the base pitches. Raises DesignError."""
        # Python users may note a design with few digits; files must have equal base pitches.
        base_pitch_tolerance = 1e-4
        _require(self, pinion=Member, gear=Member, pair=Pair, errors=Errors)
        if self.errors_at not in (places := get_args(ErrorsAt)):
            limit = f"be {' or '.join(map(repr, places))}"
            cure = "it says where errors are measured"
            raise DesignError([f"errors_at {refused(limit, self.errors_at, cure)}"], "Design")
        pinion, gear = (m.tool.normal_module * np.cos(m.tool.normal_pressure_angle) for m in self.members)
        if fault := base_pitch_fault((pinion, gear), base_pitch_tolerance, "", "", "the pinion"):
            raise DesignError([f"gear {fault}"], "Design")

    @property
    def sense(self) -> FloatArray:
        """Sense of the shaft angle, 1 or -1 (batch shape).

        It is the sign of the sum of the helix angles, of the pinion's helix angle if they cancel, and 1 for
        straight teeth."""
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
        return self.with_parabola(0.0, 0.0).without_modifications()

    def without_modifications(self) -> Design:
        """Return the design without modifications, with its parabolas."""
        if not any(m.modifications for m in self.members):
            return self
        return replace(self, pinion=self.pinion.modified(None), gear=self.gear.modified(None))

    def with_errors(self, errors: Errors) -> Design:
        """Return the design with other assembly errors."""
        return replace(self, errors=errors)


def stacked(pinion: Member, gear: Member, shape: tuple[int, ...] = ()) -> Member:
    """Return two members as one batched member.

    Parameters
    ----------
    pinion, gear : Member
    shape : tuple of int
        Batch shape of the design.

    Returns
    -------
    Member
        Every quantity has the shape (2, cases, 1): pinion and gear, the batch axes in one, and an axis that
        broadcasts with flank parameters (2, cases, positions).
    """

    def both(first: Quantity, second: Quantity) -> FloatArray:
        """Return one quantity of both members in one array."""
        if not shape:
            return np.array([[[first]], [[second]]], dtype=float)
        joined = np.empty((2, *shape))
        joined[0], joined[1] = first, second
        return joined.reshape(2, -1, 1)

    def modifications(flank: str) -> Modification | None:
        """Return the modifications of a flank in arrays, None if neither member has one."""
        parts = [member.modification(flank) for member in (pinion, gear)]
        if parts == [None, None]:
            return None
        kind = max((type(part) for part in parts if part is not None), key=lambda kind: len(fields(kind)))
        none = kind()
        values = {name: [getattr(part or none, name, None) for part in parts] for name in limits_of(kind)}
        # A relief with the amount 0 has any length.
        arrays = {name: both(*(1.0 if x is None else x for x in value)) for name, value in values.items()}
        # Deviations of each member remain separate.
        deviations = tuple(None if part is None else part.deviations for part in parts)
        return unchecked(
            none, **arrays, deviations=StackedDeviations(deviations) if any(deviations) else None
        )

    tools, members = (vars(pinion.tool), vars(gear.tool)), (vars(pinion), vars(gear))
    values = {name: both(tools[0][name], tools[1][name]) for name in tools[0] if name not in BY_FLANK}
    for name, flank in BY_FLANK.items():
        # A coefficient that is not given is that of both flanks.
        given = tools[0][name] is not None or tools[1][name] is not None
        own = (part.tool.parabola_of(flank) for part in (pinion, gear))
        values[name] = both(*own) if given else values["parabola"]
    tool = unchecked(pinion.tool, **values)
    modified = {name: modifications(flank) for flank, name in MODIFICATIONS.items()}
    names = [name for name in members[0] if name != "tool" and name not in modified]
    quantities = {name: both(members[0][name], members[1][name]) for name in names}
    return unchecked(pinion, tool=tool, **quantities, **modified)
