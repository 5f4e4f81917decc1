"""Steel, in N, mm, MPa, tonne."""

from __future__ import annotations

from ...contact.hertz import POISSON as POISSON, YOUNG as YOUNG

DENSITY = 7.85e-9
