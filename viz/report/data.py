"""Contents of the page, computed once: results for charts, and numbers as JSON.

The JSON is identical to that of the `beveloid-geom` commands, by section and flank.
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
from beveloid_geom.analysis.tolerance import MOUNTINGS_PER_BLOCK, USUAL, ToleranceStudy, tolerance_studies
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.findings.diagnostics import NOTE, UNKNOWN, Remark, in_order
from beveloid_geom.findings.path import first_contact_fault, reason_of
from beveloid_geom.operation.backlash_by_tangency import Tangency
from beveloid_geom.operation.contact_pattern.motion import UnknownOperationError
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.report.check import check_report
from beveloid_geom.report.ease_off import EaseOffReport, ease_off_report
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.report.path import ContactReport, contact_report
from beveloid_geom.report.pattern import PatternMatrixReport, PatternReport, pattern_report
from beveloid_geom.report.result import Failure, failure_of, json_text
from beveloid_geom.report.sensitivity import SensitivityReport, sensitivity_report
from beveloid_geom.report.sliding import SlidingReport, sliding_report
from beveloid_geom.report.statements import StatementsReport
from beveloid_geom.report.tolerance import ToleranceReport, tolerance_remarks
from beveloid_geom.report.workshop.gear_data import gear_data_report
from beveloid_geom.status import NotComputed
from beveloid_geom.support.frozen_arrays import read_only
from beveloid_geom.support.process import NOT_COMPUTED
from beveloid_geom.validation.statements import is_table1, paper_statements

from ..components.motion_graph import MotionGraph, motion_graph
from ..components.paths_table import FLANKS

POSITIONS, HARMONICS = 101, 10
"""Defaults of `beveloid-geom tca` and `operation`."""
EASE_OFF_GRID = (9, 13)
"""Points along profile and face for the numbers of the ease-off."""
Progress: TypeAlias = Callable[[str], object]
Section: TypeAlias = tuple[Any, Any, str | None]
"""Result, its data as in JSON, and the reason if there is no result, otherwise None."""


@dataclass(frozen=True)
class ReportSettings:
    """Settings of the page.

    Attributes
    ----------
    tolerances : Tolerances
        Tolerances of the study.
    given : bool
        True if the user gave the tolerances.
    cases : int
        Number of mountings.
    seed : int
        Seed of the random errors.
    load : Load
        Load of a tooth pair.
    loaded : bool
        True if the user gave the load.
    """

    tolerances: Tolerances = USUAL
    given: bool = False
    cases: int = 20_000
    seed: int = 0
    load: Load = field(default_factory=lambda: Load(force=1000.0))
    loaded: bool = False

    @property
    def steps(self) -> int:
        """Number of calls of `progress` in `compute`: stages and blocks of mountings."""
        stages, stages_of_flank = 5, 6
        return stages + stages_of_flank * len(FLANKS) + -(-self.cases // MOUNTINGS_PER_BLOCK)

    @property
    def sizes(self) -> tuple[float, float] | None:
        """Largest errors of the matrix of patterns, mm and rad: the given tolerances; None for the usual ones
        if not both are given."""
        given = self.tolerances.offset, self.tolerances.shaft_angle
        return given if self.given and all(given) else None


@dataclass(frozen=True, eq=False)
class FlankResults:
    """Results of one flank pair. A result is None if it is not available; `reasons` gives the reason by
    section.

    Attributes
    ----------
    flank : str
        'right' or 'left'.
    contact : ContactReport
        Path of contact.
    study : ToleranceStudy or None
        Mountings under random errors.
    cloud : ContactPath or None
        Paths of the first mountings, batch axis first.
    reasons : dict
        Reasons of missing results by section.
    operation, sliding, sensitivity, pattern : report or None
        Results of these commands.
    hertz : ContactReport or None
        Path with Hertzian pressures.
    matrix : PatternMatrix or None
        Patterns under two errors.
    """

    flank: str
    contact: ContactReport
    study: ToleranceStudy | None
    cloud: ContactPath | None
    reasons: dict[str, str]
    operation: OperationReport | None
    sliding: SlidingReport | None
    sensitivity: SensitivityReport | None
    pattern: PatternReport | None
    hertz: ContactReport | None
    matrix: PatternMatrix | None

    @cached_property
    def motion(self) -> MotionGraph | None:
        """Transmission error of every tooth pair alone, and in operation."""
        return None if self.operation is None else read_only(motion_graph(self.operation))


@dataclass(frozen=True, eq=False)
class PageData:
    """Results by flank, ease-off of both flanks, JSON by section and flank, and all remarks in order."""

    name: str
    design: Design
    settings: ReportSettings
    flanks: dict[str, FlankResults]
    ease_off: EaseOffReport
    numbers: dict[str, Any]
    remarks: tuple[Remark, ...]

    @cached_property
    def has_path(self) -> bool:
        """True if there is a path of contact on either flank."""
        return any(results.contact.reason is None for results in self.flanks.values())

    @property
    def failures(self) -> list[Failure]:
        """Failures of the page: no contact on both flanks, failed calculations, or a pair that jams."""
        failures = []
        for results in self.flanks.values():
            contact, operation = results.contact.reason, results.operation
            if contact and (not self.has_path or isinstance(contact, NotComputed)):
                failures.append(failure_of(contact))
            elif isinstance(reason := results.reasons.get("operation"), NotComputed):
                failures.append(failure_of(reason))
            elif operation is not None:
                failures.append(operation.unknown)
        if self.has_path:  # one flank pair without contact is no failure
            failures = [each for each in failures if each and each.status == NOT_COMPUTED]
            failures.append(failure_of(None, self.design))
        return [each for each in failures if each]

    @property
    def verdict(self) -> str:
        """Level of the most severe remark; notes do not count."""
        return next((one.level for one in self.remarks if one.level != NOTE), NOTE)


def as_json(data: Any) -> Any:
    """Return data as in JSON: without arrays, NaN and enumerations."""
    return json.loads(json_text(data))


def compute(
    name: str,
    design: Design,
    settings: ReportSettings,
    progress: Progress = lambda _: None,
    executor: Executor | None = None,
) -> PageData:
    """Compute all contents for a single design.

    Parameters
    ----------
    name : str
        Name of the design.
    design : Design
        A single design.
    settings : ReportSettings
        Tolerances, load, and number of mountings.
    progress : callable
        Called with the name of each stage before it, and after each block of mountings.
    executor : Executor, optional
        Computes the mountings in other processes in the meantime.

    Returns
    -------
    PageData
        Contents of the page.

    Raises
    ------
    ValueError
        If given tolerances do not suit the design.
    """
    numbers: dict[str, Any] = {"design": as_json(asdict(design))}
    for name_of, member in (("pinion", design.pinion), ("gear", design.gear)):
        coefficients = {f"parabola_{flank}": float(member.tool.parabola_of(flank)) for flank in FLANKS}
        numbers["design"][name_of]["tool"] |= coefficients
    with ThreadPoolExecutor(1) as thread:
        study = partial(_tolerances, name, design, settings, progress, executor)
        studied = study if executor is None else thread.submit(study).result
        progress("check")
        checked = check_report(name, design)
        numbers["check"] = as_json(checked.data())
        numbers["gear_data"] = as_json(gear_data_report(name, design).data())
        sections = {flank: _sections(name, design, flank, settings, progress) for flank in FLANKS}
        matrices = _matrices(name, design, settings, progress)
        progress("ease-off")
        eased = ease_off_report(name, design, (21, 31))  # grid for the contour lines
        numbers["ease_off"] = as_json(ease_off_report(name, design, EASE_OFF_GRID).data())
        progress("statements")
        if is_table1(design):
            judged = [one for flank in FLANKS for one in paper_statements(design, flank)]
            numbers["statements"] = as_json(StatementsReport(name, design, judged).data())
        tolerances = studied()
    for flank, results in sections.items():
        results |= {"tolerance": tolerances[flank], "matrix": matrices[flank]}
    for section in sections[FLANKS[0]]:
        numbers[section] = {flank: results[section][1] for flank, results in sections.items()}
    if design.measured:
        progress("nominal flanks")
        nominal = design.nominal()
        for section in ("tca", "operation", "sliding"):
            solved = {flank: SECTIONS[section](name, nominal, flank, settings) for flank in FLANKS}
            numbers[section]["nominal"] = {flank: data for flank, (_, data, _) in solved.items()}
        patterns = numbers["pattern"]
        patterns["nominal"] = {flank: patterns[flank].get("nominal") for flank in FLANKS}
    flanks = {flank: _results_of(design, flank, results) for flank, results in sections.items()}
    numbers["mountings"] = failed_mountings([results.study for results in flanks.values()])
    studies = [one.study for one in flanks.values() if one.study and "tolerance" not in one.reasons]
    shares = [remark for study in studies for remark in tolerance_remarks(design, study)]
    paths = [remark for results in flanks.values() for remark in results.contact.remarks]
    cycles = [remark for one in flanks.values() for remark in _cycle_remarks(one)]
    remarks = in_order([*shares, *checked.remarks, *paths, *cycles])
    return PageData(name, design, settings, flanks, eased, numbers, remarks)


def _sections(
    name: str, design: Design, flank: str, settings: ReportSettings, progress: Progress
) -> dict[str, Section]:
    """Compute the SECTIONS of one flank pair. A section that fails does not affect the others."""
    results: dict[str, Section] = {}
    for section, solve in SECTIONS.items():
        progress(f"{section}, {flank}")
        results[section] = solve(name, design, flank, settings)
    if (reason := results["pattern"][2]) is not None:
        results["pattern"] = _missing(name, flank, results["operation"][2] or reason)
    return results


def _results_of(design: Design, flank: str, sections: dict[str, Section]) -> FlankResults:
    """Combine the sections of one flank pair."""
    results = {section: result for section, (result, *_) in sections.items()}
    reasons = {section: reason for section, (*_, reason) in sections.items() if reason}
    contact, study = results.pop("tca"), results.pop("tolerance")
    known = {section: None if section in reasons else result for section, result in results.items()}
    cloud = None if "tolerance" in reasons else _cloud(design, study)
    return FlankResults(flank, contact, study, cloud, reasons, **known)


def _cycle_remarks(results: FlankResults) -> tuple[Remark, ...]:
    """Return remarks on the operation of a flank pair, and on sections that could not be computed."""
    known = () if results.operation is None else results.operation.remarks
    failed = {reason for reason in results.reasons.values() if isinstance(reason, NotComputed)}
    return (*known, *(Remark(UNKNOWN, f"{results.flank} flanks: {reason}") for reason in sorted(failed)))


def _missing(name: str, flank: str, reason: str) -> Section:
    return None, as_json({"design": name, "flank": flank, "reason": reason}), reason


def _reported(report: ContactReport | OperationReport | SlidingReport | SensitivityReport) -> Section:
    return report, as_json(report.data()), report.reason


def _operation(name: str, design: Design, flank: str, *_: object) -> Section:
    rolls = 121
    if fault := first_contact_fault(design):
        return _missing(name, flank, fault)
    return _reported(operation_report(name, design, flank, rolls, HARMONICS, MARKING_SEPARATION_MM))


def _tolerances(
    name: str, design: Design, settings: ReportSettings, progress: Progress, executor: Executor | None
) -> dict[str, Section]:
    """Compute the tolerance studies of both flanks. Usual tolerances may not suit the design."""
    progress("tolerance")
    done = 0

    def solved(cases: int) -> None:
        """Report the blocks completed by `cases` more mountings."""
        nonlocal done
        units = range(-(-done // MOUNTINGS_PER_BLOCK), -(-(done := done + cases) // MOUNTINGS_PER_BLOCK))
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
    return study, as_json(ToleranceReport(name, design, study).data()), none


def _matrices(name: str, design: Design, settings: ReportSettings, progress: Progress) -> dict[str, Section]:
    """Compute the patterns of both flanks under two errors."""
    progress("matrix")
    over = ("offset", "shaft_angle")  # errors of rows and columns
    results: dict[str, Section] = {}
    last: PatternMatrix | None = None
    for flank in FLANKS:
        try:
            if fault := first_contact_fault(design):
                raise UnknownOperationError(fault)
            last = pattern_matrix(
                design, over, flank, sizes=settings.sizes, separation=MARKING_SEPARATION_MM, like=last
            )
        except ValueError as error:
            results[flank] = _missing(name, flank, getattr(error, "reason", str(error)))
            continue
        report = PatternMatrixReport(name, last.design, last)
        results[flank] = last, as_json(report.data()), report.reason
    return results


def _hertz(name: str, design: Design, flank: str, settings: ReportSettings, *_: object) -> Section:
    if reason := reason_of(path_of_contact(design, flank, 2)):
        return _missing(name, flank, reason)
    report = contact_report(name, design, flank, POSITIONS, certified=False, load=settings.load)
    return report, as_json(report.data()["hertz"]), None


def _pattern(name: str, design: Design, flank: str, *_: object) -> Section:
    try:
        report = pattern_report(name, design, flank, MARKING_SEPARATION_MM)
    except ValueError as error:
        return _missing(name, flank, getattr(error, "reason", str(error)))
    return report, as_json(report.data()), None


SECTIONS: dict[str, Callable[[str, Design, str, ReportSettings], Section]] = {
    "tca": lambda name, design, flank, *_: _reported(contact_report(name, design, flank, POSITIONS)),
    "operation": _operation,
    "sliding": lambda name, design, flank, *_: _reported(sliding_report(name, design, flank, POSITIONS)),
    "sensitivity": lambda name, design, flank, *_: _reported(sensitivity_report(name, design, flank)),
    "pattern": _pattern,
    "hertz": _hertz,
}
"""Sections of one flank pair in the order of computation, without those of both flanks together."""


def failed_mountings(studies: list[ToleranceStudy | None]) -> dict[str, int]:
    """Count the mountings that fail: without contact on a flank, with a contact ratio below 1, or jammed.

    Both flanks have the same random errors. The counts are given together and for each kind, with the number
    of other mountings of which it is not known whether they jam (`jam_unknown`); empty without studies.
    """
    known = [study.mountings for study in studies if study is not None]
    if not known:
        return {}
    without_path = np.any([~one.solved for one in known], axis=0)
    short = np.any([one.solved & (one.contact_ratio < 1.0) for one in known], axis=0)
    jammed = np.any([one.jammed for one in known], axis=0)
    kinds = {"without_contact": without_path, "contact_ratio_below_1": short, "jammed": jammed}
    masks = {"failed": np.any(list(kinds.values()), axis=0)} | kinds
    unknown = np.any([one.tangency == Tangency.UNKNOWN for one in known], axis=0)
    masks["jam_unknown"] = unknown & ~masks["failed"]
    counts = {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}
    return {"cases": int(without_path.size), **counts}


def _cloud(design: Design, study: ToleranceStudy) -> ContactPath:
    """Return the paths of the first mountings of a study."""
    # Number of mountings whose paths are drawn, and positions per path.
    cloud, cloud_points = 240, 9
    errors, names = study.mountings.errors[:cloud], study.tolerances.names
    return path_of_contact(mounted(design, errors, names), study.flank, cloud_points)
