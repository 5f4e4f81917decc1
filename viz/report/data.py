"""All that the page says of a design, computed once: results to draw, and the numbers as JSON.

The JSON is that of the commands of `beveloid-geom`, word for word, by section and flank.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np

from beveloid_geom import ContactPath, Design, Tolerances, path_of_contact
from beveloid_geom.analysis.pattern_matrix import PatternMatrix, pattern_matrix
from beveloid_geom.analysis.pressure import Load
from beveloid_geom.analysis.tolerance import UNIT, USUAL, ToleranceStudy, tolerance_studies
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.findings.path import first_contact_fault, reason_of
from beveloid_geom.findings.remarks import NOTE, Remark, in_order
from beveloid_geom.pair.errors import mounted
from beveloid_geom.report.closing import closing_report
from beveloid_geom.report.ease_off import EaseOffReport, ease_off_report
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.report.path import ContactReport, contact_report
from beveloid_geom.report.pattern import PatternMatrixReport, PatternReport, pattern_report
from beveloid_geom.report.result import json_text
from beveloid_geom.report.sensitivity import SensitivityReport, sensitivity_report
from beveloid_geom.report.sliding import SlidingReport, sliding_report
from beveloid_geom.report.statements import StatementsReport
from beveloid_geom.report.tolerance import ToleranceReport, tolerance_remarks
from beveloid_geom.report.workshop.gear_data import gear_data_report
from beveloid_geom.studies.statements import is_papers, paper_statements
from beveloid_geom.support.read_only import read_only

from ..parts.motion_graph import MotionGraph, motion_graph
from ..parts.solved import FLANKS

POSITIONS, CYCLE_POSITIONS, HARMONICS, FILM = 101, 121, 10, MARKING_SEPARATION
"""What `beveloid-geom tca` and `operation` take unless told otherwise; the film in mm."""
EASE_OFF_GRID, DRAWN_GRID = (9, 13), (21, 31)
"""Points of the ease-off along profile and face, of its numbers and of its level lines."""
CLOUD, CLOUD_POINTS = 240, 9
"""Mountings whose paths are drawn, and positions of each."""
OVER = ("offset", "shaft_angle")
"""The errors of the matrix of patterns, down its rows and over its columns."""
USUAL_FORCE = 1000.0
"""N along the common normal, where no load is given."""
STAGES = 5 + 6 * len(FLANKS)
"""Of `compute`, besides the UNITs of mountings."""
Progress: TypeAlias = Callable[[str], object]
Section: TypeAlias = tuple[Any, str, str | None]
"""What was found, its JSON, and why there is nothing, None if there is."""


@dataclass(frozen=True)
class Settings:
    """Of the tolerance study: tolerances, whether they were `given` or are the usual ones, how many
    mountings are drawn, and the seed; and the `load` of a tooth pair, `loaded` if it was given."""

    tolerances: Tolerances = USUAL
    given: bool = False
    cases: int = 20_000
    seed: int = 0
    load: Load = field(default_factory=lambda: Load(force=USUAL_FORCE))
    loaded: bool = False

    @property
    def steps(self) -> int:
        """Calls of `progress` in `compute`: the stages, and the UNITs of mountings."""
        return STAGES + -(-self.cases // UNIT)

    @property
    def sizes(self) -> tuple[float, float] | None:
        """Greatest errors of the matrix of patterns, mm and rad: the tolerances given, None (the usual ones)
        if they are not both."""
        given = getattr(self.tolerances, OVER[0]), getattr(self.tolerances, OVER[1])
        return given if self.given and all(given) else None


@dataclass(frozen=True, eq=False)
class FlankResults:
    """Results of one flank pair; None where there are none, and `reasons` by section says why.

    `cloud`: the paths of the first mountings of the `study`, batch axis first; `pressed`: the path with
    Hertz's pressures; `motion`: that of every tooth pair; `matrix`: patterns under two errors."""

    flank: str
    contact: ContactReport
    study: ToleranceStudy | None
    cloud: ContactPath | None
    reasons: dict[str, str]
    operation: OperationReport | None
    sliding: SlidingReport | None
    sensitivity: SensitivityReport | None
    pattern: PatternReport | None
    pressed: ContactReport | None
    matrix: PatternMatrix | None

    @cached_property
    def motion(self) -> MotionGraph | None:
        """The transmission error of every tooth pair alone, and of the one that runs."""
        return None if self.operation is None else read_only(motion_graph(self.operation))


@dataclass(frozen=True, eq=False)
class PageData:
    """The page's contents: results by flank, the ease-off of both, `numbers`, the JSON by section and flank,
    and `remarks`, all that was found, what matters most first."""

    name: str
    design: Design
    settings: Settings
    flanks: dict[str, FlankResults]
    ease_off: EaseOffReport
    numbers: dict[str, Any]
    remarks: tuple[Remark, ...]

    @cached_property
    def found(self) -> bool:
        """Whether there is a path of contact on either flank."""
        return any(results.contact.reason is None for results in self.flanks.values())

    @property
    def verdict(self) -> str:
        """What the remarks come to: the level of the first of them, a note counting as none."""
        return next((one.level for one in self.remarks if one.level != NOTE), NOTE)


def compute(
    name: str,
    design: Design,
    settings: Settings,
    progress: Progress = lambda _: None,
    executor: Executor | None = None,
) -> PageData:
    """Compute everything for a single design. `progress` is called with the name of every stage before it,
    and with that of the tolerance study after each of its UNITs of mountings, which an `executor` solves
    meanwhile, if there is one.

    Raises ValueError for tolerances that do not suit the design, if they were given."""
    numbers: dict[str, Any] = {"design": json.loads(json_text(asdict(design)))}
    with ThreadPoolExecutor(1) as beside:
        study = partial(_tolerances, name, design, settings, progress, executor)
        studied = study if executor is None else beside.submit(study).result
        progress("check")
        checked = closing_report(name, design)
        numbers["check"] = json.loads(json_text(checked.data()))
        numbers["gear_data"] = json.loads(json_text(gear_data_report(name, design).data()))
        sections = {flank: _sections(name, design, flank, settings, progress) for flank in FLANKS}
        matrices = _matrices(name, design, settings, progress)
        progress("ease-off")
        eased = ease_off_report(name, design, DRAWN_GRID)
        numbers["ease_off"] = json.loads(json_text(ease_off_report(name, design, EASE_OFF_GRID).data()))
        progress("statements")
        if is_papers(design):
            judged = [one for flank in FLANKS for one in paper_statements(design, flank)]
            numbers["statements"] = json.loads(json_text(StatementsReport(name, design, judged).data()))
        tolerances = studied()
    for flank, found in sections.items():
        found |= {"tolerance": tolerances[flank], "matrix": matrices[flank]}
    for section in sections[FLANKS[0]]:
        numbers[section] = {flank: json.loads(found[section][1]) for flank, found in sections.items()}
    flanks = {flank: _results_of(design, flank, found) for flank, found in sections.items()}
    numbers["mountings"] = failed_mountings([results.study for results in flanks.values()])
    studies = [one.study for one in flanks.values() if one.study and "tolerance" not in one.reasons]
    shares = [remark for study in studies for remark in tolerance_remarks(study)]
    paths = [remark for results in flanks.values() for remark in results.contact.remarks]
    remarks = in_order([*shares, *checked.remarks, *paths])
    return PageData(name, design, settings, flanks, eased, numbers, remarks)


def _sections(
    name: str, design: Design, flank: str, settings: Settings, progress: Progress
) -> dict[str, Section]:
    """Compute the SECTIONS of one flank pair, each by itself: one that fails leaves the others."""
    found: dict[str, Section] = {}
    for section, solve in SECTIONS.items():
        progress(f"{section}, {flank}")
        found[section] = solve(name, design, flank, settings)
    if (reason := found["pattern"][2]) is not None:
        found["pattern"] = _missing(name, flank, found["operation"][2] or reason)
    return found


def _results_of(design: Design, flank: str, sections: dict[str, Section]) -> FlankResults:
    """Put the sections of one flank pair together."""
    found = {section: result for section, (result, *_) in sections.items()}
    reasons = {section: reason for section, (*_, reason) in sections.items() if reason}
    contact, study = found.pop("tca"), found.pop("tolerance")
    known = {section: None if section in reasons else result for section, result in found.items()}
    known["pressed"] = known.pop("hertz")
    cloud = None if "tolerance" in reasons else _cloud(design, study)
    return FlankResults(flank, contact, study, cloud, reasons, **known)


def _missing(name: str, flank: str, reason: str) -> Section:
    return None, json_text({"design": name, "flank": flank, "reason": reason}), reason


def _reported(found: ContactReport | OperationReport | SlidingReport | SensitivityReport) -> Section:
    return found, json_text(found.data()), found.reason


def _operation(name: str, design: Design, flank: str, *_: object) -> Section:
    if fault := first_contact_fault(design):
        return _missing(name, flank, f"no first contact: {fault}")
    return _reported(operation_report(name, design, flank, CYCLE_POSITIONS, HARMONICS, FILM))


def _tolerances(
    name: str, design: Design, settings: Settings, progress: Progress, executor: Executor | None
) -> dict[str, Section]:
    """Study the tolerances of both flanks; those that were not given may not suit the design."""
    progress("tolerance")
    done = 0

    def solved(cases: int) -> None:
        """Tell the progress of the units that so many more mountings make whole."""
        nonlocal done
        units = range(-(-done // UNIT), -(-(done := done + cases) // UNIT))
        for _ in units:
            progress("tolerance")

    how: dict[str, Any] = {"seed": settings.seed, "progress": solved, "executor": executor}
    try:
        studies = tolerance_studies(design, settings.tolerances, FLANKS, settings.cases, **how)
    except ValueError as error:
        if settings.given:
            raise
        return {flank: _missing(name, flank, str(error)) for flank in FLANKS}
    return {study.flank: _studied(name, design, study) for study in studies}


def _studied(name: str, design: Design, study: ToleranceStudy) -> Section:
    none = None if study.mountings.solved.any() else f"no mounting has a path on the {study.flank} flanks"
    return study, json_text(ToleranceReport(name, design, study).data()), none


def _matrices(name: str, design: Design, settings: Settings, progress: Progress) -> dict[str, Section]:
    """Find patterns of both flanks under two errors."""
    progress("matrix")
    found: dict[str, Section] = {}
    last: PatternMatrix | None = None
    for flank in FLANKS:
        try:
            if fault := first_contact_fault(design):
                raise ValueError(f"no first contact: {fault}")
            last = pattern_matrix(design, OVER, flank, sizes=settings.sizes, separation=FILM, like=last)
        except ValueError as error:
            found[flank] = _missing(name, flank, str(getattr(error, "reason", error)))
            continue
        report = PatternMatrixReport(name, last)
        found[flank] = last, json_text(report.data()), report.reason
    return found


def _hertz(name: str, design: Design, flank: str, settings: Settings, *_: object) -> Section:
    if reason := reason_of(path_of_contact(design, flank, 2)):
        return _missing(name, flank, reason)
    found = contact_report(name, design, flank, POSITIONS, certified=False, load=settings.load)
    return found, json_text(found.data()["hertz"]), None


def _pattern(name: str, design: Design, flank: str, *_: object) -> Section:
    try:
        found = pattern_report(name, design, flank, FILM)
    except ValueError as error:
        return _missing(name, flank, str(getattr(error, "reason", error)))
    return found, json_text(found.data()), None


SECTIONS: dict[str, Callable[[str, Design, str, Settings], Section]] = {
    "tca": lambda name, design, flank, *_: _reported(contact_report(name, design, flank, POSITIONS)),
    "operation": _operation,
    "sliding": lambda name, design, flank, *_: _reported(sliding_report(name, design, flank, POSITIONS)),
    "sensitivity": lambda name, design, flank, *_: _reported(sensitivity_report(name, design, flank)),
    "pattern": _pattern,
    "hertz": _hertz,
}
"""Of one flank pair, in the order in which they are computed, besides those of both at once."""


def failed_mountings(studies: list[ToleranceStudy | None]) -> dict[str, int]:
    """Count the mountings, drawn the same for both flanks, that fail: without contact on either flank, with a
    contact ratio below 1 on one, or jammed; of each kind, too. Nothing without studies."""
    known = [study.mountings for study in studies if study is not None]
    if not known:
        return {}
    lost = np.any([~one.solved for one in known], axis=0)
    short = np.any([one.solved & (one.contact_ratio < 1.0) for one in known], axis=0)
    jammed = np.any([one.jammed for one in known], axis=0)
    masks = {"failed": lost | short | jammed, "without_contact": lost, "contact_ratio_below_1": short}
    counts = {name: int(np.count_nonzero(mask)) for name, mask in {**masks, "jammed": jammed}.items()}
    return {"cases": int(lost.size), **counts}


def _cloud(design: Design, study: ToleranceStudy) -> ContactPath:
    """Give paths of the first mountings of a study."""
    errors, names = study.mountings.errors[:CLOUD], study.tolerances.names
    return path_of_contact(mounted(design, errors, names), study.flank, CLOUD_POINTS)
