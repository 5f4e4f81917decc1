"""Likely unit mistakes: lengths within their limits that fit the other lengths only if they are in
inches, and a Young's modulus in GPa.

A single length cannot show its unit, so lengths are compared with each other. A module of 1/12 is the
exception: it is the module, in inches, of a tool with a diametral pitch of 12, and no standard module in mm.
A design with all lengths in inches and a module such as 0.1 is a sound design of a small gear and gets no
warning.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from ..design.model import Design
from ..design.written_numbers import MM_PER_INCH
from ..gear.fillet import root_radius
from ..gear.flank_limits import tip_radius
from ..pair.mounting import mounting_of
from .diagnostics import WARNING, Remark
from .reach import reach_of


def unit_remarks(design: Design) -> Iterator[Remark]:
    """Yield warnings on lengths of a single design that are probably given in inches.

    Checked are the module against the usual diametral pitches, each face width against the module, offset and
    module against the tips and roots of the members, and given against computed mounting distances."""
    # Usual face widths.
    face_width_range_modules = (3.0, 60.0)
    # Face width below which a unit mistake is more likely than such a narrow gear.
    least_face_width_modules = 1.0
    module = float(design.pinion.tool.normal_module)
    lengths: list[tuple[str, float]] = []
    if _is_inch_module(module) or _offset_needs(design, "module"):
        lengths.append(("normal_module", module))
    for name, member in zip(("pinion", "gear"), design.members, strict=True):
        width = float(member.face_width)
        width_in_modules = width / float(member.tool.normal_module)
        low, high = face_width_range_modules
        if width_in_modules < least_face_width_modules and low <= MM_PER_INCH * width_in_modules <= high:
            lengths.append((f"face_width of the {name}", width))
    if not lengths and _offset_needs(design, "offset"):
        lengths.append(("offset", float(design.pair.offset)))
    lengths += _mounting_distances_in_inches(design)
    for name, value in lengths:
        inches = f"was it given in inches? {value:.6g} in are {MM_PER_INCH * value:.6g} mm"
        yield Remark(
            WARNING, f"the {name} of {value:.6g} mm is unusual or does not fit the other lengths: {inches}"
        )


def modulus_remarks(young_mpa: float) -> Iterator[Remark]:
    """Yield a warning on a Young's modulus that no usual material of gears has."""
    # Soft plastics to cemented carbides.
    low_mpa, high_mpa = 500.0, 1e6
    if not low_mpa <= young_mpa <= high_mpa:
        value = f"{young_mpa:.6g}"
        cure = "steel has about 206000 MPa"
        if young_mpa < low_mpa:
            cure = f"was it given in GPa? {value} GPa are {1e3 * young_mpa:.6g} MPa"
        yield Remark(WARNING, f"the Young's modulus of {value} MPa is unusual: {cure}")


def _is_inch_module(module: float) -> bool:
    """Return whether a module is that of a usual diametral pitch in inches, and no standard one in mm."""
    # Usual diametral pitches, 1/in.
    diametral_pitches = (3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 36, 40, 48, 56, 64, 72, 80, 96)
    # Relative tolerance of a module given in inches with a few digits.
    pitch_tolerance = 2e-3
    # Standard modules below 1 mm (DIN 780) are multiples of this step.
    metric_module_step_mm = 0.01
    steps = module / metric_module_step_mm
    if abs(steps - round(steps)) < pitch_tolerance:
        return False
    return any(abs(module * pitch - 1.0) < pitch_tolerance for pitch in diametral_pitches)


def _offset_needs(design: Design, length: str) -> bool:
    """Return whether the teeth reach each other only if the 'module' or the 'offset' is in inches."""
    if float(design.pair.offset) == 0.0 or _teeth_overlap(design, 1.0, 1.0):
        return False
    return _teeth_overlap(design, *((MM_PER_INCH, 1.0) if length == "module" else (1.0, MM_PER_INCH)))


def _teeth_overlap(design: Design, module_factor: float, offset_factor: float) -> bool:
    """Return whether the teeth reach each other without overlap, after both lengths are scaled: the offset is
    at least that at which tips meet bottom lands, and at most that at which tips meet tips."""
    offset = offset_factor * float(design.pair.offset) / module_factor
    if float(design.pair.shaft_angle) > 0.0:
        reach = reach_of(design)
        return reach.bottoming <= offset <= reach.touching
    # Parallel axes: the limits are sums of radii.
    tips = [float(tip_radius(member, 0.0)) for member in design.members]
    roots = [float(root_radius(member, 0.0)) for member in design.members]
    return max(tips[0] + roots[1], roots[0] + tips[1]) <= offset <= sum(tips)


def _mounting_distances_in_inches(design: Design) -> Iterator[tuple[str, float]]:
    """Yield name and value of the mounting distances that agree with the pitch point only in inches."""
    given = [(name, getattr(design.pair, f"{name}_mounting")) for name in ("pinion", "gear")]
    if all(value is None for _, value in given):
        return
    pair = replace(design.pair, pinion_mounting=None, gear_mounting=None)
    computed = mounting_of(replace(design, pair=pair)).distance.tolist()
    for (name, value), distance in zip(given, computed, strict=True):
        if value is None or math.isnan(distance) or abs(float(value) - distance) < 0.5 * abs(distance):
            continue
        if abs(MM_PER_INCH * float(value) - distance) < 0.1 * abs(distance):
            yield f"{name}_mounting", float(value)
