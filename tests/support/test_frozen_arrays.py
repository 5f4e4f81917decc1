"""Cached results and inputs: read-only arrays, copies, threads and processes."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from copy import deepcopy
from dataclasses import is_dataclass
from multiprocessing import get_context
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, Errors, mesh_cycle, mounted_backlash, path_certificate, path_of_contact
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.proximity.flank_mesh import flank_mesh
from tests.oracle.table1 import table1

TABLE = table1()
CACHED: dict[str, Callable[[Design], Any]] = {
    "backlash": mounted_backlash,
    "mounting": mounting_of,
    "mesh of a flank": lambda design: flank_mesh(design.pinion, "right", 0.05),
}
"""Functions that return the same arrays to all callers."""
RESULTS: dict[str, Callable[[Design], Any]] = {
    "path": path_of_contact,
    "certificate": lambda design: path_certificate(path_of_contact(design, points=5)),
    "cycle": lambda design: mesh_cycle(design, "right", 2),
    "backlash": mounted_backlash,
    "mounting": mounting_of,
}
OTHERS = [table1((0.0002 * k, -0.001), Errors(offset=0.01 * k)) for k in range(4)]


def arrays(value: object) -> Iterator[np.ndarray]:
    """Yield all arrays in dataclasses, mappings, lists and tuples."""
    if isinstance(value, np.ndarray):
        yield value
    elif is_dataclass(value) or isinstance(value, dict | MappingProxyType):
        for part in (dict(value) if not is_dataclass(value) else vars(value)).values():
            yield from arrays(part)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from arrays(part)


@pytest.mark.parametrize("name", CACHED)
def test_cached_results_cannot_be_written(name: str) -> None:
    result = CACHED[name](TABLE)
    assert CACHED[name](TABLE) is result or np.shares_memory(
        next(arrays(result)), next(arrays(CACHED[name](TABLE)))
    )
    assert not any(array.flags.writeable for array in arrays(result))


def bytes_of(result: object) -> list[bytes]:
    """Return the bytes of all arrays of a result."""
    return [array.tobytes() for array in arrays(result)]


def computed(design: Design) -> list[bytes]:
    return [content for result in RESULTS.values() for content in bytes_of(result(design))]


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize("copy", [lambda x: pickle.loads(pickle.dumps(x)), deepcopy], ids=["pickle", "copy"])
def test_copies_are_equal_and_copies_of_cached_results_are_read_only(
    name: str, copy: Callable[[Any], Any]
) -> None:
    result = RESULTS[name](OTHERS[1])
    again = copy(result)
    assert bytes_of(again) == bytes_of(result)
    if name in CACHED:
        assert not any(array.flags.writeable for array in arrays(again))


@pytest.mark.slow
def test_threads_and_processes_compute_the_same() -> None:
    """Eight threads with two designs each, and a new process; all results are equal in all bits."""
    expected = [computed(design) for design in OTHERS]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(computed, 4 * OTHERS)) == 4 * expected
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert list(pool.map(computed, OTHERS[:2])) == expected[:2]
