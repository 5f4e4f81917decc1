"""The paper's statements on modified flanks and misaligned pairs, computed for a design and judged.

The statements (`statements.toml`), their coefficients and the offset error are those of the paper. The other
errors are ours (`claims`). The parabola coefficients and errors of the design are ignored. The paper does not
say which flanks its figures show. We infer right flanks; verdicts for left flanks are a comparison only."""

from __future__ import annotations

import tomllib
from importlib.resources import files

import numpy as np

from ..arrays import flank_sign
from ..design.arguments import require_design, require_integers
from ..design.file import builtin_design
from ..design.model import Design
from .claims import CLAIMS, MEASURES, FlankCase
from .statement_verdicts import Statement, claim_of


def is_table1(design: Design) -> bool:
    """Return whether a design is Table 1 of the paper, apart from its parabola coefficients and errors."""
    return design.bare() == builtin_design().bare()


def paper_statements(design: Design, flank: str = "right", *, sign: int = 1) -> tuple[Statement, ...]:
    """Return the paper's statements, judged for one flank of a design.

    Parameters
    ----------
    design : Design
        A single design; its parabola coefficients and errors are ignored.
    flank : {'right', 'left'}
    sign : {1, -1}
        -1 reverses the signs of all coefficients of the statements.

    Returns
    -------
    tuple of Statement

    Raises
    ------
    ValueError
        For a batch and for an unknown flank.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> statements = bg.paper_statements(bg.builtin_design("ni-2017"))
    >>> statements[0].id, statements[0].verdict.name
    ('F6', 'HOLDS')
    """
    require_design(design)
    flank_sign(flank)
    require_integers(sign=sign)
    if design.batch_shape:
        raise ValueError(f"statements are judged for single designs, got a batch of {design.batch_shape}")
    case = FlankCase(design.bare(), flank, sign)
    texts = tomllib.loads((files(__package__) / "statements.toml").read_text(encoding="utf-8"))
    statements: list[Statement] = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for id_, words in texts.items():
            measures, detail = MEASURES[id_](case)
            claims = tuple(
                claim_of(text, measures[quantity], criteria) for text, quantity, criteria in CLAIMS[id_]
            )
            source, says, measured = (words[key] for key in ("source", "says", "measured"))
            statements.append(Statement(id_, flank, source, says, measured, claims, detail))
    return tuple(statements)
