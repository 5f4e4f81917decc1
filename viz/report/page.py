"""The page as text: template, charts and scripts in one file that needs no other.

Every number in it is written by `number` from the JSON that the page carries, so that text and JSON cannot
differ. Names come from users: all that is not of our own making is escaped.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from datetime import datetime
from functools import partial
from importlib.metadata import version
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from beveloid_geom.analysis.tolerance import SHARES
from beveloid_geom.cli.options import BUILTIN_DESIGN
from beveloid_geom.findings.remarks import quiet
from beveloid_geom.report.sensitivity import STEPS
from beveloid_geom.report.tolerance import SHOWN_SHARES

from ..parts.solved import FLANKS
from . import charts
from .data import HARMONICS, POSITIONS, FlankResults, PageData
from .svg import style, svg_of

NOT_KNOWN = "\u2013"
MINUS = "\u2212"
RAD = math.radians(1.0)
Charts = dict[str, dict[str, Markup]]


def looked_up(numbers: Mapping[str, Any], key: str) -> Any:
    """Say what stands in nested JSON under names and places joined by dots; None where there is nothing."""
    found: Any = numbers
    for part in key.split("."):
        if isinstance(found, list):
            found = found[int(part)] if int(part) < len(found) else None
        else:
            found = found.get(part) if isinstance(found, Mapping) else None
    return found


def number_text(value: float, digits: int, general: bool = False) -> str:
    """Give a number with so many digits after the point, or so many in all; a true minus, no minus zero."""
    return f"{value:z.{digits}{'g' if general else 'f'}}".replace("-", MINUS)


def number_of(
    numbers: Mapping[str, Any], key: str, digits: int, scale: float = 1.0, general: bool = False
) -> Markup:
    """Make the number under a key, times a scale, with key, scale and digits for those who check it."""
    value = looked_up(numbers, key)
    known = isinstance(value, (int, float)) and math.isfinite(value)
    text = number_text(value * scale, digits, general) if known else NOT_KNOWN
    kind = Markup(' data-format="g"') if general else ""
    tag = '<span class="n" data-key="{}" data-scale="{}" data-digits="{}"{}>{}</span>'
    return Markup(tag).format(key, repr(float(scale)), digits, kind, text)


def script_json(data: Any) -> Markup:
    """Make strict JSON that may stand in a script element, whatever strings it holds."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)


def asset(name: str) -> Markup:
    """Make a script or style sheet of ours, as it may stand in its element."""
    text = files(__package__).joinpath(name).read_text(encoding="utf-8")
    return Markup(text.replace("</script", "<\\/script"))


def _drawn(results: FlankResults) -> dict[str, Markup]:
    """Draw, by name, each chart of a flank pair that there is something to draw for."""
    operation, study = results.operation, results.study
    cloud_chart = partial(charts.flank_chart, cloud=True)
    over_roll = "Sliding speed and specific sliding over the pinion's roll"
    by_error = "Change of path, contact ratio and transmission error by each assembly error"
    drawings: tuple[tuple[str, str, Any, Callable[[Any], Figure | None]], ...] = (
        ("path", "Path of contact, points of first contact and pattern", results, charts.flank_chart),
        ("error", "Transmission error over two mesh cycles", operation, charts.error_chart),
        ("spectrum", "Amplitudes of the transmission error", operation, charts.spectrum_chart),
        ("sliding", over_roll, results.sliding, charts.sliding_chart),
        ("sensitivity", by_error, results.sensitivity, charts.sensitivity_chart),
        ("cloud", "Paths of contact under drawn errors", study and results, cloud_chart),
        ("ratio", "Spread of the contact ratio under drawn errors", study, charts.ratio_chart),
    )
    drawn = {}
    for name, title, found, draw in drawings:
        if found is not None and (chart := draw(found)) is not None:
            drawn[name] = Markup(svg_of(chart, f"{name}-{results.flank}", f"{title}, {results.flank} flanks"))
    return drawn


def draw_charts(data: PageData) -> Charts:
    """Draw the charts by flank and name; what cannot be drawn is left out."""
    with style():
        return {flank: _drawn(results) for flank, results in data.flanks.items()}


def with_code(text: str) -> Markup:
    """Make text with what stands in backticks as code."""
    parts = [escape(part) for part in text.split("`")]
    parts[1::2] = [Markup("<code>{}</code>").format(part) for part in parts[1::2]]
    return Markup("").join(parts)


def by_statement(statements: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Give the paper's statements, each with what is found on either flank."""
    found: dict[str, dict[str, Any]] = {}
    for one in statements:
        entry = found.setdefault(one["id"], {"id": one["id"], "statement": one["statement"]})
        entry[one["flank"]] = one
    return list(found.values())


def page_text(data: PageData, drawn: Charts, view: dict[str, Any], made: datetime) -> str:
    """Write the whole page, `made` when; `view` is the data of the view in 3D."""
    environment = Environment(
        loader=PackageLoader(__package__, ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["code"] = with_code
    release = version("beveloid-geom")
    stamp = {"name": data.name, "version": release, "made": made.isoformat(timespec="seconds")}
    numbers = stamp | data.numbers
    radians = {"deg": RAD}
    return environment.get_template("report.html").render(
        name=data.name,
        data=data,
        numbers=numbers,
        number=partial(number_of, numbers),
        get=partial(looked_up, numbers),
        known=lambda section: any(section not in results.reasons for results in data.flanks.values()),
        charts=drawn,
        flanks=FLANKS,
        harmonics=HARMONICS,
        positions=POSITIONS,
        quantile_places=[SHARES.index(share) for share in SHOWN_SHARES],
        statements=by_statement(numbers.get("statements", [])),
        version=release,
        made=made,
        builtin=BUILTIN_DESIGN,
        clean=quiet(data.remarks),
        asset=asset,
        script_json=script_json,
        view=view,
        deg=1.0 / RAD,
        arcsec=3600.0 / RAD,
        steps=[(f"{what} {size:g} {unit}", size * radians.get(unit, 1.0)) for what, size, unit in STEPS],
    )
