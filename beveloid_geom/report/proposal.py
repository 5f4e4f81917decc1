"""Pairs that were proposed on a request: a table, JSON and CSV with all that tells them apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ..design.text import design_text
from ..findings.remarks import tip_clearances
from ..proposal.figures import FLANKS
from ..proposal.propose import Proposal
from ..proposal.request import Request
from ..proposal.words import command_of
from .columns import label, number
from .result import Rows
from .words import line, typed

WIDTH, CELL = 34, 12
"""Characters of the names and of a number in a text."""
MEASURE = (
    "the greatest reserve first: how far what is nearest to a warning of `check` is from it, over how far is"
    " ample; contact ratio, tip thickness and clearance, undercut, shift of the path under errors"
)
LEAST = (
    "the least cones first, of those alike the greatest reserve: how far the nearest warning of `check` is"
)


@dataclass(frozen=True, eq=False)
class ProposalReport:
    """The proposals on a `request`, whose gear, if one is given, is in the file `gear`."""

    request: Request
    proposals: tuple[Proposal, ...]
    gear: str = ""
    failure: str | None = None

    @property
    def command(self) -> str:
        """The command line that asks for them."""
        return command_of(self.request, self.gear)

    @property
    def measure(self) -> str:
        """What is best."""
        return LEAST if self.request.least_cones else MEASURE

    def text_of(self, k: int) -> str:
        """Write the design of that number, from 1, as a file."""
        return design_text(self.proposals[k - 1].design, f"Proposal {k} of: {self.command}")

    def data(self) -> dict[str, Any]:
        """Give the request and the designs, the best first, each with its figures and as a design file."""
        request = {name: value for name, value in vars(self.request).items() if name != "members"}
        request["gear"] = None if self.request.gear is None else asdict(self.request.gear)
        numbered = enumerate(self._numbers(), 1)
        designs = [{**numbers, "toml": self.text_of(k)} for k, numbers in numbered]
        return {"request": request, "command": self.command, "measure": self.measure, "designs": designs}

    def rows(self) -> Rows:
        """Give the designs, the best first."""
        numbers = self._numbers()
        return {name: [one[name] for one in numbers] for name in numbers[0]}

    def summary(self) -> str:
        """Write a column for each design."""
        text = f"Pairs that close\n  {typed(self.command)}\n\n{'':<{WIDTH}}"
        text += "".join(f"{k:>{CELL}}" for k in range(1, 1 + len(self.proposals))) + "\n"
        numbers = self._numbers()
        for name in numbers[0]:
            cells = "".join(number(name, one[name], CELL) for one in numbers)
            text += f"{label(name):<{WIDTH}}{cells}\n"
        text += "\n" + line("order", self.measure)
        sides = f"drive: the {self.request.flank} flanks, coast: the others"
        return text + line("flanks", sides) + line("checked", "no warnings; --out FILE writes the first")

    def _numbers(self) -> list[dict[str, float]]:
        """Give the numbers of each design by name, mm and rad."""
        return [dict(_numbers(self.request.flank, proposal)) for proposal in self.proposals]


def _numbers(drive: str, proposal: Proposal) -> Mapping[str, float]:
    """Give the numbers of a proposal."""
    design, figures = proposal.design, proposal.figures
    found = {"offset": float(design.pair.offset), "shaft_angle": float(design.pair.shaft_angle)}
    members = dict(zip(("pinion", "gear"), design.members, strict=True))
    for name in ("cone_angle", "helix_angle", "profile_shift"):
        found |= {f"{member}_{name}": float(getattr(own, name)) for member, own in members.items()}
    by_flank = {
        "contact_ratio": figures.contact_ratio,
        "crossing_angle": figures.crossing,
        "n_x": figures.normal_x,
    }
    sides = {"drive": FLANKS.index(drive), "coast": 1 - FLANKS.index(drive)}
    for name, values in by_flank.items():
        found |= {f"{side}_{name}": float(values[k, 0]) for side, k in sides.items()}
    for member, clearance in zip(members, tip_clearances(design), strict=True):
        found[f"{member}_tip_clearance"] = float(clearance)
    for member, margin in zip(members, figures.margin[:, 0], strict=True):
        found[f"{member}_undercut_margin"] = float(margin)
    return found | {"reserve": float(figures.reserve[0])}
