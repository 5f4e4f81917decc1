"""All that the page says of a design, computed once: results to draw, and the numbers as JSON.

The JSON is that of the commands of `beveloid-geom`, word for word, by section and flank.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from typing import Any, TypeAlias

from beveloid_geom import (
    ContactPath,
    Design,
    Tolerances,
    path_of_contact,
    tolerance_study,
)
from beveloid_geom.analysis.tolerance import UNIT, USUAL, ToleranceStudy, mounted
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.findings.path import first_contact_fault
from beveloid_geom.findings.remarks import Remark, in_order
from beveloid_geom.report.closing import closing_report
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.report.path import ContactReport, contact_report
from beveloid_geom.report.pattern import PatternReport, pattern_report
from beveloid_geom.report.result import json_text
from beveloid_geom.report.sensitivity import SensitivityReport, sensitivity_report
from beveloid_geom.report.sliding import SlidingReport, sliding_report
from beveloid_geom.report.statements import StatementsReport
from beveloid_geom.report.tolerance import ToleranceReport, tolerance_remarks
from beveloid_geom.studies.statements import is_papers, paper_statements

from ..parts.solved import FLANKS

POSITIONS, CYCLE_POSITIONS, HARMONICS, FILM = 101, 121, 10, MARKING_SEPARATION
"""What `beveloid-geom tca` and `operation` take unless told otherwise; the film in mm."""
CLOUD, CLOUD_POINTS = 240, 9
"""Mountings whose paths are drawn, and positions of each."""
STAGES = 2 + 6 * len(FLANKS)
"""Of `compute`, besides the UNITs of mountings."""
Progress: TypeAlias = Callable[[str], object]
Section: TypeAlias = tuple[Any, str, str | None]
"""What was found, its JSON, and why there is nothing, None if there is."""


@dataclass(frozen=True)
class Settings:
    """Of the tolerance study: tolerances, whether they were `given` or are the usual ones, how many
    mountings are drawn, and the seed."""

    tolerances: Tolerances = USUAL
    given: bool = False
    cases: int = 20_000
    seed: int = 0

    @property
    def steps(self) -> int:
        """Calls of `progress` in `compute`: the stages, and the UNITs of mountings of both flanks."""
        return STAGES + len(FLANKS) * -(-self.cases // UNIT)


@dataclass(frozen=True, eq=False)
class FlankResults:
    """Results of one flank pair; None where there are none, and `reasons` by section says why.

    `cloud`: the paths of the first mountings of the `study`, batch axis first."""

    flank: str
    contact: ContactReport
    study: ToleranceStudy | None
    cloud: ContactPath | None
    numbers: dict[str, Any]
    reasons: dict[str, str]
    operation: OperationReport | None
    sliding: SlidingReport | None
    sensitivity: SensitivityReport | None
    pattern: PatternReport | None


@dataclass(frozen=True, eq=False)
class PageData:
    """The page's contents: results by flank, `numbers`, the JSON by section and flank, and `remarks`, all
    that was found, what matters most first."""

    name: str
    design: Design
    settings: Settings
    flanks: dict[str, FlankResults]
    numbers: dict[str, Any]
    remarks: tuple[Remark, ...]

    @cached_property
    def found(self) -> bool:
        """Whether there is a path of contact on either flank."""
        return any(results.contact.reason is None for results in self.flanks.values())


def compute(name: str, design: Design, settings: Settings, progress: Progress = lambda _: None) -> PageData:
    """Compute everything for a single design. `progress` is called with the name of every stage before it,
    and with that of the tolerance study after each of its UNITs of mountings.

    Raises ValueError for tolerances that do not suit the design, if they were given."""
    numbers: dict[str, Any] = {"design": json.loads(json_text(asdict(design)))}
    progress("check")
    checked = closing_report(name, design)
    numbers["check"] = json.loads(json_text(checked.data()))
    flanks = {flank: _flank_results(name, design, flank, settings, progress) for flank in FLANKS}
    for section in SECTIONS:
        numbers[section] = {flank: results.numbers[section] for flank, results in flanks.items()}
    progress("statements")
    if is_papers(design):
        judged = [one for flank in FLANKS for one in paper_statements(design, flank)]
        numbers["statements"] = json.loads(json_text(StatementsReport(name, design, judged).data()))
    studies = [results.study for results in flanks.values() if results.study is not None]
    shares = [remark for study in studies for remark in tolerance_remarks(study)]
    paths = [remark for results in flanks.values() for remark in results.contact.remarks]
    return PageData(name, design, settings, flanks, numbers, in_order([*shares, *checked.remarks, *paths]))


def _flank_results(
    name: str, design: Design, flank: str, settings: Settings, progress: Progress
) -> FlankResults:
    """Compute the sections of one flank pair, each by itself: one that fails leaves the others."""
    found: dict[str, Any] = {}
    numbers: dict[str, Any] = {}
    reasons: dict[str, str] = {}
    for section, solve in SECTIONS.items():
        stage = partial(progress, f"{section}, {flank}")
        stage()
        result, text, reason = solve(name, design, flank, settings, stage)
        if reason and section == "pattern":
            result, text, reason = _missing(name, flank, reasons.get("operation", reason))
        found[section], numbers[section] = result, json.loads(text)
        if reason:
            reasons[section] = reason
    contact = found.pop("tca")
    known = {section: None if section in reasons else result for section, result in found.items()}
    study = known.pop("tolerance")
    cloud = None if study is None else _cloud(design, study)
    return FlankResults(flank, contact, study, cloud, numbers, reasons, **known)


def _missing(name: str, flank: str, reason: str) -> Section:
    return None, json_text({"design": name, "flank": flank, "reason": reason}), reason


def _reported(found: ContactReport | OperationReport | SlidingReport | SensitivityReport) -> Section:
    return found, json_text(found.data()), found.reason


def _operation(name: str, design: Design, flank: str, *_: object) -> Section:
    if fault := first_contact_fault(design):
        return _missing(name, flank, f"no first contact: {fault}")
    return _reported(operation_report(name, design, flank, CYCLE_POSITIONS, HARMONICS, FILM))


def _tolerance(
    name: str, design: Design, flank: str, settings: Settings, unit_done: Callable[[], object]
) -> Section:
    """Study the tolerances; those that were not given may not suit the design."""
    drawn: dict[str, Any] = {"seed": settings.seed, "progress": lambda _: unit_done()}
    try:
        study = tolerance_study(design, settings.tolerances, flank, settings.cases, **drawn)
    except ValueError as error:
        if settings.given:
            raise
        return _missing(name, flank, str(error))
    none = None if study.mountings.solved.any() else f"no mounting has a path on the {flank} flanks"
    return study, json_text(ToleranceReport(name, design, study).data()), none


def _pattern(name: str, design: Design, flank: str, *_: object) -> Section:
    try:
        found = pattern_report(name, design, flank, FILM)
    except ValueError as error:
        return _missing(name, flank, str(getattr(error, "reason", error)))
    return found, json_text(found.data()), None


SECTIONS: dict[str, Callable[[str, Design, str, Settings, Callable[[], object]], Section]] = {
    "tca": lambda name, design, flank, *_: _reported(contact_report(name, design, flank, POSITIONS)),
    "operation": _operation,
    "sliding": lambda name, design, flank, *_: _reported(sliding_report(name, design, flank, POSITIONS)),
    "sensitivity": lambda name, design, flank, *_: _reported(sensitivity_report(name, design, flank)),
    "tolerance": _tolerance,
    "pattern": _pattern,
}
"""Of one flank pair, in the order in which they are computed."""


def _cloud(design: Design, study: ToleranceStudy) -> ContactPath:
    """Give paths of the first mountings of a study."""
    return path_of_contact(mounted(design, study.mountings.errors[:CLOUD]), study.flank, CLOUD_POINTS)
