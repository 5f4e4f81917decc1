"""Requests answered the long way: from many more starts and values tried, and every pair looked at."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom.findings.advice import findings_on
from beveloid_geom.findings.remarks import quiet
from beveloid_geom.proposal import candidates
from beveloid_geom.proposal.candidates import candidates_of, within
from beveloid_geom.proposal.figures import design_of, figures_of
from beveloid_geom.proposal.request import Request

DENSE = {
    "HELICES": np.radians(np.arange(-42.0, 43.0, 3.0)),
    "SHIFTS": tuple(np.round(np.arange(-0.4, 0.81, 0.15), 3)),
    "CONE_STARTS": np.radians([-12.0, -7.0, -3.0, 0.0, 3.0, 7.0, 12.0]),
    "MANY": 99,
}
"""In place of the constants of `candidates`; all shifts are tried from all starts."""
MOST_PAIRS, MOST_CHECKS = 1500, 30
"""Pairs of which figures are found, and that are looked at as `check` does."""


def grid_search_solves(request: Request, seed: int = 0) -> bool:
    """Whether any pair on the grid passes `check` without warning."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in DENSE.items():
            patch.setattr(candidates, name, value)
        found = candidates_of(request)
    values = found.values[:, within(request, found)]
    order = np.random.default_rng(seed).permutation(values.shape[1])[:MOST_PAIRS]
    if not order.size:
        return False
    values = values[:, order]
    figures = figures_of(request, values)
    possible = np.flatnonzero(figures.possible)
    best = possible[np.argsort(-figures.reserve[possible])][:MOST_CHECKS]
    return any(quiet(findings_on(design_of(request, values[:, k]))) for k in best)
