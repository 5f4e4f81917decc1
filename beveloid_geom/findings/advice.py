"""Advice on layouts in which the gears do not mesh.

A change of the offset, the shaft angle or one helix angle is computed, rounded to the printed digits and
checked as by `check`. Changes with an error or a warning are not given; warnings on teeth and units that the
design already has do not count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FLANKS
from ..contact.path import path_of_contact
from ..design.arguments import require_single
from ..design.model import Design, Pair
from ..operation.certificate import path_certificate
from ..pair.zero_backlash import LayoutDeviation, layout_deviation
from ..status import Status
from .diagnostics import Remark, in_order, quiet, tooth_remarks
from .layout import HELIX_TOLERANCE_RAD, ideal_layout, layout_remarks, remarks_on
from .path import certificate_remarks, first_contact_fault, path_remarks
from .reach import rolling_generator_angle
from .units import unit_remarks

SIGNIFICANT_DIGITS = 7
"""Significant digits of advice; their rounding is a hundredth of the layout tolerances for pairs of usual
size."""


def _deg(angle: float) -> str:
    """Return an angle in deg as text."""
    return f"{math.degrees(angle):.{SIGNIFICANT_DIGITS}g} deg"


def _helix_of(member: str) -> str:
    """Return the name of a change of the helix angle of one member."""
    return f"helix angle of the {member}"


@dataclass(frozen=True)
class Advice:
    """Changed layout for which `check` has no error or warning, except warnings on teeth and units that the
    design already has.

    Attributes
    ----------
    change : str
        Name of the quantity that differs from the design.
    offset, shaft_angle : float
        mm and rad.
    pinion_helix_angle, gear_helix_angle : float
        rad.
    """

    change: str
    offset: float
    shaft_angle: float
    pinion_helix_angle: float
    gear_helix_angle: float

    def words(self) -> str:
        """Return the change and the new values as text."""
        helix = {_helix_of("pinion"): self.pinion_helix_angle, _helix_of("gear"): self.gear_helix_angle}
        angle = f" to {_deg(helix[self.change])}" if self.change in helix else ""
        layout = f"E = {self.offset:.{SIGNIFICANT_DIGITS}g} mm, shaft angle = {_deg(self.shaft_angle)}"
        return f"change the {self.change}{angle}: {layout}"

    def applied_to(self, design: Design) -> Design:
        """Return the design with the change, mounted at its pitch point."""
        pinion = replace(design.pinion, helix_angle=self.pinion_helix_angle)
        gear = replace(design.gear, helix_angle=self.gear_helix_angle)
        return replace(design, pinion=pinion, gear=gear, pair=Pair(self.offset, self.shaft_angle))


def design_remarks(
    design: Design, deviation: LayoutDeviation | None = None, jam: str | None = None
) -> tuple[Remark, ...]:
    """Return the remarks of `check` on layout, teeth and paths of a single design.

    Parameters
    ----------
    design : Design
    deviation : LayoutDeviation, optional
        Result of `layout_deviation`, if it is known.
    jam : str, optional
        Reason why the pair cannot be assembled as mounted (`findings.backlash`), if it is known.

    Returns
    -------
    tuple of Remark
        The most important first.

    References
    ----------
    Remarks and their levels: beveloid_geom/findings/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> (remark,) = bg.design_remarks(bg.builtin_design("ni-2017"))
    >>> remark.level, remark.text[:34]
    ('note', 'right flanks: sensitive to errors,')
    """
    return in_order(iter_findings(design, deviation, jam))


def iter_findings(
    design: Design, deviation: LayoutDeviation | None = None, jam: str | None = None, certified: bool = True
) -> Iterator[Remark]:
    """Yield the remarks of `design_remarks` one by one, so that a caller can stop at the first warning.

    If `certified` is false, it is not computed at which positions of the paths another tooth, an edge or a
    fillet touches earlier (`operation.certificate`). This is sufficient for pairs in which only flanks can
    touch first."""
    # Positions of the path that `check` certifies.
    check_positions = 101
    yield from remarks_on(design, deviation, jam)
    paths = [path_of_contact(design, flank, check_positions) for flank in FLANKS]
    for path in paths:
        yield from path_remarks(path)
    if certified and first_contact_fault(design) is None:
        for path in paths:
            if path.ends.status == Status.SOLVED:
                yield from certificate_remarks(path, path_certificate(path))


def layout_advice(design: Design) -> tuple[Advice, ...]:
    """Return at most three changes of a layout that has an error or a warning, in the order of trial.

    If the shaft angle does not fit the helix angles, one helix angle is tried first; otherwise the mounting
    distances, if they are given. The offset, the shaft angle, and both together follow.

    Parameters
    ----------
    design : Design
        A single design.

    Returns
    -------
    tuple of Advice
        Empty if no change is necessary, or if no tested change is sufficient.

    Raises
    ------
    ValueError
        For arrays.

    References
    ----------
    Changes of a layout: beveloid_geom/findings/README.md.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import beveloid_geom as bg
    >>> design = bg.builtin_design("ni-2017")
    >>> tight = replace(design, pair=replace(design.pair, offset=228.5))
    >>> bg.layout_advice(tight)[0].offset
    229.0751
    """
    require_single(design)
    plain = design.bare()
    if quiet(layout_remarks(plain)):
        return ()
    known = {remark for name in ("pinion", "gear") for remark in tooth_remarks(name, getattr(plain, name))}
    known |= set(unit_remarks(plain))
    advice: list[Advice] = []
    for change, candidate in _candidates(plain):
        rounded = _rounded(change, candidate)
        tried = rounded.applied_to(plain)
        known_layout = tried in [other.applied_to(plain) for other in advice]
        if not known_layout and quiet(r for r in iter_findings(tried) if r not in known):
            advice.append(rounded)
        if len(advice) == 3:  # enough for one design
            break
    return tuple(advice)


def _candidates(design: Design) -> Iterator[tuple[str, Design]]:
    """Yield the name of a change and the changed design.

    If the shaft angle fits the helix angles, the layout is changed. Otherwise a helix angle is changed first,
    because the shaft angle is the requirement."""
    ideal = ideal_layout(design)
    if ideal is None:
        return
    required = float(design.pair.shaft_angle)
    helix_misfit = abs(float(ideal.shaft_angle) - required) > HELIX_TOLERANCE_RAD
    if design.pair.offset == 0.0 != ideal.offset:
        yield from _with_helix(design, (0.0,))
    if helix_misfit:
        yield from _with_helix(design)
    elif design.pair.pinion_mounting is not None or design.pair.gear_mounting is not None:
        yield "mounting distances to those of the pitch point", design
    offset, angle = float(ideal.offset), float(ideal.shaft_angle)
    deviation = layout_deviation(replace(design, pair=Pair(max(offset, 0.0), required)))
    if not helix_misfit and deviation.offset >= 0.0:
        yield "offset", replace(design, pair=Pair(deviation.offset, required))
    deviation = layout_deviation(replace(design, pair=Pair(design.pair.offset, angle)))
    if not math.isnan(deviation.shaft_angle):
        yield "shaft angle", replace(design, pair=Pair(design.pair.offset, deviation.shaft_angle))
    if offset >= 0.0:
        yield "offset and shaft angle", replace(design, pair=Pair(offset, angle))


def _with_helix(design: Design, hands: tuple[float, ...] = (1.0, -1.0)) -> Iterator[tuple[str, Design]]:
    """Yield designs with one changed helix angle, first of the gear, then of the pinion.

    For each member the smaller change of those for `hands` is taken, see `_fitted`."""
    for name in ("gear", "pinion"):
        fitting = [fitted for hand in hands if (fitted := _fitted(design, name, hand)) is not None]
        before = float(getattr(design, name).helix_angle)
        changes = [abs(float(getattr(fitted, name).helix_angle) - before) for fitted in fitting]
        if changes:
            yield _helix_of(name), fitting[int(np.argmin(changes))]


def _fitted(design: Design, name: str, hand: float) -> Design | None:
    """Return the design without backlash whose helix angle of member `name` fits the shaft angle, None if
    there is none.

    `hand` is the sign of the sum of the helix angles; 0 selects intersecting axes."""
    # Largest helix angle that is advised, rad.
    max_helix = math.radians(60.0)
    required, changed = float(design.pair.shaft_angle), design
    # Each correction leaves about a tenth of the error.
    max_corrections, angle_tolerance_rad = 8, 1e-9
    for _ in range(max_corrections):
        ideal = ideal_layout(changed)
        if ideal is None:
            return None
        helix_sum = rolling_generator_angle(ideal.cone_angle, required) if hand else 0.0
        missing = hand * helix_sum - float(np.sum(ideal.helix_angle))
        helix = float(getattr(changed, name).helix_angle)
        if abs(missing) < angle_tolerance_rad:
            layout = (max(float(ideal.offset), 0.0), required) if hand else (0.0, float(ideal.shaft_angle))
            return replace(changed, pair=Pair(*layout))
        if not abs(helix + missing) < max_helix:
            return None
        changed = replace(changed, **{name: replace(getattr(changed, name), helix_angle=helix + missing)})
    return None


def _rounded(change: str, design: Design) -> Advice:
    """Return the layout of a design as advice, rounded to the printed digits."""
    angles = (design.pair.shaft_angle, design.pinion.helix_angle, design.gear.helix_angle)
    rounded = (math.radians(float(f"{math.degrees(angle):.{SIGNIFICANT_DIGITS}g}")) for angle in angles)
    return Advice(change, float(f"{design.pair.offset:.{SIGNIFICANT_DIGITS}g}"), *rounded)
