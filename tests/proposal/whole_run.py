"""The whole run: `python -m tests.proposal.whole_run 1000` answers as many random requests of all kinds,
checks every answer, every refusal and the request that each names, lets the grid search try what is refused,
and prints what is amiss, how many are solved by layout, and the time that it takes on one core; further
arguments are the first number and the seed. With OPENBLAS_NUM_THREADS=1."""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

from beveloid_geom import DesignError
from beveloid_geom.proposal.propose import Proposal, Refused, propose
from beveloid_geom.proposal.request import Request
from beveloid_geom.proposal.words import refusal
from tests.proposal.grid_search import answers, grid_search_solves
from tests.proposal.requests import KINDS, random_requests

EVERY = 50
"""Requests after which it is said how far it is."""


def layout_of(request: Request) -> str:
    """Name the layout of a request."""
    if request.shaft_angle == 0.0:
        return "parallel"
    return "intersecting" if request.offset == 0.0 else "crossed"


def faults_in(request: Request, outcome: tuple[Proposal, ...] | Refused) -> list[str]:
    """Say what is amiss in proposals or in a refusal."""
    if not isinstance(outcome, Refused):
        return ["answer warns" for one in outcome if not answers(request, one.design)]
    found = ["missed"] if grid_search_solves(request) is not None else []
    if outcome.nearest is None or "\n" in refusal(request, outcome.reason, outcome.nearest):
        return [*found, "no nearest request"]
    if not answers(outcome.nearest, propose(outcome.nearest, 1)[0].design):
        found.append("nearest request warns")
    return found


def main(count: int, first: int = 0, seed: int = 1) -> None:
    """Answer random requests and print what comes of them."""
    seconds: dict[str, list[float]] = {"solved": [], "refused": []}
    counts: Counter[tuple[str, str]] = Counter()
    for number, request in enumerate(random_requests(first + count, seed)):
        if number < first:
            continue
        start, layout = time.process_time(), layout_of(request)
        try:
            outcome: tuple[Proposal, ...] | Refused = propose(request)
        except Refused as error:
            outcome = error
        except DesignError:
            counts[layout, "cannot be meant"] += 1
            continue
        what = "refused" if isinstance(outcome, Refused) else "solved"
        seconds[what].append(time.process_time() - start)
        counts[layout, what] += 1
        for fault in faults_in(request, outcome):
            counts[layout, fault] += 1
            print(number, KINDS[number % len(KINDS)], fault, flush=True)
        if number % EVERY == EVERY - 1:
            print(dict(counts), flush=True)
    for (layout, what), found in sorted(counts.items()):
        print(f"{layout:14}{what:22}{found:5}")
    for what, taken in (*seconds.items(), ("all", [*seconds["solved"], *seconds["refused"]])):
        median, most = np.quantile(taken, [0.5, 0.9])
        print(f"{what:10}{len(taken):5}, median {median:.3f} s, 90 % {most:.3f} s of one core")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
