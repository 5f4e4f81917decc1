"""What CalculiX found for the pair in contact: forces of the tooth pairs, and how far the pinion turned."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ...export import MEMBERS, identifier
from .pair_deck import LEAD

HEADER = 40
"""Lines of a deck among which its facts are looked for."""
LAST = 2.0
"""Time at the end of the deck's last step."""


@dataclass(frozen=True, eq=False)
class PairResult:
    """The pair under a load, in S_f: N, mm, rad.

    `flank`; `decks`: of how many over a pitch it is one; `rolls` (2,) of pinion and gear where they touch
    without load; `torque` on the pinion, N mm;
    by tooth pair, in the order of the pinion's teeth, `force` (K, 3) on the pinion, N, its moments `moment`
    (K, 2) about the axes of pinion and gear, N mm, and where it acts, `centre` (K, 3), NaN without a force;
    `turn`: how far the pinion turns on under the load while the gear is held, positive as it is driven."""

    flank: str
    decks: int
    rolls: FloatArray
    torque: float
    force: FloatArray
    moment: FloatArray
    centre: FloatArray
    turn: float

    @property
    def share(self) -> FloatArray:
        """Share (K,) of the torque on the pinion that each tooth pair carries."""
        return np.asarray(self.moment[:, 0] / self.moment[:, 0].sum())


def read_pair_result(deck: Path) -> PairResult:
    """Read what CalculiX left beside a deck of the pair in contact (`.dat`).

    Raises ValueError for a deck of something else, and where CalculiX did not come to its end; OSError where
    one of the files cannot be read."""
    with open(deck, encoding="ascii", errors="replace") as file:
        header = [line for line, _ in zip(file, range(HEADER), strict=False) if LEAD in line]
    if not header:
        raise ValueError(f"{deck} is no deck of a pair in contact: write one with mesh --part pair")
    facts = json.loads(header[0].split(LEAD, 1)[1])
    text = deck.with_suffix(".dat").read_text(encoding="ascii", errors="replace").lower()
    axes, origins = np.array(facts["axes"]), np.array(facts["origins"])
    rows = np.array([_statistics(text, pair, deck) for pair in facts["pairs"]])
    force, about, centre = rows[:, :3], rows[:, 3:6], rows[:, 6:]
    moment = np.stack(
        [(about - np.cross(o, force)) @ axis for o, axis in zip(origins, axes, strict=True)], axis=-1
    )
    lever = np.cross(axes[0], np.array(facts["gauges"][0]) - origins[0])
    moved = _after(text, rf"displacements .*? for set {identifier(f'{MEMBERS[0]} gauge')} and time", deck)
    turn = float(moved[1:4] @ lever / (lever @ lever))
    sense = -np.sign(moment[:, 0].sum())
    rolls = np.array([facts["pinion_roll"], facts["gear_roll"]])
    turn = float(sense * turn)
    return PairResult(facts["flank"], facts["decks"], rolls, facts["torque"], force, moment, centre, turn)


def _statistics(text: str, pair: list[str], deck: Path) -> FloatArray:
    """Give force, moment about the origin and centre (9,) of a contact."""
    return _after(text, f"statistics for slave set {pair[0]}, master set {pair[1]} and time", deck)[:9]


def _after(text: str, head: str, deck: Path) -> FloatArray:
    """Give the numbers, words between them left out, from the last `head`, a pattern, to the next."""
    found = list(re.finditer(rf"{head} +(\S+)\n(.*?)(?=\n [a-z]|\Z)", text, re.DOTALL))
    if not found or abs(float(found[-1][1]) - LAST) > 1e-6:
        raise ValueError(f"CalculiX has not solved {deck} to its end: look into {deck.with_suffix('.sta')}")
    numbers = re.findall(r"(?<=\s)(?:nan|[-+.\d][-+.e\d]*)(?=\s|$)", found[-1][2])
    return np.array([float(word) for word in numbers])
