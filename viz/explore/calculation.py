"""Results for one set of values, in three stages: contact and motion, contact pattern, remarks.

The stages are in the order of their importance while a slider is dragged. Each returns a dictionary for the
page without NaN. The numbers are those of the commands `tca`, `operation` and `pattern` for the same design.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from beveloid_geom import ContactPath, Design, Load, path_of_contact, path_pressure
from beveloid_geom.findings.backlash import BacklashReport, backlash_report
from beveloid_geom.findings.diagnostics import UNKNOWN, Remark, in_order
from beveloid_geom.findings.layout import layout_remarks
from beveloid_geom.findings.path import first_contact_fault, path_remarks, pressure_remarks, reason_of
from beveloid_geom.findings.units import unit_remarks
from beveloid_geom.pair.mounting import unmodified_backlash
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.status import NotComputed

from ..report.view_data import flank_data, member_frames
from .panels import flank_panels, graph_panel, pattern_panels
from .values import ViewSettings

PATH_POINTS, CYCLE_POINTS, HARMONICS = 101, 121, 10
"""Positions along the path and over the mesh cycle, and harmonics: the defaults of `tca` and `operation`."""
VIEW_TOLERANCE_MODULES = 0.01
"""Deviation of the triangles of the teeth, and of the paths on them, in the 3D view."""
SMALL_BACKLASH_MM = 0.02
"""Backlash of the unmodified flanks below which the pair is checked for jamming before anything is shown."""


class Calculation:
    """Results for one design and settings; every stage is computed when it is asked for."""

    def __init__(self, design: Design, settings: ViewSettings) -> None:
        """Store design and settings."""
        self.design, self.settings = design, settings

    @cached_property
    def path(self) -> ContactPath:
        """Path of contact."""
        return path_of_contact(self.design, self.settings.flank, PATH_POINTS)

    @cached_property
    def backlash(self) -> BacklashReport:
        """Backlash as mounted."""
        return backlash_report(self.design)

    @cached_property
    def operation(self) -> OperationReport:
        """Mesh cycle, contact ratios and first contacts."""
        settings = self.settings
        return operation_report(
            "", self.design, settings.flank, CYCLE_POINTS, HARMONICS, float(settings.film)
        )

    def motion(self) -> dict[str, Any]:
        """Return path, first contacts, motion graph and their main numbers, or status and reason."""
        reason = reason_of(self.path) or first_contact_fault(self.design)
        # The backlash takes as long as all the rest, so that it is computed first only if it may be lost.
        if not reason and unmodified_backlash(self.design) < SMALL_BACKLASH_MM and self.backlash.jam:
            return _nothing("jammed", self.backlash.jam)
        reason = reason or self.operation.reason
        if reason:  # a failed calculation does not prove that there is no contact
            return _nothing("not computed" if isinstance(reason, NotComputed) else "no contact", reason)
        operation = self.operation
        return {
            "status": "solved",
            "flank": self.settings.flank,
            "flanks": flank_panels(operation, self.path),
            "graph": graph_panel(operation),
            "figures": list(self._motion_figures()),
            "remarks": _data(self._first_remarks()),
        }

    def pattern(self) -> dict[str, Any]:
        """Return the teeth with their paths, and the contact pattern of the film on both flanks, with its
        shares of the flanks."""
        design, flank = self.design, self.settings.flank
        module = float(design.pinion.tool.normal_module)
        teeth = {
            "frames": member_frames(design),
            "view": flank_data(design, flank, self.operation.cycle, VIEW_TOLERANCE_MODULES * module),
        }
        if self.settings.film <= 0.0:
            return {"patterns": None, "figures": [], **teeth}
        result = self.operation.pattern
        sides = {"pinion": result.pinion, "gear": result.gear}
        figures = [
            _number(f"{name}_pattern", f"Pattern on the {name}", f"{100.0 * side.area_share:.1f}", "%")
            for name, side in sides.items()
        ]
        return {"patterns": pattern_panels(design, flank, result), "figures": figures, **teeth}

    def remarks(self) -> dict[str, Any]:
        """Return all remarks, backlash, and the largest pressure under the torque; or that the pair jams."""
        design, flank, jam = self.design, self.settings.flank, self.backlash.jam
        if jam:
            return _nothing("jammed", jam)
        remarks = [*self._first_remarks(), *layout_remarks(design, flanks=(flank,), jam=None)]
        remarks += [*unit_remarks(design), *self.backlash.remarks, *path_remarks(self.path)]
        if self.settings.film > 0.0:
            remarks += self.operation.remarks
        backlash = self.backlash.normal
        text = f"{backlash:z.4f}" if math.isfinite(backlash) else "not known"
        figures = [_number("backlash", "Normal backlash as mounted", text, "mm")]
        if self.settings.torque > 0.0:
            pressed = path_pressure(self.path, Load(torque_nm=float(self.settings.torque)))
            remarks += pressure_remarks(pressed)
            known = pressed.pressure[np.isfinite(pressed.pressure)]
            text = f"{known.max():.1f}" if known.size else "not known"
            figures.append(_number("pressure", "Largest pressure (Hertz)", text, "MPa"))
        return {"status": "solved", "remarks": _data(remarks), "figures": figures}

    def _first_remarks(self) -> Iterator[Remark]:
        """Yield the remarks that need no further calculation: edge contact and unknown contact ratios."""
        if failure := self.operation.unknown:
            yield Remark(UNKNOWN, f"{self.settings.flank} flanks, in operation: {failure.text}")
        yield from self.operation.edge_remarks

    def _motion_figures(self) -> Iterator[dict[str, str]]:
        """Yield the main numbers of contact and motion."""
        operation = self.operation
        ratios = (operation.eq16, operation.operating, operation.within_film)
        names = ("Contact ratio of one pair (Eq. 16)", "Contact ratio in operation")
        labels = (*names, f"Contact ratio, separation below {1e3 * operation.film:g} µm")
        for name, label, value in zip(("ratio", "operating", "film_ratio"), labels, ratios, strict=True):
            yield _number(name, label, f"{value:.4f}" if math.isfinite(value) else "not known")
        swing = ARCSEC * float(operation.cycle.peak_to_peak)
        yield _number("error", "Transmission error, peak to peak", f"{swing:.3f}", "arcsec")
        share = 0.0 if operation.along_lines else 100.0 * float(operation.cycle.edge_share)
        yield _number("edges", "Mesh cycle with edge contact", f"{share:.1f}", "%")


def _number(name: str, label: str, text: str, unit: str = "") -> dict[str, str]:
    """Return one number of the table of quantities: label, value as text with its digits, and unit."""
    return {"name": name, "label": label, "text": text, "unit": unit}


def _nothing(status: str, reason: str) -> dict[str, Any]:
    """Return status and reason of a pair without a picture."""
    return {"status": status, "reason": reason}


def _data(remarks: Any) -> list[dict[str, str]]:
    """Return remarks for the page, each once, the most important first."""
    return [{"level": level, "text": text} for level, text in in_order(remarks)]
