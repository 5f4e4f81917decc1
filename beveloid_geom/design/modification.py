"""Flank modifications of ISO 21771: amounts, lengths and shapes.

A modification removes material from a generated flank. Its depth `delta` is measured in the transverse plane
along the base tangent, positive for material that is removed. It depends on two normalised coordinates,

    lam   linear in the flank parameter l: -1 where the active flank begins, +1 at the tip, both at mid-face
    zeta  2 z / b: -1 at the end of the face at -z, +1 at the end at +z

For a relief one of them is replaced by t, which is 0 where the relief begins and 1 at the edge. Reliefs
begin with a horizontal tangent, and their depth is 0 for negative t. All kinds continue beyond the edges of
the flank.

Each amount of a `Modification` is one kind of modification. The metadata of its field contain the function
that returns the shape for the amount 1, with its derivatives. `gear.modification` turns the depth into a
rotation of the flank points about the axis of the gear.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import Field, dataclass, field, fields
from typing import Any, Literal, NamedTuple

import numpy as np

from ..arrays import Quantity
from ..support.array_repr import call_repr
from ..support.frozen_arrays import equal
from .deviations import FlankDeviations, Shape
from .field_limits import DesignError, Fault, FieldLimit, Input, checked, take
from .written_numbers import refused

AMOUNT_SUFFIX, LENGTH_SUFFIX = "_um", "_length_mm"
PITCH = "pitch_deviations_um"
AMOUNT = FieldLimit(-1e5, 1e5, "um", "give it in um")


@dataclass(frozen=True)
class QuadraticShape:
    """Shape that is a quadratic function of its coordinates x (profile) and y (face).

    Attributes
    ----------
    x, y, xx, xy, yy : float
        Coefficients of these products.
    """

    x: float = 0.0
    y: float = 0.0
    xx: float = 0.0
    xy: float = 0.0
    yy: float = 0.0

    @property
    def axes(self) -> tuple[bool, bool]:
        """Whether the shape depends on x, and on y."""
        return any((self.x, self.xx, self.xy)), any((self.y, self.xy, self.yy))

    def __call__(self, x: Any, y: Any) -> tuple[Any, ...]:
        """Return the value and its derivatives by x, y, x x, x y and y y."""
        by_x, by_y = self.x + self.xx * x + self.xy * y, self.y + self.xy * x + self.yy * y
        return (
            x * by_x + y * (self.y + self.yy * y),
            by_x + self.xx * x,
            by_y + self.yy * y,
            2.0 * self.xx,
            self.xy,
            2.0 * self.yy,
        )


class Kind(NamedTuple):
    """A kind of modification: its `shape`, and the coordinates on which the shape depends.

    The shape returns the depth for the amount 1. `profile`: 'active' for lam, 'tip' or 'root' for the t of a
    relief at this edge. `face`: 'active' for zeta, 'heel' (at +z) or 'toe' (at -z) for the t of a relief."""

    shape: Shape
    profile: Literal["active", "tip", "root"] = "active"
    face: Literal["active", "heel", "toe"] = "active"

    @property
    def has_length(self) -> bool:
        """Whether the kind is a relief with a length."""
        return (self.profile, self.face) != ("active", "active")


def kind(*values: Any, **names: Any) -> dict[str, Kind]:
    """Return the metadata of the field of a `Modification`; the arguments are those of `Kind`."""
    return {"kind": Kind(*values, **names)}


@dataclass(frozen=True)
class Modification(Input):
    """Modification of one flank of a member, with the names and symbols of ISO 21771.

    Parameters
    ----------
    helix_slope_um : float or array
        C_Hbeta, um: the depth is C zeta / 2.
    helix_crowning_um : float or array
        C_beta, um: the depth is C zeta^2.
    profile_slope_um : float or array
        C_Halpha, um: the depth is C lam / 2.
    profile_crowning_um : float or array
        C_alpha, um: the depth is C lam^2.
    twist_um : float or array
        S_alpha, um: the depth is S lam zeta / 4, so that the profile slopes at the ends of the face differ by
        S.
    tip_relief_um, tip_relief_length_mm : float or array
        C_alphaa, um, and its length along l, mm: the depth is C t^2, with t from 0 at this length below the
        tip to 1 at the tip, at mid-face.
    root_relief_um, root_relief_length_mm : float or array
        C_alphaf, um, and its length from the start of the active flank upwards.
    heel_relief_um, heel_relief_length_mm : float or array
        C_betaI, um, and its length along the face from the end at +z.
    toe_relief_um, toe_relief_length_mm : float or array
        C_betaII, um, and its length along the face from the end at -z.
    deviations : FlankDeviations, optional
        Measured deviations of both flanks; the deviations of the modified flank are added to its other
        modifications.
    pitch_deviations_um : tuple of float, optional
        Deviation of the flank of each tooth from its nominal position, along the normal, um; positive for
        excess material. Tooth 0 is first, and the others follow in the direction of positive rotation. Only
        `pitch_cycle` uses these deviations; all other functions ignore them. Commands other than `operation`
        print a message about it.

    Raises
    ------
    DesignError
        If a value is outside its limits, or if an amount needs a length that is missing.

    Notes
    -----
    Positive amounts remove material. The depth is measured in the transverse plane along the base tangent.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from beveloid_geom import Modification, builtin_design
    >>> design = builtin_design()
    >>> crowned = replace(design, pinion=design.pinion.modified(Modification(helix_crowning_um=10.0)))
    >>> crowned.pinion.modification_right.helix_crowning_um
    10.0
    """

    helix_slope_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(y=0.5)))
    helix_crowning_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(yy=1.0)))
    profile_slope_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(x=0.5)))
    profile_crowning_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(xx=1.0)))
    twist_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(xy=0.25)))
    tip_relief_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(xx=1.0), profile="tip"))
    tip_relief_length_mm: Quantity | None = None
    root_relief_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(xx=1.0), profile="root"))
    root_relief_length_mm: Quantity | None = None
    heel_relief_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(yy=1.0), face="heel"))
    heel_relief_length_mm: Quantity | None = None
    toe_relief_um: Quantity = field(default=0.0, metadata=kind(QuadraticShape(yy=1.0), face="toe"))
    toe_relief_length_mm: Quantity | None = None
    deviations: FlankDeviations | None = None
    pitch_deviations_um: tuple[float, ...] | None = None

    __eq__ = equal
    __repr__ = call_repr

    def __post_init__(self) -> None:
        """Check the values. Raises DesignError."""
        values = vars(self)
        faults = take(limits_of(type(self)), values)
        if not isinstance(self.deviations, FlankDeviations | None):
            cure = "pass the attribute on_flanks of the result of read_deviations"
            text = refused("be of the class FlankDeviations", self.deviations, cure)
            faults.append(Fault("", "deviations", text))
        if self.pitch_deviations_um is not None:
            result = checked(self.pitch_deviations_um, AMOUNT)
            if isinstance(result, str):
                faults.append(Fault("", PITCH, result))
            else:
                values[PITCH] = tuple(np.atleast_1d(result).ravel().tolist())
        if faults:
            raise DesignError(faults, "Modification")
        if faults := [*missing_lengths(type(self), self.given())]:
            raise DesignError(faults, "Modification")

    def quantities(self) -> Iterator[Quantity]:
        """Yield the amounts and lengths that are given."""
        yield from (value for name in limits_of(type(self)) if (value := getattr(self, name)) is not None)

    def given(self) -> dict[str, Any]:
        """Return the values that are given, by name.

        These are lengths, amounts that are not zero or have a length, the file of deviations, and pitch
        deviations."""
        measured: dict[str, Any] = (
            {} if self.deviations is None else {"deviations": self.deviations.reference}
        )
        if self.pitch_deviations_um is not None:
            measured[PITCH] = list(self.pitch_deviations_um)
        return measured | {
            name: value
            for name in limits_of(type(self))
            if (value := getattr(self, name)) is not None
            and (np.any(value) or vars(self).get(length_of(name)) is not None)
        }

    @property
    def empty(self) -> bool:
        """Whether all amounts and deviations are zero. Pitch deviations do not change the form of a flank."""
        return (self.deviations is None or self.deviations.empty) and not any(
            np.any(getattr(self, name)) for name in kinds_of(type(self))
        )

    def terms(self) -> Iterator[tuple[Kind, Quantity, Quantity | None]]:
        """Yield the kinds whose amounts are not zero, with amount (um) and length (mm)."""
        for name, row in kinds_of(type(self)).items():
            if np.any(amount := getattr(self, name)):
                yield row, amount, getattr(self, length_of(name)) if row.has_length else None


def length_of(name: str) -> str:
    """Return the name of the length that belongs to the amount `name` of a relief."""
    return name.removesuffix(AMOUNT_SUFFIX) + LENGTH_SUFFIX


def kinds_of(modification: type[Modification] = Modification) -> dict[str, Kind]:
    """Return the kinds of a class of modifications by the names of their amounts."""
    rows: tuple[Field[Any], ...] = fields(modification)
    return {row.name: row.metadata["kind"] for row in rows if "kind" in row.metadata}


def limits_of(modification: type[Modification] = Modification) -> dict[str, FieldLimit]:
    """Return the limits of a class of modifications by field."""
    length = FieldLimit(1e-6, 1e4, "mm", "give the length of the relief in mm", optional=True)
    return {
        row.name: AMOUNT if "kind" in row.metadata else length
        for row in fields(modification)
        if row.name not in ("deviations", PITCH)
    }


def missing_lengths(modification: type[Modification], given: dict[str, Any]) -> Iterator[Fault]:
    """Yield the faults of amounts without the length that they need.

    Parameters
    ----------
    modification : type
    given : dict
        Amounts and lengths by name.
    """
    for name, row in kinds_of(modification).items():
        if row.has_length and name in given and length_of(name) not in given:
            yield Fault("", name, f"needs {length_of(name)}: give the length of the relief in mm")


def missing_amounts(modification: type[Modification], given: dict[str, Any]) -> Iterator[Fault]:
    """Yield the faults of lengths without the amount to which they belong, as `missing_lengths`."""
    for name, row in kinds_of(modification).items():
        if row.has_length and length_of(name) in given and name not in given:
            yield Fault("", length_of(name), f"needs {name}: give the amount of the relief in um")
