"""Statistics of the mesh cycles of a pair in many mountings, with edge contact and hand-over between tooth
pairs.

The path of contact states where two flanks are tangent, a mesh cycle which teeth touch first. The statistics
are the transmission error of all teeth, the share of the cycle in which edges touch, the operating contact
ratio in a film, and the edges of the flanks at which contact patterns end. Patterns are computed for a few
mountings only."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..contact.ellipse import MARKING_SEPARATION_MM
from ..design.model import Design
from ..operation.operating_ratio import operating_ratios
from ..status import FirstStatus, Limit
from ..support.array_repr import short_repr

CYCLES_PER_CALL = 64
"""Number of mountings for which one vectorised call is fastest."""


@dataclass(frozen=True, eq=False)
class CycleStatistics:
    """Mesh cycles of n mountings; NaN where `status` is not SOLVED.

    Attributes
    ----------
    status : Codes
        (n,), codes of `FirstStatus`.
    cycle_peak_to_peak : FloatArray
        (n,), rad: peak-to-peak transmission error of all teeth.
    edge_share : FloatArray
        (n,): share of the cycle in which edges touch.
    film_ratio : FloatArray
        (n,): operating contact ratio that also counts tooth pairs with a clearance up to 6.35 um, the
        thickness of a lubricant film (`operating_ratio`); NaN also where it is not known.
    pattern_ends : Mask
        (n, 8), in the order of `Limit`: edges at which the pattern of 6.35 um of marking compound ends.
    pattern_known : Mask
        (n,): mountings for which the pattern was computed; `pattern_ends` of the others is False.
    """

    __repr__ = short_repr

    status: Codes
    cycle_peak_to_peak: FloatArray
    edge_share: FloatArray
    film_ratio: FloatArray
    pattern_ends: Mask
    pattern_known: Mask

    @property
    def solved(self) -> Mask:
        """Mountings whose mesh cycle is known."""
        return np.asarray(self.status == FirstStatus.SOLVED)

    def quantities(self) -> dict[str, FloatArray]:
        """Return the quantities (n,) that have a distribution, by name."""
        return {name: getattr(self, name) for name in ("cycle_peak_to_peak", "edge_share", "film_ratio")}

    def with_patterns(self, numbers: Integers, ends: list[Mask]) -> CycleStatistics:
        """Return these statistics with the pattern ends (8,) of the mountings with these numbers."""
        pattern_ends, known = self.pattern_ends.copy(), self.pattern_known.copy()
        pattern_ends[numbers], known[numbers] = np.reshape(ends, (-1, len(Limit))), True
        return replace(self, pattern_ends=pattern_ends, pattern_known=known)


def cycle_statistics(mountings: Design, flank: str) -> CycleStatistics:
    """Compute the mesh cycles of mountings, without patterns.

    Parameters
    ----------
    mountings : Design
        A design in n mountings: single members, and errors with one batch axis (n,).
    flank : {'right', 'left'}

    Returns
    -------
    CycleStatistics

    Raises
    ------
    ValueError
        For members of arrays, and if the tip rounds of a tool overlap.
    """
    ratios = operating_ratios(mountings, flank, (MARKING_SEPARATION_MM,))
    cycle = ratios.cycle
    return CycleStatistics(
        status=cycle.status.reshape(-1).astype(np.int8),
        cycle_peak_to_peak=cycle.peak_to_peak.reshape(-1),
        edge_share=cycle.edge_share.reshape(-1),
        film_ratio=ratios.ratio.reshape(-1),
        pattern_ends=np.zeros((cycle.status.size, len(Limit)), dtype=bool),
        pattern_known=np.zeros(cycle.status.size, dtype=bool),
    )
