"""A tolerance study: paths of contact of mountings drawn at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.running import Running
from ..analysis.tolerance import PLACES, SHARES, Tolerances, ToleranceStudy
from ..arrays import Mask
from ..contact.ellipse import MARKING_SEPARATION
from ..design.model import Design
from ..findings.remarks import NOTE, WARNING, Remark, remarks_data
from ..operation.backlash_by_tangency import Tangency
from ..status import FirstStatus, Limit
from .columns import label, number, scaled
from .result import Rows
from .words import (
    head_data,
    line,
    mounted_lines,
    name_in_files,
    remark_lines,
    status_name,
    status_words,
    unit_of,
)

SHOWN = (
    *("contact_ratio", "peak_to_peak", "normal_backlash"),
    *(f"{member}_z_{place}" for member in ("pinion", "gear") for place in PLACES),
)
"""Quantities of the text."""
SHOWN_SHARES = (0.01, 0.05, 0.5, 0.95, 0.99)
SHOWN_LIMITS = 8
"""Pairs of limits that a text names."""
LOST_SHARE = 0.0027
"""Share of mountings without contact from which it is a warning: so many of a normal distribution lie
outside a tolerance of three standard deviations anyway."""


@dataclass(frozen=True, eq=False)
class ToleranceReport:
    """The `study` of a single design."""

    name: str
    design: Design
    study: ToleranceStudy

    @property
    def reason(self) -> str | None:
        """Why there is nothing to be seen, None if some mounting has a path."""
        none = f"no mounting has a path on the {self.study.flank} flanks"
        return None if self.study.mountings.solved.any() else none

    @property
    def failure(self) -> str | None:
        """Why there is no contact."""
        return f"No contact: {self.reason}" if self.reason else None

    def data(self) -> dict[str, Any]:
        """Give what the mountings come to."""
        study, own = self.study, self.study.tolerances
        counts = study.limit_counts().items()
        data = {
            **head_data(self.name, self.design, study.flank),
            "tolerances": {name: getattr(own, name) for name in (*own.names, "distribution", "sigmas")},
            "cases": study.cases,
            "seed": study.seed,
            "nominal": _nominal(study),
            "status": {status_name(status): count for status, count in study.status_counts().items()},
            "limits_changed": study.limits_changed(),
            "limits": [
                {"enter": limit_name(enter), "leave": limit_name(leave), "count": count}
                for (enter, leave), count in counts
            ],
            "contact_ratio_below_1": below_one(study),
            **jam_counts(study),
            **_running_data(study),
            "quantiles": {"share": SHARES, **study.quantiles()},
            **remarks_data(tolerance_remarks(study)),
        }
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the mountings."""
        found = self.study.mountings
        limits = ([limit_name(code) for code in codes] for codes in found.limit.T)
        places = {
            f"{name}_{place}": getattr(found, name)[:, k]
            for name in ("pinion_z", "pinion_r", "gear_z", "gear_r")
            for k, place in enumerate(PLACES)
        }
        running = self.study.running
        in_operation = {} if running is None else _to_all(running, found.status.size)
        return {
            **dict(
                zip((f"{name}_error" for name in self.study.tolerances.names), found.errors.T, strict=True)
            ),
            "status": [status_name(code) for code in found.status],
            **dict(zip(("enter", "leave"), limits, strict=True)),
            **{name: getattr(found, name) for name in ("pieces", "contact_ratio", "peak_to_peak")},
            **places,
            "normal_backlash": found.normal_backlash,
            "tangency": [name_in_files(Tangency(int(code))) for code in found.tangency],
            "jammed": found.jammed.astype(int),
            **in_operation,
        }

    def summary(self) -> str:
        """Write counts and quantiles of the mountings."""
        study, flank = self.study, self.study.flank
        text = f"Tolerance study of {self.name}, {flank} flanks: {study.cases} mountings, seed {study.seed}\n"
        text += mounted_lines(self.design) + line("tolerances", _tolerance_words(study))
        text += remark_lines(tolerance_remarks(study))
        counts = (
            f"{status_words(status)} {_percent(count, study.cases)}"
            for status, count in study.status_counts().items()
            if count
        )
        text += line("mountings", ", ".join(counts)) + line("jammed", _jam_words(study))
        if study.running:
            text += line("in operation", _running_words(study.running))
            text += line("patterns", _pattern_words(study.running))
        if self.reason:
            return text
        text += line("limits changed", f"{_percent(study.limits_changed(), study.cases)} of the mountings")
        text += line("path", _limit_words(study))
        text += line(
            "contact ratio", f"below 1 in {_percent(below_one(study), study.cases)} of the mountings"
        )
        return f"{text}\n{_quantile_lines(study)}"


def _to_all(running: Running, count: int) -> dict[str, Any]:
    """Give columns of `count` mountings, empty for those that were not studied in operation."""
    rest = count - running.status.size
    status = [name_in_files(FirstStatus(int(code))) for code in running.status]
    numbers = {name: np.append(x, np.full(rest, np.nan)) for name, x in running.quantities().items()}
    each = zip(running.pattern_ends, running.solved, strict=True)
    ends = [_ends_in_files(at) if known else "" for at, known in each]
    return {"operation_status": status + [""] * rest, **numbers, "pattern_ends_at": ends + [""] * rest}


def _ends_in_files(at: Mask) -> str:
    """Name the edges (8) at which a pattern ends, as 'pinion_tip+gear_tip'."""
    return "+".join(name_in_files(limit) for limit in Limit if at[limit]) or "none"


def pattern_counts(running: Running) -> dict[str, Any]:
    """Count the mountings of which the mesh cycle is known, those of them whose patterns end at each edge of
    both flanks, at some toe or heel, and at no edge."""
    ends = running.pattern_ends[running.solved]
    faces = [limit for limit in Limit if limit.limit in ("toe", "heel")]
    return {
        "known": len(ends),
        "ends_at": {name_in_files(limit): int(np.count_nonzero(ends[:, limit])) for limit in Limit},
        "toe_or_heel": int(np.count_nonzero(ends[:, faces].any(axis=1))),
        "nowhere": int(np.count_nonzero(~ends.any(axis=1))),
    }


def edges_carry(running: Running) -> int:
    """Count the mountings of which edges carry some of the mesh cycle."""
    return int(np.count_nonzero(running.edge_share[running.solved] > 0.0))


def _running_data(study: ToleranceStudy) -> dict[str, Any]:
    running, nominal = study.running, study.nominal_running
    if running is None or nominal is None:
        return {}
    count = np.bincount(running.status, minlength=len(FirstStatus))
    return {
        "operation": {
            "cases": running.status.size,
            "status": {name_in_files(status): int(count[status]) for status in FirstStatus},
            "edges_carry": edges_carry(running),
            "pattern": {"separation": MARKING_SEPARATION, **pattern_counts(running)},
            "nominal": {
                **{name: float(value[0]) for name, value in nominal.quantities().items()},
                "pattern_ends_at": _ends_in_files(nominal.pattern_ends[0]) if nominal.solved[0] else None,
            },
        }
    }


def _running_words(running: Running) -> str:
    count = running.status.size
    text = f"edges carry some of the mesh cycle in {_percent(edges_carry(running), count)}"
    text += f" of the first {count} mountings"
    lost = count - int(np.count_nonzero(running.solved))
    return f"{text}; not known in {_percent(lost, count)}" if lost else text


def _pattern_words(running: Running) -> str:
    """Say how many patterns end at an edge of a flank, and at which."""
    counts = pattern_counts(running)
    if not (known := counts["known"]):
        return "not known"
    words = f"compound of {1e3 * MARKING_SEPARATION:g} um ends at a toe or heel in"
    words += f" {_percent(counts['toe_or_heel'], known)} of these {known}"
    at = {name.replace("_", " "): count for name, count in counts["ends_at"].items()}
    at["no edge at all"] = counts["nowhere"]
    return f"{words}: {', '.join(f'{name} {_percent(count, known)}' for name, count in at.items() if count)}"


def limit_name(limit: int) -> str:
    """Name of a limit in files, as 'pinion_tip'; empty without a path."""
    return name_in_files(Limit(int(limit))) if limit >= 0 else ""


def _nominal(study: ToleranceStudy) -> dict[str, Any]:
    found = {name: float(value[0]) for name, value in study.nominal.quantities().items()}
    enter, leave = (limit_name(code) or None for code in study.nominal.limit[0])
    return {"status": status_name(study.nominal.status[0]), "enter": enter, "leave": leave, **found}


def below_one(study: ToleranceStudy) -> int:
    """Count the mountings with a path whose contact ratio is below 1."""
    return int(np.count_nonzero(study.mountings.contact_ratio[study.mountings.solved] < 1.0))


def tolerance_remarks(study: ToleranceStudy) -> tuple[Remark, ...]:
    """Say which share of the mountings has no contact on its flanks or cannot be assembled, if any."""
    words = f"with errors drawn at random within {_tolerance_words(study)}"
    lost = study.cases - int(np.count_nonzero(study.mountings.solved))
    counts = {  # the latter is of both flanks, and the same whichever drives
        f"{study.flank} flanks: {{}} of mountings have no contact": lost,
        "{} of mountings cannot be assembled, by the tangency of their flanks": jam_counts(study)["jammed"],
    }
    found = []
    for text, count in counts.items():
        level = WARNING if count >= LOST_SHARE * study.cases else NOTE
        if count:
            found.append(Remark(level, f"{text.format(f'{100.0 * count / study.cases:.3g} %')}, {words}"))
    return tuple(found)


def jam_counts(study: ToleranceStudy) -> dict[str, int]:
    """Count mountings that cannot be assembled; among them those whose tangencies lie on the faces of both
    sides, so that their teeth jam for sure; and mountings whose backlash is not known."""
    found = study.mountings
    sure = found.jammed & (found.tangency == Tangency.TOUCHES)
    unknown = found.tangency == Tangency.UNKNOWN
    masks = {"jammed": found.jammed, "jammed_for_sure": sure, "backlash_unknown": unknown}
    return {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}


def _jam_words(study: ToleranceStudy) -> str:
    counts = jam_counts(study)
    some, sure, unknown = (_percent(count, study.cases) for count in counts.values())
    text = f"{some} of the mountings cannot be assembled, by the tangency of their flanks"
    if counts["jammed_for_sure"] < counts["jammed"]:
        text += f"; {sure} surely: in the others edges carry, which may leave more or less backlash"
    return f"{text}; not known in {unknown}" if counts["backlash_unknown"] else text


def size_words(own: Tolerances) -> str:
    """Say the sizes of tolerances, in mm and deg."""
    sizes = dict(zip(own.names, own.values().tolist(), strict=True))
    return ", ".join(
        f"{name.replace('_', ' ')} {scaled(f'{name}_error', size):g} {unit_of(name)}"
        for name, size in sizes.items()
    )


def _tolerance_words(study: ToleranceStudy) -> str:
    own, words = study.tolerances, size_words(study.tolerances)
    spread = f", each {own.sigmas:g} sigma" if own.distribution == "normal" else ""
    return f"{words}; {own.distribution}{spread}"


def _percent(count: int, cases: int) -> str:
    """Write a share of the mountings, none and all of them without digits."""
    return f"{100.0 * count / cases:.3g} %" if count in (0, cases) else f"{100.0 * count / cases:.3f} %"


def _limit_words(study: ToleranceStudy) -> str:
    counts = list(study.limit_counts().items())
    words = [
        f"{enter} to {leave} {_percent(count, study.cases)}"
        for (enter, leave), count in counts[:SHOWN_LIMITS]
    ]
    more = [f"{len(counts) - SHOWN_LIMITS} more"] if len(counts) > SHOWN_LIMITS else []
    return ", ".join(words + more)


def _quantile_lines(study: ToleranceStudy) -> str:
    heads = ["as designed", *(f"{100.0 * share:g} %" for share in SHOWN_SHARES)]
    text = f"{'quantiles':<28}" + "".join(f"{head:>12}" for head in heads) + "\n"
    nominal, spread = study.nominal.quantities(), study.quantiles(SHOWN_SHARES)
    running = study.nominal_running.quantities() if study.nominal_running else {}
    nominal |= running
    for name in (*SHOWN, *running):
        values = np.append(nominal[name], spread[name])
        text += f"{label(name):<28}" + "".join(number(name, value, 12) for value in values) + "\n"
    return text
