"""The whole run: `OPENBLAS_NUM_THREADS=1 python -m tests.proposal.whole_run 1000` answers as many random requests of all kinds, checks
every answer, every refusal and the request that each names, lets the grid search try what is refused, and prints
how many are solved by layout, and the time that it takes on one core."""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

from beveloid_geom import DesignError
from beveloid_geom.proposal.propose import Refused, propose
from beveloid_geom.proposal.request import Request
from beveloid_geom.proposal.words import refusal
from tests.proposal.grid_search import answers, grid_search_solves
from tests.proposal.requests import KINDS, random_requests


def layout_of(request: Request) -> str:
    """Name the layout of a request."""
    if request.shaft_angle == 0.0:
        return "parallel"
    return "intersecting" if request.offset == 0.0 else "crossed"


def main(count: int, seed: int) -> None:
    """Answer random requests and print what comes of them."""
    seconds: dict[str, list[float]] = {"answers": [], "refusals": []}
    counts: Counter[tuple[str, str]] = Counter()
    for number, request in enumerate(random_requests(count, seed)):
        start, layout = time.process_time(), layout_of(request)
        try:
            proposals = propose(request)
        except Refused as error:
            seconds["refusals"].append(time.process_time() - start)
            counts[layout, "refused"] += 1
            if error.nearest is None or "\n" in refusal(request, error.reason, error.nearest):
                print(number, KINDS[number % len(KINDS)], "no nearest request", request, flush=True)
            elif not answers(error.nearest, propose(error.nearest, 1)[0].design):
                print(number, KINDS[number % len(KINDS)], "nearest request warns", request, flush=True)
            if grid_search_solves(request) is not None:
                counts[layout, "missed"] += 1
                print(number, KINDS[number % len(KINDS)], "missed", error.reason, flush=True)
        except DesignError:
            counts[layout, "cannot be meant"] += 1
        else:
            seconds["answers"].append(time.process_time() - start)
            counts[layout, "solved"] += 1
            for proposal in proposals:
                if not answers(request, proposal.design):
                    print(number, KINDS[number % len(KINDS)], "answer warns", request, flush=True)
    for (layout, what), found in sorted(counts.items()):
        print(f"{layout:14}{what:18}{found:5}")
    for what, taken in (*seconds.items(), ("all", [*seconds["answers"], *seconds["refusals"]])):
        print(
            f"{what:10}{len(taken):5}, median {np.median(taken):.3f} s, 90 % {np.quantile(taken, 0.9):.3f} s"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1)
