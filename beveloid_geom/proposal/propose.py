"""From a request to pairs that close, mesh and have no warning, the best first; or why there is none.

Pairs that close are many. Of those within the limits the ones with the greatest reserve (`figures`) are
looked at as `check` does, until as many as are asked for have passed, each unlike those before it. Where
none does one number of the request is changed, as little as goes, until one does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..design.field_limits import DesignError
from ..design.model import Design
from ..findings.advice import found_on
from ..findings.remarks import NOTE
from .candidates import (
    Candidates,
    candidates_of,
    found_for_each,
    given_of,
    limits_of,
    others_found,
    unknown_of,
    within,
)
from .changes import Change, changes_of, others_of, rounded
from .figures import FLANKS, Figures, design_of, figures_of, teeth_of
from .request import Request, faults_of, usual_tool

MOST = 3
"""Proposals on one request, if no other number is asked for."""
LITTLE = 0.1
"""Reserve up to which a pair is tried only if there is no better one."""
FAIR = 0.25
"""Reserve up to which the figures that it is made of are not relied on, and a pair is looked at whole."""
LOOKED = 64
"""Pairs of which paths are looked at, before all others."""
DOUBTFUL = 10
"""Pairs with a warning after which it is given up."""
UNLIKE = np.array([*np.radians([0.4, 0.4, 2.0, 2.0]), 0.25, 0.25])
"""Differences of cone angles, helix angles and shifts of which proposals have at least one."""
SHARES, BETWEEN, TRIES = (0.03, 0.1, 0.3, 1.0), 3, 3
"""Of the greatest change of a number in search of a request that works, shares tried between two of them, and
how many changes of which it is hoped are looked at whole."""
TIE = math.radians(0.02)
"""Difference of the larger cone angle below which proposals of least cones are ranked by their reserve."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A pair that closes as required, and its `figures`, those of one pair (2, 1)."""

    design: Design
    figures: Figures


class Refused(Exception):  # noqa: N818
    """Why no pair is proposed; `nearest` is a request near it for which there is one, None where none was
    found."""

    def __init__(self, reason: str, nearest: Request | None) -> None:
        """Take reason, in words, and nearest request."""
        self.reason, self.nearest = reason, nearest
        super().__init__(reason)


def propose(request: Request, most: int = MOST) -> tuple[Proposal, ...]:
    """Find pairs that close as required, the best first.

    Parameters
    ----------
    request : Request
    most : int
        Pairs to be found at the most.

    Returns
    -------
    tuple of Proposal
        At least one; `check` warns of none.

    Raises
    ------
    DesignError
        For a request that cannot be meant, with a line for each fault.
    Refused
        Where no pair was found.
    """
    if faults := faults_of(request):
        raise DesignError(faults)
    found = candidates_of(request)
    first = _chosen(request, found, most)
    if first.proposals:
        return first.proposals
    others = others_found(request)
    second = _chosen(request, others, most)
    if second.proposals:
        return second.proposals
    both = Candidates(np.concatenate((found.values, others.values), axis=1))
    raise Refused(_reason(request, first, second, both), _nearest(request))


class Choice(NamedTuple):
    """Proposals, and what is warned of the first pair that is looked at whole, None if nothing is."""

    proposals: tuple[Proposal, ...] = ()
    warning: str | None = None


def _chosen(request: Request, found: Candidates, most: int) -> Choice:
    """Choose among pairs that close."""
    if not within(request, found).any():
        return Choice()
    values, figures = _looked_at(request, found)
    seen = _plain(values)
    # What a parabola changes, or a tool that cuts far below the active flank, is not among the figures.
    usual = request.members[1].tool == usual_tool(request.module, request.pressure_angle)
    relied_on = FAIR if usual else math.inf
    chosen: list[int] = []
    warnings: list[str] = []
    for k in _ranked(request, values, figures):
        if chosen and figures.reserve[k] <= LITTLE:
            break
        if any((np.abs(seen[:, k] - seen[:, j]) < UNLIKE).all() for j in chosen):
            continue
        if figures.reserve[k] > relied_on or (text := _warning_of(design_of(request, values[:, k]))) is None:
            chosen.append(k)
        else:
            warnings.append(text)
        if len(chosen) == most or len(warnings) == DOUBTFUL:
            break
    proposals = tuple(Proposal(design_of(request, values[:, k]), figures.take([k])) for k in chosen)
    return Choice(proposals, next(iter(warnings), None))


def _warning_of(design: Design) -> str | None:
    """Give the first warning of `check`, if there is one."""
    return next((remark.text for remark in found_on(design) if remark.level != NOTE), None)


def _plain(values: FloatArray) -> FloatArray:
    """Give cones, helices and shifts (6, n) of which a pair, its mirror image and the same pair seen from
    behind, where toe is heel, have the same: right and left flanks are all they differ in."""
    plain = values[:6].copy()
    for pair in (plain[:2], plain[2:4]):
        larger = np.where(np.abs(pair[0]) > np.abs(pair[1]) - 1e-6, pair[0], pair[1])
        pair *= np.where(larger < 0.0, -1.0, 1.0)
    return plain


def _looked_at(request: Request, found: Candidates) -> tuple[FloatArray, Figures]:
    """Give pairs within the limits and their figures: the first by what their teeth leave, all if none of
    those is sound."""
    values = found.values[:, within(request, found)]
    teeth = teeth_of(request, values)
    ranked = _ranked(request, values, teeth)
    for rows in (ranked[:LOOKED], ranked):
        figures = figures_of(request, values[:, rows], teeth.take(rows))
        if len(rows) == len(ranked) or (figures.reserve > LITTLE).any():
            break
    return values[:, rows], figures


def _ranked(request: Request, values: FloatArray, figures: Figures) -> list[int]:
    """Give the pairs with a reserve, the greatest first; where cones are to be least, those of least ones. Of
    equals that one is first whose drive flanks are nearer to line contact, then that of less helix. If there
    is none, the pair that lacks least: the clearance of tips, for one, is an estimate."""
    drive = figures.crossing[FLANKS.index(request.flank)]
    helix = np.abs(values[2:4]).max(axis=0)
    keys: list[NDArray[Any]] = [helix, np.round(np.abs(drive) / TIE), -np.round(figures.reserve, 2)]
    if request.least_cones:
        keys += [np.round(np.abs(values[:2]).max(axis=0) / TIE), figures.reserve <= 0.0]
    ranked = [int(k) for k in np.lexsort(keys) if figures.possible[k]]
    return ranked or [int(np.argmax(figures.reserve))]


def _reason(request: Request, first: Choice, second: Choice, both: Candidates) -> str:
    """Say why there is no proposal: no pair closes, the limits leave none, or there is a warning."""
    if warning := first.warning or second.warning:
        return f"each pair that closes like this has a warning, the best: {warning}"
    if unknown_of(request) is None:
        return "as much is given as there is to be found, and it does not fit together"
    return _beyond(request, both.values) if both.values.size else "no pair closes like this"


def _beyond(request: Request, values: FloatArray) -> str:
    """Say which limits the pair nearest to them passes."""
    limits = limits_of(request)
    low, high = np.array(limits)[:, :1], np.array(limits)[:, 1:]
    past = np.maximum(np.maximum(low - values[:6], values[:6] - high) / (high - low + 1e-9), 0.0)
    past[list(given_of(request))] = 0.0
    k = int(np.argmin(past.sum(axis=0)))
    names, units = (
        ("cone angles", "helix angles", "profile shifts"),
        (math.degrees(1.0), math.degrees(1.0), 1.0),
    )
    j = next(j for j in range(3) if past[2 * j : 2 * j + 2, k].any())
    shown = " and ".join(f"{units[j] * value:.3g}" for value in values[2 * j : 2 * j + 2, k])
    unit = "" if j == 2 else " deg"
    bounds = " to ".join(f"{units[j] * bound:g}" for bound in limits[2 * j])
    return f"it would take {names[j]} of {shown}{unit}, beyond the limits {bounds}"


def _nearest(request: Request) -> Request | None:
    """Find a request for which there is a pair, one number of it changed as little as goes; else the first
    that gives less."""
    tried = [(change, share) for share in SHARES for change in changes_of(request)]
    for _ in range(TRIES):
        if (first := _first_hopeful(request, tried)) is None:
            break
        change, share = tried[first]
        tried = tried[first + 1 :]
        fails = max((each for each in SHARES if each < share), default=0.0)
        nearer = [(change, float(each)) for each in np.linspace(fails, share, 2 + BETWEEN)[1:-1]]
        least = _first_hopeful(request, nearer)
        for reached in (share,) if least is None else (nearer[least][1], share):
            for digits in (3, 5):
                if works(changed := rounded(change(reached), request, digits)):
                    return changed
    return next((other for other in others_of(request) if works(other)), None)


def _first_hopeful(request: Request, tried: list[tuple[Change, float]]) -> int | None:
    """Find the first of changes, with their shares, for which figures promise a pair."""
    requests = [change(share) for change, share in tried]
    numbers = [number for number, one in enumerate(requests) if not faults_of(one)]
    changed = [requests[number] for number in numbers]
    if not changed or unknown_of(request) is None:
        return None
    found, owner = found_for_each(changed)
    kept = within(request, found)
    values, owner = found.values[:, kept], owner[kept]
    teeth = teeth_of(request, values)
    sound = np.flatnonzero(teeth.reserve > LITTLE)
    for start in range(0, sound.size, LOOKED):
        rows = sound[start : start + LOOKED]
        hopeful = owner[rows[figures_of(request, values[:, rows], teeth.take(rows)).reserve > LITTLE]]
        if hopeful.size:
            return numbers[int(hopeful[0])]
    return None


def works(request: Request) -> bool:
    """Tell whether there is a proposal on a request."""
    if faults_of(request):
        return False
    return bool(_chosen(request, candidates_of(request), 1).proposals)
