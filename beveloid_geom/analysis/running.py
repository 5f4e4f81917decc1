"""A pair in operation in many mountings: what its teeth do over a mesh cycle, edges and hand-overs included.

The path of contact says where two flanks are tangent, these figures what touches first: the transmission
error of all teeth, how much of the cycle edges carry, how many tooth pairs are within a film of touching, and
at which edges of the flanks a contact pattern ends.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ..arrays import Codes, FloatArray, Mask
from ..contact.ellipse import MARKING_SEPARATION
from ..design.model import Design
from ..operation.operating_ratio import operating_ratios
from ..status import FirstStatus
from ..support.few_lines import few_lines
from .pattern_ends import pattern_ends

TOGETHER = 64
"""Mountings worth solving in one call."""
QUANTITIES = ("cycle_peak_to_peak", "edge_share", "film_ratio")
"""What has a spread."""


@dataclass(frozen=True, eq=False)
class Running:
    """Mesh cycles of n mountings: `status` (n), codes of `FirstStatus`; NaN where it is not SOLVED.

    `cycle_peak_to_peak` (n), rad: greatest less least transmission error of all teeth. `edge_share` (n): of
    the cycle, what edges carry. `film_ratio` (n): operating contact ratio within a film of 6.35 um,
    `operating_ratio`; NaN also where that is not known. `pattern_ends` (n, 8), in the order of `Limit`: at
    which edges of both flanks patterns under marking compound of 6.35 um end."""

    __repr__ = few_lines

    status: Codes
    cycle_peak_to_peak: FloatArray
    edge_share: FloatArray
    film_ratio: FloatArray
    pattern_ends: Mask

    @property
    def solved(self) -> Mask:
        """The mountings whose mesh cycle is known."""
        return np.asarray(self.status == FirstStatus.SOLVED)

    def quantities(self) -> dict[str, FloatArray]:
        """Give what has a spread, by name, each (n,)."""
        return {name: getattr(self, name) for name in QUANTITIES}


def running(mountings: Design, flank: str) -> Running:
    """Find mesh cycles of a design with single members and errors of one batch axis.

    Raises ValueError for members of arrays, where a tool's rounds overlap, and as `pattern_ends`."""
    found = operating_ratios(mountings, flank, (MARKING_SEPARATION,))
    cycle = found.cycle
    return Running(
        status=cycle.status.reshape(-1).astype(np.int8),
        cycle_peak_to_peak=cycle.peak_to_peak.reshape(-1),
        edge_share=cycle.edge_share.reshape(-1),
        film_ratio=found.ratio.reshape(-1),
        pattern_ends=pattern_ends(cycle),
    )


def all_of(parts: list[Running]) -> Running:
    """Join mesh cycles, in their order."""
    names = [field.name for field in fields(Running)]
    return Running(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
