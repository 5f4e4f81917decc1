"""Tool and members of a pair.

Lengths are in mm and angles in rad. Every physical quantity may be a number or an array. Values are checked
against the limits of `field_limits`, see `model`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..arrays import FloatArray, Quantity, T, flank_sign
from ..support.array_repr import call_repr
from ..support.frozen_arrays import equal
from .deviations import FlankDeviations, StackedDeviations
from .field_limits import DesignError, Input, require_classes
from .modification import PITCH, Modification, limits_of
from .written_numbers import refused

MODIFICATIONS = {"right": "modification_right", "left": "modification_left"}
"""Fields of a `Member` by flank."""
BY_FLANK = {"parabola_right": "right", "parabola_left": "left"}
"""Flank by quantity of a tool that is given for one flank."""


def unchecked(given: T, **values: Any) -> T:
    """Return a copy of a tool, member, pair or errors with some values replaced and without a check.

    The values, float64, were computed from checked inputs and may exceed the limits for user input."""
    made = object.__new__(type(given))
    vars(made).update(vars(given), **values)
    return made


@dataclass(frozen=True)
class Tool(Input):
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
        If a value is outside its limits; one line for each value. This holds for all inputs of a design.
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
    __repr__ = call_repr

    def parabola_of(self, flank: str) -> Quantity:
        """Return the parabola coefficient of a flank ('right' or 'left'), 1/mm."""
        given = self.parabola_right if flank_sign(flank) > 0.0 else self.parabola_left
        return self.parabola if given is None else given

    @property
    def parabolas(self) -> dict[str, Quantity]:
        """The parabola coefficients that are used, 1/mm, by the name of their field."""
        by_flank = {name: value for name in BY_FLANK if (value := getattr(self, name)) is not None}
        return by_flank if len(by_flank) == len(BY_FLANK) else {"parabola": self.parabola} | by_flank

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
class Member(Input):
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
    __repr__ = call_repr

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        require_classes(self, tool=Tool)
        given = [name for name in MODIFICATIONS.values() if getattr(self, name) is not None]
        require_classes(self, **dict.fromkeys(given, Modification))
        super().__post_init__()
        faults = [
            f"{name}.{PITCH} {text}"
            for name in given
            if (text := self.pitch_fault(getattr(self, name).pitch_deviations_um))
        ]
        if faults:
            raise DesignError(faults, "Member")

    def pitch_fault(self, deviations: Sequence[float] | None) -> str | None:
        """Return the message if pitch deviations (um) are too large, or if there is not one for each tooth;
        otherwise None."""
        if deviations is None:
            return None
        if np.ndim(self.teeth) or len(deviations) != self.teeth:
            count = f"must have one value for each of the {self.teeth} teeth, got {len(deviations)}"
            return f"{count}: give 0 for teeth without a deviation"
        # With a larger deviation, a tooth could touch other teeth of the mate than without a deviation.
        largest, limit = max(map(abs, deviations)), 200.0 * float(np.min(self.tool.normal_module))
        return (
            refused(f"be at most {limit:g} um (a fifth of the module) in magnitude", largest, "give it in um")
            if largest > limit
            else None
        )

    def pitch_deviations(self, flank: str) -> tuple[float, ...] | None:
        """Return the pitch deviations (um) of a flank of all teeth; None if they are not given."""
        flank_sign(flank)  # reject unknown names
        given: Modification | None = getattr(self, MODIFICATIONS[flank])
        return None if given is None else given.pitch_deviations_um

    def tooth_deviations(self, flank: str) -> tuple[FlankDeviations, ...]:
        """Return the measured deviations of a flank by tooth; empty if one table holds for all teeth."""
        flank_sign(flank)  # reject unknown names
        given: Modification | None = getattr(self, MODIFICATIONS[flank])
        return () if given is None or given.deviations is None else given.deviations.teeth

    def differs_by_tooth(self, flank: str) -> bool:
        """Return whether the teeth of the member differ: by pitch deviations or tables of single teeth."""
        return self.pitch_deviations(flank) is not None or bool(self.tooth_deviations(flank))

    def modified(self, modification: Modification | None, flank: str | None = None) -> Member:
        """Return the member with another modification of one `flank`, or of both if it is omitted."""
        if flank is not None:
            flank_sign(flank)  # reject unknown names
        names = MODIFICATIONS.values() if flank is None else (MODIFICATIONS[flank],)
        return replace(self, **dict.fromkeys(names, modification))

    def unmodified(self) -> Member:
        """Return the member without parabolas and without modifications."""
        tool = unchecked(self.tool, parabola=0.0, **dict.fromkeys(BY_FLANK))
        return unchecked(self, tool=tool, **dict.fromkeys(MODIFICATIONS.values()))

    def nominal(self) -> Member:
        """Return the member without measured deviations of its flanks and pitches."""
        result = self
        for flank, name in MODIFICATIONS.items():
            if (given := getattr(self, name)) is not None:
                amounts = replace(given, deviations=None, pitch_deviations_um=None)
                result = result.modified(amounts if amounts.given() else None, flank)
        return result

    @property
    def modifications(self) -> tuple[Modification, ...]:
        """The modifications that are given, of the right and of the left flank."""
        given = (getattr(self, name) for name in MODIFICATIONS.values())
        return tuple(one for one in given if one is not None)

    def modification(self, flank: str) -> Modification | None:
        """Return the modification of a flank; None without one, or if amounts and deviations are zero."""
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
        coefficients = (part.tool.parabola_of(flank) for part in (pinion, gear))
        values[name] = both(*coefficients) if given else values["parabola"]
    tool = unchecked(pinion.tool, **values)
    modified = {name: modifications(flank) for flank, name in MODIFICATIONS.items()}
    names = [name for name in members[0] if name != "tool" and name not in modified]
    quantities = {name: both(members[0][name], members[1][name]) for name in names}
    return unchecked(pinion, tool=tool, **quantities, **modified)
