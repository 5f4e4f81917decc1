"""Values of the controls: from a design, to a design, and to the options of a command.

The values are a flat mapping as the page sends it: a number for each `Control`, `errors_at`, and `flank`.
Only values that differ from those of the start design are changed, so that a design without changes remains
the start design to the last bit.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from beveloid_geom import Design, Errors, MeshErrors, from_degrees
from beveloid_geom.arrays import FLANKS, MEMBERS
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.design.amounts import amounts_text
from beveloid_geom.design.field_limits import DesignError, Fault, refused
from beveloid_geom.design.file import override
from beveloid_geom.design.keys import ERRORS_AT, checked_table
from beveloid_geom.design.limits import given_at_mesh_faults, mesh_error_faults
from beveloid_geom.design.model import PARALLEL_AXES_SINE, ErrorsAt
from beveloid_geom.design.modification import LENGTH_SUFFIX, kinds_of, length_of
from beveloid_geom.pair.misalignment_at_mesh import at_mesh, from_mesh

from .controls import ERRORS, PLACES, Control, controls_of, measured

Values = Mapping[str, Any]
MAX_FILM_MM, MAX_TORQUE_NM = 10.0, 1e12
"""Limits of film thickness and torque, those of the commands."""
TILTED_PARALLEL_AXES = (
    "makes parallel axes intersect or cross far away from the gears, where the equivalent errors exceed their"
    " limits: set it to 0"
)
"""Message for a tilt of parallel axes at the pitch point. A smaller tilt is no cure, as the axes then
intersect even farther away."""


@dataclass(frozen=True)
class ViewSettings:
    """Settings that do not belong to the design: driving flanks, film thickness (mm), torque on the pinion
    (Nm, 0 for none)."""

    flank: str = "right"
    film: float = MARKING_SEPARATION_MM
    torque: float = 0.0


class Start:
    """Start of an exploration: a single design, its name, the settings, and the controls."""

    def __init__(
        self,
        design: Design,
        name: str = "design",
        settings: ViewSettings | None = None,
        given: Mapping[str, Any] | None = None,
    ) -> None:
        """Store the start.

        Parameters
        ----------
        design : Design
            A single design.
        name : str
            Name of the design, as on the command line.
        settings : ViewSettings, optional
            Settings at the start.
        given : mapping, optional
            Arguments of `override` that changed the named design into `design`, for the command line.
        """
        self.given = dict(given or {})
        self.design, self.name, self.settings = design, name, settings or ViewSettings()
        self.controls: dict[str, Control] = {control.name: control for control in controls_of(design)}
        self.values = {**_teeth_values(design, self.controls), **vars(self.settings)}
        self.values |= {"errors_at": design.errors_at}
        for place in PLACES:
            self.values |= errors_values(design, place)

    def read(self, values: Values) -> tuple[Design, ViewSettings]:
        """Return design and settings for values of the controls.

        Parameters
        ----------
        values : mapping
            Values by name, from the page; missing ones are those of the start.

        Returns
        -------
        tuple of Design and ViewSettings

        Raises
        ------
        DesignError
            With all faults; the key of a fault is the name of its control where there is one.
        """
        given = {**self.values, **self._checked(values)}
        faults: list[Fault] = []
        design = self.design
        if given["errors_at"] == "mesh" and self._changed(given, ERRORS["mesh"]):
            design = _mounted_at_mesh(design, given, faults)
        try:
            design = override(design, **self.changes(given))
        except DesignError as error:
            faults += [self._named(fault, given["flank"]) for fault in error.parts]
        if faults:
            raise DesignError(faults)
        return design, ViewSettings(given["flank"], float(given["film"]), float(given["torque"]))

    def _named(self, fault: Fault, flank: str) -> Fault:
        """Return a fault of `override` with the name of its control as key, where there is one.

        A fault of both flanks of a member has the name of the control of the driving `flank`."""
        table, key, text = fault
        if key.endswith("_modification"):  # the key of the table is the first word of the text
            table, (key, _, text) = key.replace("_", "."), text.partition(" ")
        words = f"{table}.{key}".split(".")
        if len(words) > 2 and words[1] == "modification":
            name = ".".join((words[0], *([flank] if len(words) == 3 else []), *words[2:]))
            return Fault("", name, text) if name in self.controls else fault
        return fault._replace(key=_control_of(fault.key))

    def changes(self, given: Values) -> dict[str, Any]:
        """Return the arguments of `design.file.override` for values that differ from the start."""
        changes: dict[str, Any] = {}
        if given["errors_at"] == "perpendicular":
            changes = {name: given[name] for name in self._changed(given, ERRORS["perpendicular"])}
        for name in MEMBERS:
            if not measured(getattr(self.design, name)):
                changes |= self._tooth_changes(name, given)
        return changes

    def _changed(self, given: Values, names: Iterable[str]) -> list[str]:
        """Return the names whose values differ from the start."""
        return [name for name in names if given[name] != self.values[name]]

    def _tooth_changes(self, name: str, given: Values) -> dict[str, Any]:
        """Return the arguments for parabolas and modification of a member."""
        changes: dict[str, Any] = {}
        coefficients = {f"{name}.{flank}.parabola": f"parabola_{flank}_{name}" for flank in FLANKS}
        for key in self._changed(given, coefficients):
            changes[coefficients[key]] = given[key]
        amounts = [key for key in self.controls if key.startswith(f"{name}.") and key not in coefficients]
        if self._changed(given, amounts):
            tables = {flank: _amounts(f"{name}.{flank}", given) for flank in FLANKS}
            same = tables["right"] == tables["left"]
            different = {flank: table for flank, table in tables.items() if table}
            changes[f"{name}_modification"] = tables["right"] if same else different
        return changes

    def _checked(self, values: Values) -> dict[str, Any]:
        """Return the values after a check of their kinds and of the settings. Raises DesignError."""
        faults: list[Fault] = []
        choices = {"errors_at": PLACES, "flank": FLANKS}
        highest = {"film": MAX_FILM_MM, "torque": MAX_TORQUE_NM}
        for name, value in values.items():
            if name in choices:
                if value not in choices[name]:
                    limit = f"be {' or '.join(choices[name])}"
                    faults.append(Fault("", name, refused(limit, value, "choose one of them")))
            elif name not in self.controls:
                faults.append(Fault("", name, "is not a control of this pair: reload the page"))
            elif not _finite(value):
                cure = "write it with a decimal point"
                faults.append(Fault("", name, refused("be a finite number", value, cure)))
            elif name in highest and not 0.0 <= value <= highest[name]:
                unit = self.controls[name].unit
                limit = f"be between 0 and {highest[name]:g} {unit}"
                faults.append(Fault("", name, refused(limit, value, f"give it in {unit}")))
        if faults:
            raise DesignError(faults)
        return dict(values)

    def command(self, values: Values) -> tuple[str, str]:
        """Return the command line of `operation` for the same values, and a reason if there is none.

        Returns
        -------
        tuple of str
            Command line and '', or '' and the reason.
        """
        design, settings = self.read(values)
        changes = self.changes({**self.values, **values})
        if design.errors != self.design.errors:
            if self.design.errors_at == "mesh" and any(vars(self.design.errors).values()):
                return "", "the options are about the common perpendicular: save the design and use its file"
            for name, (field, _) in ERRORS["perpendicular"].items():
                value = getattr(design.errors, field)
                if value != getattr(self.design.errors, field):
                    changes.setdefault(name, math.degrees(value) if name.endswith("_deg") else value)
        words = ["beveloid-geom", "operation", self.name, "--flank", settings.flank]
        words += ["--film", repr(settings.film)]
        for name, value in {**self.given, **changes}.items():
            text = amounts_text(value) if isinstance(value, dict) else repr(float(value))
            words.append(f"--{name.replace('_', '-')}={text}")  # so that a minus sign is not an option
        return shlex.join(words), ""

    def at(self, values: Values, place: ErrorsAt) -> dict[str, float]:
        """Return the values of the errors at another place for the same mounting. Raises DesignError."""
        return errors_values(self.read(values)[0], place)


def errors_values(design: Design, place: ErrorsAt) -> dict[str, float]:
    """Return the errors of a design at a place by the names of their controls, mm and deg; 0 if they have no
    equivalent there."""
    errors: Errors | MeshErrors = design.errors
    if place == "mesh":
        errors = at_mesh(design) if any(vars(design.errors).values()) else MeshErrors()
    values = {}
    for name, (field, _) in ERRORS[place].items():
        value = float(getattr(errors, field))
        value = math.degrees(value) if name.endswith("_deg") else value
        # Twelve decimals are below the rounding of the conversion.
        values[name] = round(value, 12) + 0.0 if math.isfinite(value) else 0.0
    return values


def _finite(value: object) -> bool:
    """Return whether a value of the page is a finite number of double precision."""
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # an integer of hundreds of digits
        return False


def _teeth_values(design: Design, controls: Mapping[str, Control]) -> dict[str, float]:
    """Return parabolas and modifications of a design by the names of their controls."""
    values = dict.fromkeys((name for name in controls if name.count(".") == 2), 0.0)
    for name in values:
        of, flank, key = name.split(".")
        member = getattr(design, of)
        modification = member.modification(flank)
        value = member.tool.parabola_of(flank) if key == "parabola" else getattr(modification, key, 0.0)
        if not value and key.endswith(LENGTH_SUFFIX):  # the length with which a new relief begins
            value = 0.5 * controls[name].high
        values[name] = float(value or 0.0)
    return values


def _mounted_at_mesh(design: Design, given: Values, faults: list[Fault]) -> Design:
    """Return the design with errors at the mesh; faults are added to `faults`."""
    table = checked_table(ERRORS_AT["mesh"], "", {name: given[name] for name in ERRORS["mesh"]}, faults)
    if table is None:
        return design
    errors = from_degrees(MeshErrors, **table)
    new = [*given_at_mesh_faults(design.pinion, design.pair, errors)]
    equivalent = Errors() if new else from_mesh(design, errors)
    too_large = [*mesh_error_faults(design.pinion, equivalent)]
    parallel = abs(math.sin(design.pair.shaft_angle)) <= PARALLEL_AXES_SINE
    if too_large and parallel and errors.out_of_plane != 0.0 and math.isfinite(equivalent.offset):
        # Without the tilt, the equivalent errors are those given at the mesh, which are within their limits.
        too_large = [Fault("", "out_of_plane_deg", TILTED_PARALLEL_AXES)]
    new += too_large
    faults += [fault._replace(table="") for fault in new]
    return design if new else design.with_errors(equivalent)


def _amounts(group: str, given: Values) -> dict[str, float]:
    """Return the table of a modification in a design file for a group such as 'pinion.right', without amounts
    of 0 and their lengths."""
    table: dict[str, float] = {}
    for amount, kind in kinds_of().items():
        if given[f"{group}.{amount}"]:
            table[amount] = given[f"{group}.{amount}"]
            length = given[f"{group}.{length_of(amount)}"] if kind.has_length else 0.0
            if length:  # a missing length is reported by name
                table[length_of(amount)] = length
    return table


def _control_of(argument: str) -> str:
    """Return the name of the control for an argument of `override`, or the argument."""
    words = argument.split("_")
    if words[0] == "parabola" and len(words) == 3:
        return f"{words[2]}.{words[1]}.parabola"
    return argument
