"""Results of CalculiX for the pair in contact: forces of the tooth pairs and rotation of the pinion."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import MEMBERS, FloatArray
from ...export import identifier
from .pair_deck import FACTS_MARK


@dataclass(frozen=True, eq=False)
class PairResult:
    """The pair under a load, in S_f, with K tooth pairs in the order of the pinion's teeth.

    Attributes
    ----------
    flank : {'right', 'left'}
        Flanks in contact.
    decks : int
        Number of decks over one pitch to which this one belongs.
    rolls : array (2,)
        Rolls of pinion and gear, rad, at the first contact without load.
    torque : float
        Torque on the pinion, N mm.
    origins : array (2, 3)
        Origins of the frames of the members, mm.
    force : array (K, 3)
        Contact force on the pinion, N.
    moment : array (K, 2)
        Moments of this force about the axes of pinion and gear, N mm.
    centre : array (K, 3)
        Centre of the contact force, mm; NaN without a force.
    turn : float
        Rotation of the pinion under the load while the gear is held, rad, positive in the direction of drive.
    """

    flank: str
    decks: int
    rolls: FloatArray
    torque: float
    origins: FloatArray
    force: FloatArray
    moment: FloatArray
    centre: FloatArray
    turn: float

    @property
    def share(self) -> FloatArray:
        """Share (K,) of the pinion's torque that each tooth pair carries."""
        return np.asarray(self.moment[:, 0] / self.moment[:, 0].sum())


def read_pair_result(deck: Path) -> PairResult:
    """Read the output of CalculiX (`.dat`) next to a deck of the pair in contact.

    Raises
    ------
    ValueError
        If the file is not such a deck, or CalculiX has not finished it.
    OSError
        If one of the files cannot be read.
    """
    facts = _facts(deck)
    text = deck.with_suffix(".dat").read_text(encoding="ascii", errors="replace").lower()
    axes, origins = np.array(facts["axes"]), np.array(facts["origins"])
    rows = np.array(
        [
            _numbers(text, f"statistics for slave set {pinion}, master set {gear} and time", deck)[:9]
            for pinion, gear in facts["pairs"]
        ]
    )
    force, moment_about_origin, centre = rows[:, :3], rows[:, 3:6], rows[:, 6:]
    moment = np.stack(
        [
            (moment_about_origin - np.cross(origin, force)) @ axis
            for origin, axis in zip(origins, axes, strict=True)
        ],
        axis=-1,
    )
    # Rotation of the gauge node about the axis: its displacement along the circle over its radius.
    gauge = identifier(f"{MEMBERS[0]} gauge")
    displacement = _numbers(text, rf"displacements .*? for set {gauge} and time", deck)[1:4]
    lever = np.cross(axes[0], np.array(facts["gauges"][0]) - origins[0])
    turn = -np.sign(moment[:, 0].sum()) * (displacement @ lever / (lever @ lever))
    rolls = np.array([facts["pinion_roll"], facts["gear_roll"]])
    flank, decks, torque = facts["flank"], facts["decks"], facts["torque"]
    return PairResult(flank, decks, rolls, torque, origins, force, moment, centre, float(turn))


def _facts(deck: Path) -> dict[str, Any]:
    """Return the data in the header of a deck. Raises ValueError if there are none."""
    with open(deck, encoding="ascii", errors="replace") as file:
        for line, _ in zip(file, range(40), strict=False):
            if FACTS_MARK in line:
                return dict(json.loads(line.split(FACTS_MARK, 1)[1]))
    cure = "write one with beveloid-geom mesh --part pair --out pair.inp"
    raise ValueError(f"{deck} is not a deck of a pair in contact: {cure}")


def _numbers(text: str, head: str, deck: Path) -> FloatArray:
    """Return the numbers in the last section whose heading matches a pattern, without the words between them.

    Raises ValueError if this section is not of the end of the last step, time 2."""
    sections = list(re.finditer(rf"{head} +(\S+)\n(.*?)(?=\n [a-z]|\Z)", text, re.DOTALL))
    if not sections or abs(float(sections[-1][1]) - 2.0) > 1e-6:
        raise ValueError(f"CalculiX has not completed {deck}: see {deck.with_suffix('.sta')}")
    numbers = re.findall(r"(?<=\s)(?:nan|[-+.\d][-+.e\d]*)(?=\s|$)", sections[-1][2])
    return np.array([float(word) for word in numbers])
