"""Reports of `optimise`: parabola coefficients or amounts of modification."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ...analysis.edge_contact import CycleExtremes
from ...analysis.modification.amounts import AmountsOptimum, amount_of
from ...analysis.optimise import Aim, Objectives, Optimised, Optimum
from ...arrays import MEMBERS
from ...design.model import Design
from ...design.modification import AMOUNT_SUFFIX
from ...findings.backlash import backlash_data
from ...findings.diagnostics import remarks_data
from ...pair.named_inputs import Bounds
from ..columns import ARCSEC, label, labelled_lines, number
from ..path import ContactReport, contact_report
from ..result import Report, Rows, stacked_rows
from ..text import both_signs_words, head_lines, line, remark_lines


@dataclass(frozen=True, eq=False)
class OptimumReport(Report):
    """Optimum of a single design for one flank pair.

    `subject` names the variables in the title, `variables` are their entries in JSON, `words` their values
    and `bounds` their bounds in the text, and `columns` returns those of a design in CSV."""

    aim: Aim
    flank: str
    optimum: Optimised
    subject: str
    variables: dict[str, Any]
    words: str
    bounds: str
    columns: Callable[[Design], dict[str, float]]

    @property
    def contact(self) -> ContactReport:
        """Path of contact of the optimum."""
        return contact_report(self.name, self.optimum.design, self.flank, 21)

    @property
    def _results(self) -> dict[str, dict[str, float]]:
        """Results of the optimum and of the design."""
        optimum = self.optimum
        return {
            "found": _figures(optimum.optimum, optimum.optimum_operation),
            "given": _figures(optimum.given, optimum.given_operation),
        }

    def values(self) -> dict[str, Any]:
        """Return aim, variables and results."""
        optimum, contact = self.optimum, self.contact
        values = {
            "aim": self.aim,
            **self.variables,
            "at_limits": optimum.at_limits,
            **self._results,
            **backlash_data(optimum.design),
            **remarks_data(contact.remarks),
        }
        if contact.certificate is not None:
            certified = {"first_contact": contact.certified_count, "positions": contact.path.status.size}
            values["certified"] = certified
        return values

    def rows(self) -> Rows:
        """Return a row for the optimum and one for the design."""
        designs = {"found": self.optimum.design, "given": self.design}
        return stacked_rows(
            [
                {"design": which}
                | self.columns(designs[which])
                | {"pinion_z_middle" if key == "centre" else key: value for key, value in results.items()}
                for which, results in self._results.items()
            ]
        )

    def summary(self) -> str:
        """Return aim, variables and results, compared with those of the design."""
        objectives = {
            "shift": "minimum shift of the path under errors",
            "transmission_error": "minimum transmission error of all teeth under any error",
        }
        optimum, contact, results = self.optimum, self.contact, self._results
        title = f"{self.subject} for {self.name}, {self.flank} flanks: {objectives[self.aim.least]}\n"
        text = title + head_lines(self.design) + line("constraints", f"{_aim_words(self.aim)}; {self.bounds}")
        text += line("errors", both_signs_words(self.aim.errors))
        same = self.columns(optimum.design) == self.columns(self.design)
        text += line("optimum", self.words + ", as designed: no better values were found" * same)
        if optimum.at_limits:
            names = ", ".join(map(shown, optimum.at_limits))
            text += line("at a bound", f"{names}: wider bounds may give a better optimum")
        if contact.certificate is not None:
            count = f"at {contact.certified_count} of {contact.path.status.size} positions"
            text += line("certified", f"{count} nothing on the driving flanks touches earlier")
        text += line("as mounted", f"backlash {contact.backlash.line}") + remark_lines(contact.remarks)
        rows = [("", ["optimum", "as designed"])]
        for key, value in results["found"].items():
            rows.append((label(key), [number(key, value), number(key, results["given"][key])]))
        return text + "\n" + labelled_lines(rows, label_width=42, cell_width=14)


def parabola_report(name: str, design: Design, aim: Aim, flank: str, optimum: Optimum) -> OptimumReport:
    """Return the report of an optimum of the parabola coefficients, 1/mm."""
    coefficients = {"pinion": optimum.pinion_parabola, "gear": optimum.gear_parabola}
    words = "pinion {:.6g} 1/mm, gear {:.6g} 1/mm".format(*coefficients.values())
    if any(list(member.tool.parabolas) != ["parabola"] for member in design.members):
        words += " on both flanks, in place of the coefficients of right and left flanks"
    bounds = "pinion {:g} to {:g}, gear {:g} to {:g} 1/mm".format(*aim.pinion_parabola, *aim.gear_parabola)

    def columns(design: Design) -> dict[str, float]:
        """Return the coefficients of a design."""
        members = {name: getattr(design, name) for name in MEMBERS}
        return {f"parabola_{name}": float(one.tool.parabola_of(flank)) for name, one in members.items()}

    variables = {"parabola": coefficients}
    subject = "Parabola coefficients"
    return OptimumReport(name, design, aim, flank, optimum, subject, variables, words, bounds, columns)


def amounts_report(
    name: str, design: Design, aim: Aim, flank: str, optimum: AmountsOptimum, bounds: Mapping[str, Bounds]
) -> OptimumReport:
    """Return the report of an optimum of amounts of modification between `bounds`, um by name."""
    amounts = optimum.amounts
    words = ", ".join(f"{shown(name)} {value:.4g} um" for name, value in amounts.items())
    limits = ", ".join(f"{shown(name)} {low:g} to {high:g} um" for name, (low, high) in bounds.items())

    def columns(design: Design) -> dict[str, float]:
        """Return the amounts of a design."""
        return {name.replace(".", "_"): amount_of(design, flank, name) for name in amounts}

    variables = {"amounts": amounts}
    subject = "Amounts of modification"
    return OptimumReport(name, design, aim, flank, optimum, subject, variables, words, limits, columns)


def shown(name: str) -> str:
    """Return the name of an amount or a coefficient in words, without its unit."""
    return name.removesuffix(AMOUNT_SUFFIX).replace(".", " ").replace("_", " ")


def _figures(paths: Objectives, operation: CycleExtremes) -> dict[str, float]:
    """Return the results of a path and of the operation by name."""
    names = ("shift", "contact_ratio", "centre", "peak_to_peak")
    return {name: float(getattr(paths, name)) for name in names} | asdict(operation)


def _aim_words(aim: Aim) -> str:
    """Return the constraints of the optimisation."""
    words = f"contact ratio at least {aim.contact_ratio:g}, middle within {aim.off_centre:g} mm of mid-face"
    if math.isfinite(aim.peak_to_peak):
        limit = ARCSEC * aim.peak_to_peak
        words += f", transmission error at most {limit:g} arcsec peak to peak"
    words += f", shift at most {aim.shift:g} mm" if math.isfinite(aim.shift) else ""
    return words + ("" if aim.edges else ", no edge contact with or without these errors")
