"""Proposals for a request, the best first, or the reason why there are none.

Many pairs meet the requirements. The pairs within the limits are sorted by their reserve (`merit`) and
checked as by `check`, until the requested number has passed; each proposal differs from the earlier ones. If
no pair passes, `Refused` is raised. It names the nearest request with a proposal, in which one quantity is
changed as little as possible.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import FLANKS, FloatArray
from ..design.arguments import require_integers
from ..design.field_limits import DesignError
from ..design.model import Design
from ..findings.advice import iter_findings
from ..findings.diagnostics import NOTE
from ..support.array_repr import short_repr
from .candidates import (
    candidates_of,
    found_for_each,
    given_of,
    other_pairs,
    unknown_of,
    variable_limits,
    within,
)
from .merit import PairCriteria, criteria_of, design_of, tooth_criteria
from .relaxation import Change, others_of, request_changes, rounded_request
from .request import Request, faults_of, usual_tool

SMALL_RESERVE = 0.1
"""Reserve up to which a pair is tried only if there is no better one."""
FAIR_RESERVE = 0.25
"""Reserve up to which a pair is checked completely. Above this value, the criteria of the reserve are relied
on."""
FIRST_PATHS = 64
"""Number of pairs whose paths are computed first."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """Pair that satisfies the requirements.

    Attributes
    ----------
    design : Design
        The pair.
    criteria : PairCriteria
        Values of its criteria.
    """

    design: Design
    criteria: PairCriteria

    __repr__ = short_repr


class Refused(Exception):  # noqa: N818
    """Reason why no pair is proposed. `nearest` is a similar request with a proposal, None if none was
    found."""

    def __init__(self, reason: str, nearest: Request | None) -> None:
        """Store the reason and the nearest request."""
        self.reason, self.nearest = reason, nearest
        super().__init__(reason)


def propose(request: Request, most: int = 3) -> tuple[Proposal, ...]:
    """Return pairs that satisfy a request and have no warning of `check`, the best first.

    Parameters
    ----------
    request : Request
    most : int
        Largest number of pairs.

    Returns
    -------
    tuple of Proposal
        At least one.

    Raises
    ------
    DesignError
        If the request has faults, with one line for each.
    Refused
        If no pair was found.

    References
    ----------
    Equations: beveloid_geom/proposal/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> request = bg.Request(
    ...     module=4.0, teeth=(25, 31), face_widths=(30.0, 30.0), backlash=0.05, shaft_angle=0.35,
    ...     cone_angles=(0.05, 0.09),
    ... )
    >>> (best,) = bg.propose(request, most=1)
    >>> print(f"{best.design.pair.offset:.1f} mm")
    127.8 mm
    """
    require_integers(most=most)
    if faults := faults_of(request):
        raise DesignError(faults)
    candidates = candidates_of(request)
    first = _chosen(request, candidates, most)
    if first.proposals:
        return first.proposals
    others = other_pairs(request)
    second = _chosen(request, others, most)
    if second.proposals:
        return second.proposals
    both = np.concatenate((candidates, others), axis=1)
    raise Refused(_reason(request, first, second, both), _nearest(request))


class Choice(NamedTuple):
    """Proposals, and the first warning of a completely checked pair (None without one)."""

    proposals: tuple[Proposal, ...] = ()
    warning: str | None = None


def _chosen(request: Request, candidates: FloatArray, most: int) -> Choice:
    """Return the best candidates within the limits that have no warning."""
    # Number of pairs with a warning after which the search is stopped.
    max_warnings = 10
    if not within(request, candidates).any():
        return Choice()
    values, criteria = _evaluated(request, candidates)
    compared = _without_symmetry(values)
    # The criteria do not cover parabolas and tools that cut far below the active flank.
    usual = request.members[1].tool == usual_tool(request.module, request.pressure_angle)
    reliable = FAIR_RESERVE if usual else math.inf
    # On parallel axes, the tips of a possible pair are clear of the fillets, so that only flanks can touch.
    certified = not usual or request.shaft_angle > 0.0
    chosen: list[int] = []
    warnings: list[str] = []
    # Differences of cone angles, helix angles (rad) and shifts; two proposals have at least one of them.
    least_difference = np.array([*np.radians([0.4, 0.4, 2.0, 2.0]), 0.25, 0.25])
    for k in _ranked(request, values, criteria):
        if chosen and criteria.reserve[k] <= SMALL_RESERVE:
            break
        if any((np.abs(compared[:, k] - compared[:, j]) < least_difference).all() for j in chosen):
            continue
        text = None
        if not criteria.reserve[k] > reliable:
            text = _warning_of(design_of(request, values[:, k]), certified)
        if text is None:
            chosen.append(k)
        else:
            warnings.append(text)
        if len(chosen) == most or len(warnings) == max_warnings:
            break
    proposals = tuple(Proposal(design_of(request, values[:, k]), criteria.take([k])) for k in chosen)
    return Choice(proposals, next(iter(warnings), None))


def _warning_of(design: Design, certified: bool) -> str | None:
    """Return the first warning of `check`, with or without a certificate, None without a warning."""
    remarks = iter_findings(design, certified=certified)
    return next((remark.text for remark in remarks if remark.level != NOTE), None)


def _without_symmetry(values: FloatArray) -> FloatArray:
    """Return cone angles, helix angles and shifts (6, n) in a form that is equal for equivalent pairs.

    Equivalent are a pair, its mirror image, and the pair with toe and heel exchanged. They differ only in
    right and left flanks."""
    plain = values[:6].copy()
    for pair in (plain[:2], plain[2:4]):
        larger = np.where(np.abs(pair[0]) > np.abs(pair[1]) - 1e-6, pair[0], pair[1])
        pair *= np.where(larger < 0.0, -1.0, 1.0)
    return plain


def _evaluated(request: Request, candidates: FloatArray) -> tuple[FloatArray, PairCriteria]:
    """Return pairs within the limits and all their criteria.

    The paths of the FIRST_PATHS best pairs are computed first, and those of all pairs if none of these has a
    sufficient reserve."""
    values = candidates[:, within(request, candidates)]
    teeth = tooth_criteria(request, values)
    ranked = _ranked(request, values, teeth)
    for rows in (ranked[:FIRST_PATHS], ranked):
        criteria = criteria_of(request, values[:, rows], teeth.take(rows))
        if len(rows) == len(ranked) or (criteria.reserve > SMALL_RESERVE).any():
            break
    return values[:, rows], criteria


def _ranked(request: Request, values: FloatArray, criteria: PairCriteria) -> list[int]:
    """Return the possible pairs, the best first.

    The keys of the order are, the first most important: a positive reserve and the smallest cones, if least
    cones are required; a reserve above FAIR_RESERVE without steep helix angles; the largest reserve; drive
    flanks nearest to line contact; the smallest helix angle. If no pair is possible, the pair with the
    largest reserve is returned, because its tip clearance is an estimate."""
    # Helix angle above which pairs with a reserve above FAIR_RESERVE come after pairs with smaller
    # helix angles, rad.
    steep_helix = math.radians(31.0)
    # Difference of the larger cone angles below which pairs are sorted by their reserve, rad.
    cone_tie = math.radians(0.02)
    drive = criteria.crossing[FLANKS.index(request.flank)]
    helix = np.abs(values[2:4]).max(axis=0)
    keys: list[NDArray[Any]] = [helix, np.round(np.abs(drive) / cone_tie), -np.round(criteria.reserve, 2)]
    # Steep helix angles cause axial forces: a pair with a fair reserve and a smaller helix angle is better.
    keys.append(np.where(criteria.reserve > FAIR_RESERVE, np.where(helix > steep_helix, 1, 0), 2))
    if request.least_cones:
        keys += [np.round(np.abs(values[:2]).max(axis=0) / cone_tie), criteria.reserve <= 0.0]
    ranked = [int(k) for k in np.lexsort(keys) if criteria.possible[k]]
    return ranked or [int(np.argmax(criteria.reserve))]


def _reason(request: Request, first: Choice, second: Choice, both: FloatArray) -> str:
    """Return why there is no proposal: no pair meets the requirements, the limits exclude all, or all have a
    warning."""
    if warning := first.warning or second.warning:
        return f"each pair that meets these requirements has a warning, the best one: {warning}"
    if unknown_of(request) is None:
        return "all quantities are given, and they do not fit together"
    return _beyond(request, both) if both.size else "no pair meets these requirements"


def _beyond(request: Request, values: FloatArray) -> str:
    """Return the limits that are exceeded by the pair nearest to them."""
    limits = variable_limits(request)
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
    return f"the request needs {names[j]} of {shown}{unit}, beyond the limits {bounds}"


def _nearest(request: Request) -> Request | None:
    """Return a request with a proposal, with one quantity changed as little as possible, or with fewer given
    quantities."""
    # Fractions of the largest change of a quantity that are tried in the search for a request with a
    # proposal.
    change_shares = (0.03, 0.1, 0.3, 1.0)
    tried = [(change, share) for share in change_shares for change in request_changes(request)]
    # Number of values tried between two fractions, and number of changes that are checked completely.
    subdivisions, max_checked_changes = 3, 3
    for _ in range(max_checked_changes):
        if (first := _first_promising(request, tried)) is None:
            break
        change, share = tried[first]
        tried = tried[first + 1 :]
        fails = max((each for each in change_shares if each < share), default=0.0)
        nearer = [(change, float(each)) for each in np.linspace(fails, share, 2 + subdivisions)[1:-1]]
        least = _first_promising(request, nearer)
        for reached in (share,) if least is None else (nearer[least][1], share):
            for digits in (3, 5):
                if works(changed := rounded_request(change(reached), request, digits)):
                    return changed
    return next((other for other in others_of(request) if works(other)), None)


def _first_promising(request: Request, tried: list[tuple[Change, float]]) -> int | None:
    """Return the index of the first change whose criteria promise a proposal, None without any.

    `tried` contains changes and their fractions."""
    requests = [change(share) for change, share in tried]
    numbers = [number for number, each in enumerate(requests) if not faults_of(each)]
    changed = [requests[number] for number in numbers]
    if not changed or unknown_of(request) is None:
        return None
    pairs, owner = found_for_each(changed)
    inside = within(request, pairs)
    values, owner = pairs[:, inside], owner[inside]
    teeth = tooth_criteria(request, values)
    sound = np.flatnonzero(teeth.reserve > SMALL_RESERVE)
    for start in range(0, sound.size, FIRST_PATHS):
        rows = sound[start : start + FIRST_PATHS]
        promising = owner[
            rows[criteria_of(request, values[:, rows], teeth.take(rows)).reserve > SMALL_RESERVE]
        ]
        if promising.size:
            return numbers[int(promising[0])]
    return None


def works(request: Request) -> bool:
    """Return whether a request has a proposal among the pairs with rounded free quantities.

    `propose` also searches pairs without rounded quantities, so that it may find more."""
    if faults_of(request):
        return False
    return bool(_chosen(request, candidates_of(request), 1).proposals)
