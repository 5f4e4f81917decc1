"""A tolerance study as text: table, JSON and CSV."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..analysis.tolerance import ERROR_NAMES, PLACES, SHARES, ToleranceStudy
from ..arrays import FloatArray
from ..design.model import Design
from ..findings.remarks import NOTE, WARNING, Remark, remarks_data
from ..operation.backlash_by_tangency import Tangency
from ..pair.mounting import mounting_of
from ..status import Limit
from .path import (
    backlash_lines,
    csv_text,
    error_line,
    json_text,
    layout_data,
    layout_line,
    line,
    parabola_line,
    remark_lines,
    status_name,
)

ARCSEC = math.degrees(3600.0)
SHOWN = (
    ("contact_ratio", "contact ratio", 1.0, 6),
    ("peak_to_peak", "tr. error, arcsec", ARCSEC, 4),
    ("normal_backlash", "backlash, mm", 1.0, 4),
    ("pinion_z_enter", "pinion z enter, mm", 1.0, 3),
    ("pinion_z_middle", "pinion z middle, mm", 1.0, 3),
    ("pinion_z_leave", "pinion z leave, mm", 1.0, 3),
    ("gear_z_enter", "gear z enter, mm", 1.0, 3),
    ("gear_z_middle", "gear z middle, mm", 1.0, 3),
    ("gear_z_leave", "gear z leave, mm", 1.0, 3),
)
"""Rows of the table: quantity, label, scale, digits."""
SHOWN_SHARES = (0.01, 0.05, 0.5, 0.95, 0.99)
SHOWN_LIMITS = 8
"""Pairs of limits that a table names."""
LABEL, WIDTH = 22, 11
LOST_SHARE = 0.0027
"""Share of mountings without contact from which it is a warning: so many of a normal distribution lie
outside a tolerance of three standard deviations anyway."""


def limit_name(limit: int) -> str:
    """Name of a limit in files, as 'pinion_tip'; empty without a path."""
    return Limit(int(limit)).name.lower() if limit >= 0 else ""


def _nominal(study: ToleranceStudy) -> dict[str, Any]:
    found = {name: float(value[0]) for name, value in study.nominal.quantities().items()}
    enter, leave = (limit_name(code) or None for code in study.nominal.limit[0])
    return {"status": status_name(study.nominal.status[0]), "enter": enter, "leave": leave, **found}


def below_one(study: ToleranceStudy) -> int:
    """Mountings with a path whose contact ratio is below 1."""
    return int(np.count_nonzero(study.mountings.contact_ratio[study.mountings.solved] < 1.0))


def tolerance_remarks(study: ToleranceStudy) -> tuple[Remark, ...]:
    """Which share of the mountings has no contact on its flanks or cannot be assembled, if any."""
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


def tangency_name(code: int) -> str:
    """Name in files of what a backlash by tangency is."""
    return Tangency(int(code)).name.lower()


def jam_counts(study: ToleranceStudy) -> dict[str, int]:
    """Mountings that cannot be put together; of these such whose tangencies lie on the faces of both sides,
    so that their teeth jam for sure; and mountings whose backlash is not known."""
    found = study.mountings
    sure = found.jammed & (found.tangency == Tangency.TOUCHES)
    unknown = found.tangency == Tangency.UNKNOWN
    masks = {"jammed": found.jammed, "jammed_for_sure": sure, "backlash_unknown": unknown}
    return {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}


def tolerance_json(name: str, design: Design, study: ToleranceStudy) -> str:
    """Strict JSON of the summary of a study, mm and rad; the mountings are in its CSV."""
    data: dict[str, Any] = {
        "design": name,
        "flank": study.flank,
        **layout_data(design, mounting_of(design)),
        "parabola": {"pinion": design.pinion.tool.parabola, "gear": design.gear.tool.parabola},
        "tolerances": dict(vars(study.tolerances)),
        "cases": study.cases,
        "seed": study.seed,
        "nominal": _nominal(study),
        "status": {status_name(status): count for status, count in study.status_counts().items()},
        "limits_changed": study.limits_changed(),
        "limits": [
            {"enter": limit_name(enter), "leave": limit_name(leave), "count": count}
            for (enter, leave), count in study.limit_counts().items()
        ],
        "contact_ratio_below_1": below_one(study),
        **jam_counts(study),
        "quantiles": {"share": SHARES, **study.quantiles()},
        **remarks_data(tolerance_remarks(study)),
    }
    return json_text(data)


def tolerance_csv(study: ToleranceStudy) -> str:
    """CSV of the mountings, one a row, mm and rad, units in the header."""
    found = study.mountings
    units = ["rad" if name == "shaft_angle" else "mm" for name in ERROR_NAMES]
    header = [f"{name}_error_{unit}" for name, unit in zip(ERROR_NAMES, units, strict=True)]
    header += ["status", "enter", "leave", "pieces", "contact_ratio", "peak_to_peak_rad"]
    columns: list[list[Any]] = [*found.errors.T.tolist(), [status_name(code) for code in found.status]]
    columns += [[limit_name(code) for code in codes] for codes in found.limit.T.tolist()]
    columns += [value.tolist() for value in (found.pieces, found.contact_ratio, found.peak_to_peak)]
    for name in ("pinion_z", "pinion_r", "gear_z", "gear_r"):
        header += [f"{name}_{place}_mm" for place in PLACES]
        columns += getattr(found, name).T.tolist()
    header += ["normal_backlash_mm", "tangency", "jammed"]
    columns += [found.normal_backlash.tolist(), [tangency_name(code) for code in found.tangency]]
    columns.append(found.jammed.astype(int).tolist())
    return csv_text(header, columns)


def tolerance_table(name: str, design: Design, study: ToleranceStudy) -> str:
    """Readable summary of a study, at most 100 characters wide, in mm, deg and arc seconds."""
    text = f"Tolerance study of {name}, {study.flank} flanks: {study.cases} mountings, seed {study.seed}\n"
    text += layout_line(design, mounting_of(design)) + error_line(design.errors) + parabola_line(design)
    text += backlash_lines(design)
    text += line("tolerances", _tolerance_words(study)) + remark_lines(tolerance_remarks(study))
    counts = (
        f"{status_name(status).replace('_', ' ')} {_percent(count, study.cases)}"
        for status, count in study.status_counts().items()
        if count
    )
    text += line("mountings", ", ".join(counts)) + line("jammed", _jam_words(study))
    if not study.mountings.solved.any():
        return text
    text += line("limits changed", f"{_percent(study.limits_changed(), study.cases)} of the mountings")
    text += line("path", _limit_words(study))
    text += line("contact ratio", f"below 1 in {_percent(below_one(study), study.cases)} of the mountings")
    return f"{text}\n{_quantile_lines(study)}"


def _jam_words(study: ToleranceStudy) -> str:
    counts = jam_counts(study)
    some, sure, unknown = (_percent(count, study.cases) for count in counts.values())
    text = f"{some} of the mountings cannot be assembled, by the tangency of their flanks"
    if counts["jammed_for_sure"] < counts["jammed"]:
        text += f"; {sure} surely: in the others edges carry, which may leave more or less backlash"
    return f"{text}; not known in {unknown}" if counts["backlash_unknown"] else text


def _tolerance_words(study: ToleranceStudy) -> str:
    own = study.tolerances
    words = (
        f"offset {own.offset:g} mm, shaft angle {math.degrees(own.shaft_angle):g} deg,"
        f" pinion axial {own.pinion_axial:g} mm, gear axial {own.gear_axial:g} mm"
    )
    spread = f", each {own.sigmas:g} sigma" if own.distribution == "normal" else ""
    return f"{words}; {own.distribution}{spread}"


def _percent(count: int, cases: int) -> str:
    """A share of the mountings; none and all of them are not blurred."""
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
    lines = [f"{'quantiles':<{LABEL}}" + "".join(f"{head:>{WIDTH + 1}}" for head in heads)]
    nominal, spread = study.nominal.quantities(), study.quantiles(SHOWN_SHARES)
    for name, label, scale, digits in SHOWN:
        values: FloatArray = scale * np.append(nominal[name], spread[name])
        lines.append(f"{label:<{LABEL}}" + "".join(f"{value:z{WIDTH + 1}.{digits}f}" for value in values))
    return "\n".join(lines) + "\n"
