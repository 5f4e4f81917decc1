"""What the benchmarks measure with."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping


def best(work: Callable[[], object], repeat: int = 3) -> float:
    """Least wall time of some runs, s."""
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def told(title: str, works: Mapping[str, tuple[Callable[[], object], int, int]]) -> dict[str, float]:
    """Time of one item (s) of each of `works` (what is done, how often, how many items it does), printed."""
    print(f"\n{title}")
    found = {}
    for name, (work, repeat, items) in works.items():
        seconds = best(work, repeat)
        found[name] = seconds / items
        print(f"  {name:42s} {1e3 * seconds:10.2f} ms, {1e6 * found[name]:10.3f} us each of {items:,}")
    return found
