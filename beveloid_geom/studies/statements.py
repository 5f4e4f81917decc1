"""The paper's statements on modified flanks and misaligned pairs, each computed for a design and judged.

Nothing is taken from the paper but the statements (`statements.toml`), with the coefficients and errors
they name. The design's own parabola coefficients and errors are set aside. The paper's figures are of right
flanks.
"""

from __future__ import annotations

import tomllib
from dataclasses import replace
from importlib.resources import files

import numpy as np

from ..arrays import flank_sign
from ..design.file import builtin_design
from ..design.model import Design, Errors
from .claims import CLAIMS, MEASURES, Case
from .statement_verdicts import Statement, claim_of


def without_its_own(design: Design) -> Design:
    """Give a design without parabola coefficients and errors, to which those of the statements are added."""
    return replace(design.with_parabola(0.0, 0.0), errors=Errors())


def is_papers(design: Design) -> bool:
    """Say whether a design is the paper's Table 1, whatever its coefficients and errors: its statements set
    them aside."""
    return without_its_own(design) == without_its_own(builtin_design())


def paper_statements(design: Design, flank: str = "right", *, sign: int = 1) -> tuple[Statement, ...]:
    """Judge the paper's statements for a single design and one flank.

    The design's own parabola coefficients and errors are set aside. With a `sign` of -1 all
    coefficients of the statements are taken with the other sign. Raises ValueError for a batch and for an
    unknown flank."""
    flank_sign(flank)
    if design.batch_shape:
        raise ValueError(f"statements are judged for single designs, got a batch of {design.batch_shape}")
    case = Case(without_its_own(design), flank, sign)
    said = tomllib.loads((files(__package__) / "statements.toml").read_text(encoding="utf-8"))
    found: list[Statement] = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for id_, words in said.items():
            ways, detail = MEASURES[id_](case)
            claims = tuple(claim_of(text, ways[quantity], asked) for text, quantity, asked in CLAIMS[id_])
            source, says, measured = (words[key] for key in ("source", "says", "measured"))
            found.append(Statement(id_, flank, source, says, measured, claims, detail))
    return tuple(found)
