"""Report of `modify`: crownings for a transmission error and a length of the pattern."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ...analysis.modification.crowning import Crowning
from ..columns import ARCSEC
from ..result import ResultReport, Rows, stacked_rows
from ..text import head_lines, line


@dataclass(frozen=True, eq=False)
class CrowningReport(ResultReport[Crowning]):
    """Crownings of one flank of a single design."""

    def values(self) -> dict[str, Any]:
        """Return the crownings and the contact."""
        return {key: value for key, value in asdict(self.result).items() if key not in ("design", "flank")}

    def rows(self) -> Rows:
        """Return the crownings and the contact as one row."""
        return stacked_rows([self.values()])

    def summary(self) -> str:
        """Return the crownings and the contact."""
        result = self.result
        text = f"Crownings for {self.name}, {result.flank} flanks\n" + head_lines(self.design)
        text += line(
            result.member,
            f"helix crowning {result.helix_crowning_um:.4g} um, profile crowning"
            f" {result.profile_crowning_um:.4g} um",
        )
        error = ARCSEC * result.transmission_error
        text += line("transmission error", f"{error:.4g} arcsec peak to peak, of all teeth")
        text += line(
            "pattern",
            f"{result.length:.4g} mm along the face of the {result.member}, with marking compound"
            f" {1e3 * result.separation:g} um thick",
        )
        edges = f"during {100.0 * result.edge_share:.1f} % of the mesh cycle" if result.edge_share else "none"
        return text + line("edge contact", edges)
