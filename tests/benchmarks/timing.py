"""Timing functions of the benchmarks."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping


def best(
    work: Callable[[], object], repeat: int = 3, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return the smallest time of some runs, s: wall time, or the time of another clock."""
    times = []
    for _ in range(repeat):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def timed(title: str, works: Mapping[str, tuple[Callable[[], object], int, int]]) -> dict[str, float]:
    """Return the time of one item (s) of each of `works` (callable, number of runs, number of items), and
    print it."""
    print(f"\n{title}")
    found = {}
    for name, (work, repeat, items) in works.items():
        seconds = best(work, repeat)
        found[name] = seconds / items
        print(f"  {name:42s} {1e3 * seconds:10.2f} ms, {1e6 * found[name]:10.3f} us each of {items:,}")
    return found
