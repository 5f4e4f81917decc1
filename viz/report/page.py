"""Text of the page: template, charts and scripts in one HTML file.

All numbers are written by `number` from the JSON in the page, so that text and JSON agree. All text from
outside, such as names, is escaped.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.resources import files
from pathlib import PurePath
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from beveloid_geom import Design, __version__
from beveloid_geom.analysis.tolerance import QUANTILE_SHARES
from beveloid_geom.design.ends import end_names, limit_words
from beveloid_geom.design.file import BUILTINS
from beveloid_geom.findings.diagnostics import ERROR, NOTE, UNKNOWN, WARNING, quiet
from beveloid_geom.findings.path import pressure_remarks
from beveloid_geom.pair.misalignment import ERROR_NAMES, NAMES
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.sensitivity import steps_of
from beveloid_geom.report.text import modification_words, place_words, unit_of
from beveloid_geom.report.tolerance import SHOWN_SHARES
from beveloid_geom.status import Limit

from ..components.charts import ZERO_ERROR_ARCSEC, ErrorEffect
from ..components.paths_table import FLANKS, MEMBERS
from . import charts
from .cells import cell_pictures, size_decimals
from .charts import Flats
from .data import EASE_OFF_GRID, HARMONICS, POSITIONS, FlankResults, PageData
from .origin import Origin, with_options
from .picture import SHADE_COUNT
from .svg import chart_style, svg_of

NOT_KNOWN = "\u2013"
Charts = dict[str, dict[str, Markup]]
Drawn = dict[str, tuple[str, Figure]]
Row = tuple[Any, ...]
Column = tuple[Any, str, float]


def looked_up(numbers: Mapping[str, Any], key: str) -> Any:
    """Return the value in nested JSON at a key of names and indices joined by dots; None if it does not
    exist."""
    value: Any = numbers
    for part in key.split("."):
        if isinstance(value, list):
            value = value[int(part)] if int(part) < len(value) else None
        else:
            value = value.get(part) if isinstance(value, Mapping) else None
    return value


def number_text(value: float, digits: int, general: bool = False) -> str:
    """Return a number with `digits` decimals, or with `general` that many significant digits, a typographic
    minus, and no negative zero."""
    return f"{value:z.{digits}{'g' if general else 'f'}}".replace("-", "\u2212")


def short_text(value: float) -> str:
    """Return a number with at most four decimals, or as many as four significant digits need."""
    decimals = 4 if value == 0.0 else max(4, 3 - math.floor(math.log10(abs(value))))
    return number_text(value, decimals).rstrip("0").rstrip(".")


def number_of(
    numbers: Mapping[str, Any], key: str, digits: int, scale: float = 1.0, general: bool = False
) -> Markup:
    """Return the number at a key, times a scale, in an element that also holds key, scale and digits for
    tests. With `general` it is short, and the element shows all `digits` on demand."""
    value = looked_up(numbers, key)
    known = isinstance(value, (int, float)) and math.isfinite(value)
    full = number_text(value * scale, digits, general) if known else NOT_KNOWN
    text = min(full, short_text(value * scale), key=len) if known and general else full
    more = Markup(' data-full="{}" tabindex="0"').format(full) if text != full else ""
    tag = '<span class="n" data-key="{}" data-scale="{}" data-digits="{}"{}>{}</span>'
    return Markup(tag).format(key, repr(float(scale)), digits, more, text)


def script_json(data: Any) -> Markup:
    """Return strict JSON that is safe inside a script element."""
    return htmlsafe_json_dumps(data, allow_nan=False, separators=(",", ":"))


def asset(name: str) -> Markup:
    """Return one of our scripts or style sheets, safe inside its element."""
    text = files(__package__).joinpath(name).read_text(encoding="utf-8")
    return Markup(text.replace("</script", "<\\/script"))


def _drawn(
    data: PageData, results: FlankResults, flats: Flats, quantities: dict[ErrorEffect, float]
) -> Drawn:
    """Draw the charts of a flank pair that have contents; by name, with title."""
    moving = None if results.flank in without_transmission_error(data) else results.operation
    graph = results.motion if moving else None
    scattered = results if results.cloud else None
    study = results.study if scattered else None
    sensitivity_chart = partial(charts.sensitivity_chart, quantities=quantities)
    cloud_chart = partial(charts.flank_chart, flats=flats, cloud=True)
    path_chart = partial(charts.flank_chart, flats=flats)
    ease_off_chart = partial(charts.ease_off_chart, report=data.ease_off)
    over_roll = "Sliding speed and specific sliding over the pinion roll"
    by_error = "Change of path, contact ratio and transmission error under each assembly error"
    drawings: tuple[tuple[str, str, Any, Callable[[Any], Figure | None]], ...] = (
        ("path", "Path of contact, points of first contact and pattern", results, path_chart),
        ("ease-off", "Contour lines of the ease-off of the pinion", results, ease_off_chart),
        ("pressure", "Hertzian pressure over the pinion roll", results.hertz, charts.pressure_chart),
        (
            "motion",
            "Transmission error of every tooth pair alone, and in operation",
            graph,
            charts.motion_chart,
        ),
        ("error", "Transmission error over two mesh cycles", moving, charts.error_chart),
        ("spectrum", "Amplitudes of the transmission error", moving, charts.spectrum_chart),
        ("sliding", over_roll, results.sliding, charts.sliding_chart),
        ("sensitivity", by_error, results.sensitivity if quantities else None, sensitivity_chart),
        ("cloud", "Paths of contact under random errors", scattered, cloud_chart),
        ("ratio", "Spread of the contact ratio under random errors", study, charts.ratio_chart),
    )
    drawn = {}
    for name, title, result, draw in drawings:
        if result is not None and (chart := draw(result)) is not None:
            drawn[name] = title, chart
    return drawn


def draw_charts(data: PageData) -> Charts:
    """Draw the charts by flank and name, without those that have no contents or are zero."""
    # Charts with the same vertical limits for both flanks.
    same_heights = ("pressure", "error", "spectrum", "sliding")
    with chart_style():
        flats = charts.flats_of(data.design)
        quantities = charts.changing([one.sensitivity for one in data.flanks.values() if one.sensitivity])
        drawn = {flank: _drawn(data, results, flats, quantities) for flank, results in data.flanks.items()}
        for name in same_heights:
            charts.same_heights([of[name][1] for of in drawn.values() if name in of])
        return {
            flank: {
                name: Markup(svg_of(chart, f"{name}-{flank}", f"{title}, {flank} flanks"))
                for name, (title, chart) in of.items()
            }
            for flank, of in drawn.items()
        }


def without_transmission_error(data: PageData) -> list[str]:
    """Return the flanks whose transmission error is zero within rounding."""
    return [
        flank
        for flank, results in data.flanks.items()
        if results.operation is not None
        and ARCSEC * float(results.operation.cycle.peak_to_peak) < ZERO_ERROR_ARCSEC
    ]


def key_of(path: str, place: str, peaks: Mapping[str, int]) -> str:
    """Return the key of a table cell. The place of the column replaces the * of the path of the row, or the
    other way round; @ is the position of the largest pressure."""
    key = path.replace("*", place) if "*" in path else place.replace("*", path)
    return key.replace("@", str(peaks.get(place, 0)))


def parted(
    design: Design,
    numbers: Mapping[str, Any],
    peaks: Mapping[str, int],
    rows: Sequence[Row],
    columns: Sequence[Column],
) -> tuple[list[tuple[str, str, list[Markup | str]]], dict[str, list[str]]]:
    """Return the rows of a table, and the labels of rows that are zero or unknown in all columns.

    Parameters
    ----------
    design : Design
        The pair.
    numbers : mapping
        JSON of the page.
    peaks : mapping
        Position of the largest pressure by flank.
    rows : sequence of tuple
        Label, path, digits (None for the name of a limit), unit, scale, and True for significant digits.
    columns : sequence of tuple
        Heading, place and scale.

    Returns
    -------
    rows : list of tuple
        Label, unit and cells.
    left : dict
        Labels of rows that are zero within rounding, and of rows that are unknown.
    """
    row_defaults: Row = (None, None, None, "", 1.0, False)
    shown: list[tuple[str, str, list[Markup | str]]] = []
    left: dict[str, list[str]] = {"Zero": [], "Not known": []}
    for row in rows:
        label, path, digits, unit, scale, general = (*row, *row_defaults[len(row) :])
        cells = [(key_of(path, place, peaks), scale * column_scale) for _, place, column_scale in columns]
        values = [looked_up(numbers, key) for key, _ in cells]
        if all(value is None for value in values):
            left["Not known"].append(label)
        elif all(
            isinstance(value, (int, float)) and abs(value * scale) < ZERO_ERROR_ARCSEC for value in values
        ):
            left["Zero"].append(label)
        elif digits is None:
            shown.append((label, unit, [_limit_words(design, value) for value in values]))
        else:
            shown.append((label, unit, [number_of(numbers, key, digits, by, general) for key, by in cells]))
    return shown, left


def _limit_words(design: Design, end: Any) -> str:
    """Return the printed name of a limit that is given as in JSON."""
    return limit_words(design, Limit[f"{end['member']}_{end['limit']}".upper()]) if end else NOT_KNOWN


def peaks_of(data: PageData) -> dict[str, int]:
    """Return by flank the position of the largest pressure along the path; 0 without pressures."""
    pressed = {flank: one.hertz.pressed for flank, one in data.flanks.items() if one.hertz is not None}
    pressures = {flank: np.nan_to_num(one.pressure) for flank, one in pressed.items() if one is not None}
    return {flank: int(pressures[flank].argmax()) if flank in pressures else 0 for flank in data.flanks}


def with_code(text: str, design: str) -> Markup:
    """Return text with the parts in backticks as code, and commands with the arguments of the `design`."""
    parts = [escape(part) for part in text.split("`")]
    commands = (f"{part} {design}" if part.startswith("beveloid-geom ") else part for part in parts[1::2])
    parts[1::2] = [Markup("<code>{}</code>").format(command) for command in commands]
    return Markup("").join(parts)


def by_statement(statements: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the statements of the paper, each with the results of both flanks."""
    entries: dict[str, dict[str, Any]] = {}
    for one in statements:
        entry = entries.setdefault(one["id"], {"id": one["id"], "statement": one["statement"]})
        entry[one["flank"]] = one
    return list(entries.values())


def _environment() -> Environment:
    """Return the environment of the templates."""
    environment = Environment(
        loader=PackageLoader(__package__, ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["general"] = "{:.6g}".format
    return environment


def _swings(results: FlankResults) -> bool:
    """Return True if the transmission error under any of the two errors is large enough to be shown."""
    if results.matrix is None:
        return False
    return bool(ARCSEC * np.nan_to_num(results.matrix.cycle_peak_to_peak).max() >= ZERO_ERROR_ARCSEC)


def _unlisted(data: PageData) -> list[str]:
    """Return sentences on missing results whose reason no remark names."""
    # Contents of the sections of the JSON whose names do not state them.
    section_words = {"tca": "path of contact", "hertz": "pressure", "matrix": "patterns under errors"}
    named = " ".join(remark.text for remark in data.remarks)
    missing: dict[tuple[str, str], list[str]] = {}
    for flank, results in data.flanks.items():
        for section, reason in results.reasons.items():
            if reason not in named and reason != _no_study(data):
                missing.setdefault((flank, reason), []).append(section_words.get(section, section))
    return [
        f"No {', '.join(sections)}, {flank} flanks: {reason}" for (flank, reason), sections in missing.items()
    ]


def _no_study(data: PageData) -> str | None:
    """Return the reason if the tolerances do not suit the design, so that there are no mountings."""
    return None if data.numbers["mountings"] else data.flanks[FLANKS[0]].reasons["tolerance"]


def _stamped(data: PageData, origin: Origin) -> dict[str, Any]:
    """Return the numbers of a page with name of the design, version and dates."""
    dates = {"made": origin.made, "written": origin.written}
    stamp = {name: date.isoformat(timespec="seconds") for name, date in dates.items() if date is not None}
    return {"name": data.name, "version": __version__, **stamp, **data.numbers}


def page_text(data: PageData, drawn: Charts, picture: str, view: dict[str, Any], origin: Origin) -> str:
    """Write the page.

    Parameters
    ----------
    data : PageData
        Contents.
    drawn : dict
        Charts by flank and name.
    picture : str
        Picture of the pair as SVG.
    view : dict
        Data of the 3D view.
    origin : Origin
        Name and dates.

    Returns
    -------
    str
        HTML.
    """
    numbers, peaks = _stamped(data, origin), peaks_of(data)
    template = _environment().get_template("report.html")
    return template.render(
        charts=drawn,
        picture=Markup(picture),
        view=view,
        origin=origin,
        numbers=numbers,
        number=partial(number_of, numbers),
        get=partial(looked_up, numbers),
        version=numbers["version"],
        statements=by_statement(numbers.get("statements", [])),
        parted=partial(parted, data.design, numbers, peaks),
        key_of=partial(key_of, peaks=peaks),
        with_code=partial(with_code, design=" ".join((origin.argument, *origin.changes))),
        **_of_data(data),
        **_of_page(data.design),
    )


def _of_data(data: PageData) -> dict[str, Any]:
    """Return the variables of the template that depend on the results."""
    flanks = data.flanks
    matrices = {flank: one.matrix for flank, one in flanks.items() if one.matrix is not None}
    pressed = [one.hertz.pressed for one in flanks.values() if one.hertz is not None]
    return {
        "name": data.name,
        "short_name": PurePath(data.name).name,
        "data": data,
        "known": lambda section: any(section not in results.reasons for results in flanks.values()),
        "cells": {flank: [Markup(cell) for cell in cell_pictures(one)] for flank, one in matrices.items()},
        "swinging": [flank for flank, one in flanks.items() if _swings(one)],
        "verdict": data.verdict,
        "levels": Counter(remark.level for remark in data.remarks),
        "clean": quiet(data.remarks),
        "without_transmission_error": without_transmission_error(data),
        "unlisted": _unlisted(data),
        "no_study": with_options(_no_study(data) or ""),
        "modified": data.ease_off.modified,
        "pressure_remarks": dict.fromkeys(
            remark for one in pressed if one is not None for remark in pressure_remarks(one)
        ),
    }


def _of_page(design: Design) -> dict[str, Any]:
    """Return the variables of the template that depend at most on the design, and its functions."""
    errors = [(name.replace("_", " "), name, unit_of(name)) for name in (*ERROR_NAMES[:2], *NAMES["mesh"])]
    steps = enumerate(steps_of(NAMES[design.errors_at]))
    return {
        "size_decimals": size_decimals(float(design.pinion.tool.normal_module)),
        "modifications": list(modification_words(design)),
        "ends": {name: end_names(getattr(design, name)) for name in MEMBERS},
        "place": place_words(design),
        "error_names": errors,
        "steps": [(f"{one.name} {one.shown:g} {one.unit}", str(number), one.size) for number, one in steps],
        "flanks": FLANKS,
        "harmonics": HARMONICS,
        "positions": POSITIONS,
        "quantile_places": [QUANTILE_SHARES.index(share) for share in SHOWN_SHARES],
        "verdicts": {  # by the level of the most severe remark
            ERROR: "Does not work in this form",
            UNKNOWN: "Not assessed: a calculation failed",
            WARNING: "Works with restrictions",
            NOTE: "No objections found",
        },
        "shades": range(SHADE_COUNT),
        "ease_off_grid": EASE_OFF_GRID,
        "builtin": BUILTINS,
        "deg": 1.0 / math.radians(1.0),
        "arcsec": ARCSEC,
        "asset": asset,
        "script_json": script_json,
    }
