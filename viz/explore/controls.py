"""Controls of the window: which values of a design can be changed, with unit and range of the slider.

The range of a slider is a suggestion. Number fields accept every value that a design file accepts; the limits
are those of the design layer (`values.design_of`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from beveloid_geom import Design, Member
from beveloid_geom.analysis.tolerance import USUAL_AT
from beveloid_geom.arrays import FLANKS, MEMBERS
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.design.ends import end_names
from beveloid_geom.design.model import ErrorsAt
from beveloid_geom.design.modification import kinds_of, length_of

PLACES: tuple[ErrorsAt, ...] = ("perpendicular", "mesh")
"""Places at which errors are measured: the common perpendicular, or the pitch point."""
ERRORS: dict[ErrorsAt, dict[str, tuple[str, str]]] = {
    "perpendicular": {
        "offset_error": ("offset", "Offset"),
        "shaft_angle_error_deg": ("shaft_angle", "Shaft angle"),
        "pinion_axial_error": ("pinion_axial", "Pinion, axial"),
        "gear_axial_error": ("gear_axial", "Gear, axial"),
    },
    "mesh": {
        "centre_distance": ("centre_distance", "Centre distance"),
        "in_plane_deg": ("in_plane", "Shaft angle, in plane"),
        "out_of_plane_deg": ("out_of_plane", "Tilt, out of plane"),
        "pinion_axial": ("pinion_axial", "Pinion, axial"),
        "gear_axial": ("gear_axial", "Gear, axial"),
    },
}
"""Names of the controls of the errors, with the field of `Errors` or `MeshErrors` and the label."""


@dataclass(frozen=True)
class Control:
    """One slider with a number field.

    Attributes
    ----------
    name : str
        Name of the value.
    group : str
        Group of controls: 'perpendicular', 'mesh', 'contact', or member and flank such as 'pinion.right'.
    label, unit : str
    low, high : float
        Range of the slider, in the unit.
    """

    name: str
    group: str
    label: str
    unit: str
    low: float
    high: float

    @property
    def step(self) -> float:
        """Step of the slider: 1, 2 or 5 times a power of ten, at least 100 steps in the range."""
        power = 10.0 ** math.floor(math.log10((self.high - self.low) / 100.0))
        fine = (self.high - self.low) / 100.0 / power
        return float(f"{power * max(n for n in (1.0, 2.0, 5.0) if n <= fine + 1e-9):.6g}")

    def data(self) -> dict[str, Any]:
        """Return the control for the page."""
        return {**vars(self), "step": self.step}


def controls_of(design: Design) -> tuple[Control, ...]:
    """Return the controls for a design, in the order of the window."""
    return (
        *_error_controls(),
        *(row for name in MEMBERS for flank in FLANKS for row in _flank_controls(design, name, flank)),
        Control("film", "contact", "Film thickness", "mm", 0.0, 4.0 * MARKING_SEPARATION_MM),
        Control("torque", "contact", "Torque on the pinion", "Nm", 0.0, _torque_scale(design)),
    )


def measured(member: Member) -> bool:
    """Return whether a member has measured flanks or pitches; its teeth cannot be changed."""
    return member != member.nominal()


def _error_controls() -> Iterator[Control]:
    """Yield the controls of the errors. Sliders reach five times the usual tolerances."""
    for place, errors in ERRORS.items():
        usual = USUAL_AT[place]
        for name, (error, label) in errors.items():
            angle = name.endswith("_deg")
            size = float(getattr(usual, error))
            reach = round(5.0 * (math.degrees(size) if angle else size), 9)
            yield Control(name, place, label, "deg" if angle else "mm", -reach, reach)


def _flank_controls(design: Design, name: str, flank: str) -> Iterator[Control]:
    """Yield the controls of one flank of a member, none for measured teeth."""
    member: Member = getattr(design, name)
    if measured(member):
        return
    group, module = f"{name}.{flank}", float(member.tool.normal_module)
    # A parabola of 2/1000 per mm on a tool of module 6 removes 72 um at one module from its apex.
    reach = float(f"{0.072 / module**2:.1g}")
    yield Control(f"{group}.parabola", group, "Parabola coefficient", "1/mm", -reach, reach)
    back, front = end_names(member)
    printed = {"toe_relief": f"{back} relief", "heel_relief": f"{front} relief"}
    for amount, kind in kinds_of().items():
        key = amount.removesuffix("_um")
        label = printed.get(key, key.replace("_", " ")).capitalize()
        low = 0.0 if kind.has_length else -50.0
        yield Control(f"{group}.{amount}", group, label, "µm", low, 50.0)
        if kind.has_length:
            across = kind.profile == "active"
            longest = 0.5 * float(member.face_width) if across else 2.0 * module
            longest = float(f"{longest:.2g}")
            yield Control(
                f"{group}.{length_of(amount)}", group, f"{label}, length", "mm", 0.1 * longest, longest
            )


def _torque_scale(design: Design) -> float:
    """Return the upper end of the slider of the torque, Nm, for steel teeth of this size."""
    pinion = design.pinion
    size = float(pinion.tool.normal_module) ** 2 * float(pinion.face_width) * float(pinion.teeth)
    return float(f"{0.05 * size:.1g}")
