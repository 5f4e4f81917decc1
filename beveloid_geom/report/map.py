"""Report of `map`: results over two quantities of a design."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.maps import IN_OPERATION, QUANTITIES, DesignMap
from ..arrays import Mask
from ..contact.path import contact_ratio
from ..findings.path import batch_reason
from ..pair.mounting import mounting_of
from ..pair.named_inputs import INPUTS, design_at, own_values
from ..status import Status
from .columns import column, label, scaled
from .result import ResultReport, Rows, flattened, picked
from .text import LINE_WIDTH, both_signs_words, head_lines, line, status_words


@dataclass(frozen=True, eq=False)
class MapReport(ResultReport[DesignMap]):
    """Map of a single design over two of its quantities."""

    @property
    def reason(self) -> str | None:
        """Reason why no cell has a path, None if one has; `NotComputed` if a calculation failed."""
        result = self.result
        if result.solved.any():
            return None
        undefined = result.status == Status.UNDEFINED
        cells = design_at(result.design, result.over, result.first[:, None], result.second)
        # Without a common normal there is no contact, as in `reason_of` for a single path.
        missing = undefined & np.isnan(mounting_of(cells).gap)
        words = f"no cell of the map has a path on the {self.flank} flanks"
        if missing.any():
            words += f", in {np.count_nonzero(missing)} the flanks have no common normal"
        return batch_reason(words, np.where(missing, Status.NO_COMMON_NORMAL, result.status))

    def values(self) -> dict[str, Any]:
        """Return the map, one row for each value of the first input.

        `pinion` and `gear` are the values of the first and of the second input, whatever they are."""
        result = self.result
        return {
            "over": result.preset or list(result.over),
            "errors": result.errors,
            "pinion": result.first,
            "gear": result.second,
            "map": map_cells(result),
        }

    def rows(self) -> Rows:
        """Return the cells."""
        sides = np.meshgrid(self.result.first, self.result.second, indexing="ij")
        inputs = dict(zip(self.result.over, sides, strict=True))
        return flattened(inputs | map_cells(self.result))

    def summary(self) -> str:
        """Return the extremes of the results and their positions."""
        result = self.result
        units = [INPUTS[name][1] for name in result.over]
        shape = f"{result.first.size} x {result.second.size} cells"
        words = {
            "parabola": "parabola coefficients",
            "mounting": "changes of the mounting distances",
            "shift": "profile shift coefficients",
        }
        inputs = words[result.preset] if result.preset else " and ".join(result.over)
        text = f"Map of {self.name} over the {inputs}, {self.flank} flanks: {shape}\n"
        text += head_lines(result.design) + line("errors for shift", both_signs_words(result.errors))
        sides = (
            f"{member} {texts[0]} to {texts[-1]} {unit}".rstrip()
            for member, unit, texts in zip(
                _headings(result), units, ([*side.values()] for side in _printed(result, 6)), strict=True
            )
        )
        text += line("values", ", ".join(sides)) + line("cells", cell_words(result))
        text += line(
            "mounted backlash",
            "with errors and modifications, of the flanks without edge contact, as in `tolerance`; `check`"
            " includes edges, which can touch earlier",
        )
        if self.reason:
            return text
        sound = bool(result.sound.any())
        cells = result.sound if sound else result.solved
        which = (
            "that can be assembled and have no negative relative curvature or backlash"
            if sound
            else "with a path, of which none can be assembled without negative relative curvature or backlash"
        )
        both = " and ".join(dict.fromkeys(unit for unit in units if unit))
        values = "values of the members" if result.preset else "values of the inputs"
        unit_words = f"{values} in {both}" if both else f"{values} have no unit"
        # Cells with an unknown backlash are not excluded by `sound`.
        if unknown := np.count_nonzero(cells & np.isnan(result.mounted_backlash)):
            which += f" (the mounted backlash is unknown in {unknown})"
        extremes = f"Extremes over the {np.count_nonzero(cells)} cells {which}, {unit_words}:"
        text += f"\n{textwrap.fill(extremes, LINE_WIDTH)}\n"
        return text + _extreme_lines(result, cells) + _quadrant_lines(result)


def _headings(result: DesignMap) -> tuple[str, str]:
    """Return the printed names of both inputs."""
    return ("pinion", "gear") if result.preset else result.over


def _printed(result: DesignMap, digits: int = 4) -> list[dict[float, str]]:
    """Return the text of each value of both inputs, with at least `digits` significant digits.

    There are as many digits as the step needs: rounding changes no value by more than 1 % of the step."""
    sides = []
    for values in (result.first, result.second):
        for count in range(digits, 18):
            texts = [f"{value + 0.0:.{count}g}" for value in values]
            if np.abs(np.array(texts, dtype=float) - values).max() <= 0.01 * abs(values[1] - values[0]):
                break
        sides.append(dict(zip(values.tolist(), texts, strict=True)))
    return sides


def map_cells(result: DesignMap) -> dict[str, Any]:
    """Return status, properties and results of the cells by name."""
    return picked(result, "status", "hollow", "interferes", "jammed", *map_results(result))


def map_results(result: DesignMap) -> tuple[str, ...]:
    """Return the names of the results of a map, those in operation only if they are known in a cell."""
    return (*QUANTITIES, *(name for name in IN_OPERATION if np.isfinite(getattr(result, name)).any()))


def cell_words(result: DesignMap) -> str:
    """Return the numbers of cells by status and by property."""
    counts = {status_words(status): result.status == status for status in Status}
    words = [f"{count} {name}" for name, mask in counts.items() if (count := int(np.count_nonzero(mask)))]
    for mask, text in (
        (result.solved & np.isnan(result.shift), "an error moves the path off the flanks"),
        (result.hollow, "the relative curvature of the flanks is negative"),
        (result.interferes, "the backlash is negative"),
        (result.jammed, "the pair cannot be assembled"),
        (np.isnan(result.mounted_backlash), "the mounted backlash is unknown"),
    ):
        if count := int(np.count_nonzero(mask)):
            words.append(f"in {count} {text}")
    return ", ".join(words)


def _extreme_lines(result: DesignMap, cells: Mask) -> str:
    """Return smallest and largest value of each result over some cells, and their positions; magnitudes of
    angles."""
    equal_tolerance = 1e-9
    printed = _printed(result)
    names = [(name, *texts.values()) for name, texts in zip(_headings(result), printed, strict=True)]
    columns = [max(11, 1 + max(map(len, texts))) for texts in names]
    heading = "".join(f"{name:>{width}}" for (name, *_), width in zip(names, columns, strict=True))
    lines = [f"{'':<27}{'smallest':>10}{heading}{'largest':>12}{heading}"]
    for figure in map_results(result):
        values = np.where(cells, scaled(figure, getattr(result, figure)), np.nan)
        values = np.abs(values) if figure == "angle" else values
        if np.isnan(values).all():
            continue
        text, digits = f"{label(figure):<27}", column(figure).digits
        if np.nanmax(values) - np.nanmin(values) < equal_tolerance:
            lines.append(f"{text}{np.nanmin(values):z10.{digits}f}  in all cells")
            continue
        for width, pick in ((10, np.nanargmin), (12, np.nanargmax)):
            i, j = np.unravel_index(pick(values), values.shape)
            at = names[0][1 + i], names[1][1 + j]
            text += f"{values[i, j]:z{width}.{digits}f}{at[0]:>{columns[0]}}{at[1]:>{columns[1]}}"
        lines.append(text)
    return "\n".join(lines) + "\n"


def quadrant_bests(result: DesignMap, ratio: float) -> dict[str, tuple[int, float, tuple[float, float]]]:
    """Return the best sound cells in each quadrant of a map over the parabola coefficients.

    The quadrants are the cases C1 to C4 of the paper: the signs of both coefficients.

    Parameters
    ----------
    result : DesignMap
    ratio : float
        Least contact ratio.

    Returns
    -------
    dict
        By quadrant: number of sound cells with at least this ratio, their least shift (mm) and the
        coefficients (1/mm) of that cell; NaN without any.
    """
    relative_tolerance = 1e-9  # so that the cell of the design has the ratio of the design
    bests = {}
    for name, cells in result.quadrants().items():
        with np.errstate(invalid="ignore"):
            good = cells & result.sound & (result.contact_ratio >= (1.0 - relative_tolerance) * ratio)
        shift = np.where(good, result.shift, np.nan)
        if np.isnan(shift).all():
            bests[name] = (int(np.count_nonzero(good)), math.nan, (math.nan, math.nan))
            continue
        i, j = np.unravel_index(np.nanargmin(shift), shift.shape)
        where = float(result.first[i]), float(result.second[j])
        bests[name] = (int(np.count_nonzero(good)), float(shift[i, j]), where)
    return bests


def _quadrant_lines(result: DesignMap) -> str:
    """Return a comparison of the cases C1 to C4 of the paper at the contact ratio of the design or above."""
    if result.preset != "parabola":
        return ""
    ratio = float(contact_ratio(result.design, result.flank))  # NaN if it is unknown
    if not ratio > 0.0:
        return "\nThe design has no contact ratio: the cases are not compared.\n"
    values = "pinion {:g}, gear {:g}".format(*own_values(result.design, result.over, result.flank))
    least = (
        f"Cases of the paper: smallest shift with a contact ratio of at least {ratio:.4f}, the ratio of the"
        f" design ({values}):"
    )
    text = f"\n{textwrap.fill(least, LINE_WIDTH)}\n"
    sign_words = {"C1": "both positive", "C2": "both negative", "C3": "a1 > 0 > a2", "C4": "a1 < 0 < a2"}
    first, second = _printed(result)
    for name, (count, shift, where) in quadrant_bests(result, ratio).items():
        case = f"{name}, {sign_words[name]}"
        if math.isnan(shift):
            text += f"{case:<20}no cell\n"
        else:
            at = f"pinion {first[where[0]]}, gear {second[where[1]]}"
            text += f"{case:<20}{shift:10.4f} mm at {at}, of {count} cell{'s' * (count > 1)}\n"
    return text
