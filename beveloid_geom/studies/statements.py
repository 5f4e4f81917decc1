"""The paper's statements on modified flanks and misaligned pairs, each computed for a design and judged.

Nothing is taken from the paper but the statements, with the coefficients and errors they name. The
design's own parabola coefficients and errors are set aside. The paper's figures are of right flanks.

Source: section 4 of the paper; F6 is its Fig. 6, C1 to C4 its cases of Figs. 7 to 10, R1 to R4 those of
Fig. 11, D1 its conclusion from them, M1 to M6 Figs. 12 to 15.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import flank_sign
from ..design.model import Design, Errors
from .error_statements import m1, m2, m3, m4, m5, m6
from .modification_statements import c1, c2, c3, c4, d1, f6, r1, r2, r3, r4
from .statement_verdicts import Case, Statement

_JUDGES = (f6, c1, c2, c3, c4, r1, r2, r3, r4, d1, m1, m2, m3, m4, m5, m6)


def paper_statements(design: Design, flank: str = "right", *, sign: int = 1) -> tuple[Statement, ...]:
    """The paper's statements, judged for a single design and one flank.

    The design's own parabola coefficients and errors are set aside. With a `sign` of -1 all
    coefficients of the statements are taken with the other sign. Raises ValueError for a batch and for an
    unknown flank."""
    flank_sign(flank)
    if design.batch_shape:
        raise ValueError(f"statements are judged for single designs, got a batch of {design.batch_shape}")
    case = Case(replace(design.with_parabola(0.0, 0.0), errors=Errors()), flank, sign)
    with np.errstate(invalid="ignore", divide="ignore"):
        return tuple(judge(case) for judge in _JUDGES)
