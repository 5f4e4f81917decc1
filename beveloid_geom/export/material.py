"""Steel, in N, mm, MPa, tonne."""

from __future__ import annotations

YOUNG = 206000.0
POISSON = 0.3
DENSITY = 7.85e-9
