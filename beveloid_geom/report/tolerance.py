"""Report of `tolerance`: paths of contact of random mountings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.cycle_statistics import CycleStatistics
from ..analysis.mountings import PLACES
from ..analysis.tolerance import LEAST_KNOWN_SHARE, QUANTILE_SHARES, Tolerances, ToleranceStudy
from ..arrays import MEMBERS, Mask
from ..contact.ellipse import MARKING_SEPARATION_MM
from ..contact.parallel.lines import is_line_contact
from ..design.ends import limit_words
from ..design.model import Design
from ..findings.diagnostics import NOTE, UNKNOWN, WARNING, Remark, remarks_data
from ..findings.path import batch_reason
from ..operation.backlash_by_tangency import Tangency
from ..status import FirstStatus, Limit, Status
from .columns import heading, known_number, label, labelled_lines, scaled
from .result import ResultReport, Rows, name_in_files, picked, plain, status_name
from .text import line, mounted_lines, remark_lines, status_words, unit_of

SHOWN_SHARES = (0.01, 0.05, 0.5, 0.95, 0.99)
"""Quantiles of the text."""
FACE_ENDS = [limit for limit in Limit if limit.limit in ("toe", "heel")]


@dataclass(frozen=True, eq=False)
class ToleranceReport(ResultReport[ToleranceStudy]):
    """Tolerance study of a single design."""

    needs_assembly = True

    @property
    def reason(self) -> str | None:
        """Reason why no mounting has a path, None if one has."""
        return batch_reason(
            f"no mounting has a path on the {self.flank} flanks", self.result.mountings.status
        )

    def values(self) -> dict[str, Any]:
        """Return the counts and quantiles of the mountings."""
        study, tolerances = self.result, self.result.tolerances
        counts = study.limit_counts().items()
        return {
            "tolerances": picked(tolerances, *tolerances.names, "distribution", "sigmas"),
            **picked(study, "cases", "seed"),
            "nominal": _nominal(study),
            "status": {status_name(status): count for status, count in study.status_counts().items()},
            "limits_changed": study.limits_changed(),
            "limits": [
                {"enter": limit_name(enter), "leave": limit_name(leave), "count": count}
                for (enter, leave), count in counts
            ],
            "contact_ratio_below_1": below_one(study),
            **jam_counts(study),
            **_cycle_data(study),
            "quantiles": {"share": QUANTILE_SHARES, **study.quantiles()},
            **remarks_data(tolerance_remarks(self.design, study)),
        }

    def rows(self) -> Rows:
        """Return the mountings."""
        mountings, names = self.result.mountings, self.result.tolerances.names
        enter, leave = ([limit_name(code) for code in codes] for codes in mountings.limit.T)
        places = {
            f"{name}_{place}": getattr(mountings, name)[:, k]
            for name in ("pinion_z", "pinion_r", "gear_z", "gear_r")
            for k, place in enumerate(PLACES)
        }
        cycles = self.result.cycles
        return {
            **{f"{name}_error": errors for name, errors in zip(names, mountings.errors.T, strict=True)},
            **picked(mountings, "status"),
            **{"enter": enter, "leave": leave},
            **picked(mountings, "pieces", "contact_ratio", "peak_to_peak"),
            **places,
            "normal_backlash": mountings.normal_backlash,
            "tangency": plain(mountings.tangency, Tangency),
            "jammed": mountings.jammed,
            **({} if cycles is None else _to_all(cycles, mountings.status.size)),
        }

    def summary(self) -> str:
        """Return counts and quantiles of the mountings."""
        study, flank = self.result, self.result.flank
        text = f"Tolerance study of {self.name}, {flank} flanks: {study.cases} mountings, seed {study.seed}\n"
        text += mounted_lines(self.design) + line("tolerances", _distribution_words(study))
        text += remark_lines(tolerance_remarks(self.design, study))
        counts = (
            f"{status_words(status)} {_percent(count, study.cases)}"
            for status, count in study.status_counts().items()
            if count
        )
        text += line("mountings", ", ".join(counts)) + line("jammed", _jam_words(study))
        if study.cycles:
            text += line("in operation", _cycle_words(study.cycles))
            text += line("patterns", _pattern_words(self.design, study.cycles))
        if self.reason:
            return text
        text += line(
            "ends of the path",
            "at other limits of the flanks than in the design in"
            f" {_percent(study.limits_changed(), study.cases)} of the mountings",
        )
        text += line("path", _limit_words(self.design, study))
        text += line(
            "contact ratio", f"below 1 in {_percent(below_one(study), study.cases)} of the mountings"
        )
        return f"{text}\n{_quantile_lines(study)}"


def _to_all(cycles: CycleStatistics, count: int) -> dict[str, Any]:
    """Return columns of `count` mountings; those without a mesh cycle have empty cells."""
    missing = count - cycles.status.size
    status = plain(cycles.status, FirstStatus)
    numbers = {name: np.append(x, np.full(missing, np.nan)) for name, x in cycles.quantities().items()}
    each = zip(cycles.pattern_ends, cycles.pattern_known, strict=True)
    ends = [_ends_in_files(at) if known else "" for at, known in each]
    return {"operation_status": status + [""] * missing, **numbers, "pattern_ends_at": ends + [""] * missing}


def _ends_in_files(at: Mask) -> str:
    """Return the names of the edges (8) at which a pattern ends, such as 'pinion_tip+gear_tip'."""
    return "+".join(name_in_files(limit) for limit in Limit if at[limit]) or "none"


def pattern_counts(cycles: CycleStatistics) -> dict[str, Any]:
    """Return the numbers of mountings with a known pattern by the edges at which their patterns end."""
    ends = cycles.pattern_ends[cycles.pattern_known]
    return {
        "known": len(ends),
        "ends_at": {name_in_files(limit): int(np.count_nonzero(ends[:, limit])) for limit in Limit},
        "toe_or_heel": int(np.count_nonzero(ends[:, FACE_ENDS].any(axis=1))),
        "nowhere": int(np.count_nonzero(~ends.any(axis=1))),
    }


def edge_contact_count(cycles: CycleStatistics) -> int:
    """Return the number of mountings with edge contact in the mesh cycle."""
    return int(np.count_nonzero(cycles.edge_share[cycles.solved] > 0.0))


def _cycle_data(study: ToleranceStudy) -> dict[str, Any]:
    """Return the entries of JSON on the mesh cycles, empty without any."""
    cycles, nominal = study.cycles, study.nominal_cycles
    if cycles is None or nominal is None:
        return {}
    count = np.bincount(cycles.status, minlength=len(FirstStatus))
    return {
        "operation": {
            "cases": cycles.status.size,
            "status": {name_in_files(status): int(count[status]) for status in FirstStatus},
            "edges_carry": edge_contact_count(cycles),
            "pattern": {"separation": MARKING_SEPARATION_MM, **pattern_counts(cycles)},
            "nominal": {
                **{name: float(value[0]) for name, value in nominal.quantities().items()},
                "pattern_ends_at": _ends_in_files(nominal.pattern_ends[0]) if nominal.solved[0] else None,
            },
        }
    }


def _cycle_words(cycles: CycleStatistics) -> str:
    count = cycles.status.size
    text = f"edges touch during a part of the mesh cycle in {_percent(edge_contact_count(cycles), count)}"
    text += f" of the first {count} mountings"
    lost = count - int(np.count_nonzero(cycles.solved))
    return f"{text}; not known in {_percent(lost, count)}" if lost else text


def _pattern_words(design: Design, cycles: CycleStatistics) -> str:
    """Return the shares of patterns that end at the edges of a flank."""
    counts = pattern_counts(cycles)
    if not (known := counts["known"]):
        return "not known"
    words = f"for marking compound of {1e3 * MARKING_SEPARATION_MM:g} um, they reach an end of a face in"
    words += f" {_percent(counts['toe_or_heel'], known)} of the {known} mountings that move the path furthest"
    ends = counts["ends_at"]
    at = {limit_words(design, limit): ends[name_in_files(limit)] for limit in Limit}
    at["no edge"] = counts["nowhere"]
    shares = (f"{name} {_percent(count, known)}" for name, count in at.items() if count)
    return f"{words}; edges reached: {', '.join(shares)}"


def limit_name(limit: int) -> str:
    """Return the name of a limit in files, such as 'pinion_tip'; empty without a path."""
    return name_in_files(Limit(int(limit))) if limit >= 0 else ""


def _nominal(study: ToleranceStudy) -> dict[str, Any]:
    """Return the results of the design without random errors."""
    quantities = {name: float(value[0]) for name, value in study.nominal.quantities().items()}
    enter, leave = (limit_name(code) or None for code in study.nominal.limit[0])
    return {"status": status_name(study.nominal.status[0]), "enter": enter, "leave": leave, **quantities}


def below_one(study: ToleranceStudy) -> int:
    """Return the number of mountings with a path and a contact ratio below 1."""
    return int(np.count_nonzero(study.mountings.contact_ratio[study.mountings.solved] < 1.0))


def tolerance_remarks(design: Design, study: ToleranceStudy) -> tuple[Remark, ...]:
    """Return remarks on lost contact, failed calculations, edge contact and mountings that jam.

    A remark on less than 0.27 % of the mountings is a note: this share of a normal distribution lies outside
    a tolerance of three standard deviations."""
    warning_share = 0.0027
    words = f"with the tolerances {_distribution_words(study)}"
    lead = f"{study.flank} flanks: {{}}"
    mountings = study.mountings
    failed = np.isin(mountings.status, (Status.NOT_CONVERGED, Status.UNDEFINED))
    faces = np.isin(mountings.limit, FACE_ENDS).any(axis=1)
    jammed = "{} of mountings cannot be assembled, judged by the backlash of the flanks without edge contact"
    counts = [
        (f"{lead} of mountings have no contact", ~mountings.solved & ~failed, WARNING),
        (f"{lead} of mountings could not be computed", failed, UNKNOWN),
        (jammed, mountings.jammed, WARNING),  # does not depend on the driving flanks
    ]
    if not is_line_contact(design, study.flank):  # lines of contact always reach the ends of the face
        reach = "of mountings have contact that reaches an end of a face"
        counts.append((f"{lead} {reach}", faces & mountings.solved, WARNING))
    if (cycles := study.cycles) is not None:
        first = f"{lead} of the first {cycles.status.size} mountings"
        carried = cycles.solved & (cycles.edge_share > 0.0)
        counts.append((f"{first} have edge contact during a part of the mesh cycle", carried, WARNING))
        ends = cycles.pattern_ends[cycles.pattern_known]
        patterns = np.asarray(ends[:, FACE_ENDS].any(axis=1) if ends.size else [False])
        furthest = f"{lead} of the {len(ends)} mountings that move the path furthest"
        counts.append((f"{furthest} have a contact pattern that reaches an end of a face", patterns, NOTE))
        counts.append((f"{first} have a mesh cycle that could not be computed", ~cycles.solved, UNKNOWN))
    remarks = []
    for text, mask, level in counts:
        if share := float(np.mean(mask)):
            level = level if share >= warning_share else NOTE
            remarks.append(Remark(level, f"{text.format(f'{100.0 * share:.3g} %')}, {words}"))
    return tuple(remarks)


def jam_counts(study: ToleranceStudy) -> dict[str, int]:
    """Return the numbers of mountings that cannot be assembled and of mountings with unknown backlash.

    The interference is certain if the tangencies of both sides lie on the faces (`jammed_for_sure`)."""
    mountings = study.mountings
    certain = mountings.jammed & (mountings.tangency == Tangency.TOUCHES)
    unknown = mountings.tangency == Tangency.UNKNOWN
    masks = {"jammed": mountings.jammed, "jammed_for_sure": certain, "backlash_unknown": unknown}
    return {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}


def _jam_words(study: ToleranceStudy) -> str:
    """Return the share of mountings that cannot be assembled, and how certain it is."""
    counts = jam_counts(study)
    jammed, certain, unknown = (_percent(count, study.cases) for count in counts.values())
    if counts["backlash_unknown"] == study.cases:
        return "not known, because the backlash of no mounting follows from its paths of contact"
    text = f"not known for {unknown} of the mountings; " if counts["backlash_unknown"] else ""
    text += f"{jammed} of the mountings cannot be assembled, judged by the backlash of the flanks"
    text += " without edge contact"
    if (study.mountings.tangency == Tangency.ESTIMATE).any():
        text += "; an estimate, because negative relative curvature or tips near fillets reduce the backlash"
    if counts["jammed_for_sure"] < counts["jammed"]:
        text += (
            f"; certain for {certain} of the mountings; edge contact may change the backlash of the others"
        )
    return text


def tolerance_words(tolerances: Tolerances) -> str:
    """Return the sizes of tolerances, in mm and deg."""
    sizes = dict(zip(tolerances.names, tolerances.values().tolist(), strict=True))
    return ", ".join(
        f"{name.replace('_', ' ')} {scaled(f'{name}_error', size):g} {unit_of(name)}"
        for name, size in sizes.items()
    )


def _distribution_words(study: ToleranceStudy) -> str:
    """Return sizes and distribution of the tolerances of a study."""
    tolerances, words = study.tolerances, tolerance_words(study.tolerances)
    spread = f", each tolerance is {tolerances.sigmas:g} sigma" if tolerances.distribution == "normal" else ""
    return f"{words}; {tolerances.distribution} distribution{spread}"


def _percent(count: int, cases: int) -> str:
    """Return a share of the mountings in percent, with the decimals that distinguish single mountings; 0 and
    100 % have none."""
    decimals = 0 if count in (0, cases) else max(math.ceil(math.log10(cases)) - 2, 0)
    return f"{100.0 * count / cases:.{decimals}f} %"


def _limit_words(design: Design, study: ToleranceStudy) -> str:
    """Return the most frequent pairs of limits at which paths enter and leave the flanks, with the printed
    names of the ends of the faces."""
    counts, shown = list(study.limit_counts().items()), 8
    words = [
        f"{limit_words(design, enter)} to {limit_words(design, leave)} {_percent(count, study.cases)}"
        for (enter, leave), count in counts[:shown]
    ]
    more = [f"{len(counts) - shown} more"] if len(counts) > shown else []
    return ", ".join(words + more)


def _quantile_lines(study: ToleranceStudy) -> str:
    """Return the table of quantiles."""
    rows = [("quantiles", ["as designed", *(f"{100.0 * share:g} %" for share in SHOWN_SHARES)])]
    nominal, spread = study.nominal.quantities(), study.quantiles(SHOWN_SHARES)
    cycle_values = study.nominal_cycles.quantities() if study.nominal_cycles else {}
    nominal |= cycle_values
    quantities = (
        *("contact_ratio", "peak_to_peak", "normal_backlash"),
        *(f"{member}_z_{place}" for member in MEMBERS for place in PLACES),
    )
    labels = {
        "cycle_peak_to_peak": "error of all teeth, arcsec",
        "film_ratio": f"contact ratio, {1e3 * MARKING_SEPARATION_MM:g} um film",
    }
    for name in (*quantities, *cycle_values):
        values = np.append(nominal[name], spread[name])
        rows.append((labels.get(name) or label(name), [known_number(name, value) for value in values]))
    text = labelled_lines(rows, label_width=28, cell_width=12)
    if few := [name for name, values in spread.items() if np.isnan(values).all()]:
        least, names = f"{100.0 * LEAST_KNOWN_SHARE:g} %", "; ".join(map(heading, few))
        text += f"no quantiles, because the values of less than {least} of the mountings are known: {names}\n"
    return text
