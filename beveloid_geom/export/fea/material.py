"""Steel, in N, mm, MPa, tonne."""

from __future__ import annotations

from ...contact.hertz import POISSON_RATIO as POISSON_RATIO, YOUNG_MPA as YOUNG_MPA

DENSITY_T_PER_MM3 = 7.85e-9
