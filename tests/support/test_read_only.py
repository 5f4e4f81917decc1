"""What is kept for the next who asks is read-only, wherever it is kept."""

from __future__ import annotations

import ast
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from copy import deepcopy
from dataclasses import is_dataclass
from functools import cached_property
from importlib import import_module
from inspect import isclass
from multiprocessing import get_context
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

import beveloid_geom
import beveloid_viz
from beveloid_geom import Design, Errors, certify, mesh_cycle, mounted_backlash, path_of_contact
from beveloid_geom.contact.equation import _kept_flanks
from beveloid_geom.gear.tooth_side import _kept_surface, surface_of
from beveloid_geom.operation.backlash import _kept_backlash
from beveloid_geom.operation.marking.least_over_roll import mating_of
from beveloid_geom.operation.marking.operating_rolls import first_contact_operation
from beveloid_geom.operation.mesh import _kept_phase
from beveloid_geom.operation.mesh_cycle import _gauss_points
from beveloid_geom.operation.search_starts import chart_of, grid_of
from beveloid_geom.pair.mounting import _kept_mounting, mounting_of
from beveloid_geom.report.operation import operation_report
from beveloid_geom.shapes.flank_mesh import flank_mesh
from beveloid_geom.studies.claims import Case
from beveloid_geom.support.chebyshev import _derivation
from beveloid_geom.support.quadratic_step import _candidates
from beveloid_geom.support.read_only import kept, read_only
from beveloid_viz.parts.motion_graph import motion_graph
from tests.oracle.table1 import table1

TABLE = table1()
ROOTS = [Path(package.__file__ or "").parent for package in (beveloid_geom, beveloid_viz)]
CACHES = {"lru_cache", "cache", "cached_property"}
KEPT: dict[str, Callable[[], object]] = {
    "beveloid_geom.contact.equation._kept_flanks": lambda: _kept_flanks(*TABLE.members, "right"),
    "beveloid_geom.support.chebyshev._derivation": lambda: _derivation(9),
    "beveloid_geom.design.model.Design.batch_shape": lambda: TABLE.batch_shape,
    "beveloid_geom.pair.mounting._kept_mounting": lambda: _kept_mounting(*TABLE.members, TABLE.pair),
    "beveloid_geom.operation.backlash._kept_backlash": lambda: _kept_backlash(TABLE),
    "beveloid_geom.operation.mesh._kept_phase": lambda: _kept_phase(TABLE, "right"),
    "beveloid_geom.operation.mesh_cycle._gauss_points": _gauss_points,
    "beveloid_geom.operation.marking.least_over_roll.Mating.poses": lambda: (
        mating_of(TABLE, "right", 0, first_contact_operation(TABLE, "right")).poses
    ),
    "beveloid_geom.support.quadratic_step._candidates": lambda: _candidates(4),
    "beveloid_geom.operation.search_starts.grid_of": lambda: grid_of(TABLE.pinion, "right", (1, 5, 5)),
    "beveloid_geom.operation.search_starts.chart_of": lambda: chart_of(
        surface_of(TABLE.gear, "right"), 1.0, 1.0
    ),
    "beveloid_geom.shapes.flank_mesh.flank_mesh": lambda: flank_mesh(TABLE.pinion, "right", 0.05),
    "beveloid_geom.studies.claims.Case.face": lambda: Case(TABLE, "right").face,
    "beveloid_geom.studies.claims.Case.modified": lambda: Case(TABLE, "right").modified,
    "beveloid_geom.studies.claims.Case.sweeps": lambda: Case(TABLE, "right").sweeps,
    "beveloid_geom.gear.tooth_side._kept_surface": lambda: _kept_surface(TABLE.pinion, "right"),
    "beveloid_viz.report.data.FlankResults.motion": lambda: read_only(
        motion_graph(operation_report("", TABLE, "right", 5, 1, 0.006))
    ),
    "beveloid_viz.report.data.PageData.found": lambda: True,  # it is a bool
}
"""An example of every result that a module keeps."""


def modules() -> Iterator[tuple[str, ast.Module]]:
    for root in ROOTS:
        for path in sorted(root.rglob("*.py")):
            parts = path.relative_to(root.parent).with_suffix("").parts
            yield ".".join(parts), ast.parse(path.read_text(encoding="utf-8"))


def caches() -> set[str]:
    """All functions and properties of the library and of viz that keep results."""
    found = set()
    for name, tree in modules():
        words = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        if not words & (CACHES | {"kept"}) or name.endswith("__init__"):
            continue
        module = import_module(name)
        for key, value in vars(module).items():
            if getattr(value, "__module__", None) != name:
                continue
            if hasattr(value, "cache_info"):
                found.add(f"{name}.{key}")
            elif isclass(value):
                own = (k for k, part in vars(value).items() if isinstance(part, cached_property))
                found |= {f"{name}.{key}.{k}" for k in own}
    return found


def arrays(value: object) -> Iterator[np.ndarray]:
    if isinstance(value, np.ndarray):
        yield value
    elif is_dataclass(value) or isinstance(value, dict | MappingProxyType):
        for part in (dict(value) if not is_dataclass(value) else vars(value)).values():
            yield from arrays(part)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from arrays(part)


def test_there_is_an_example_of_every_kept_result() -> None:
    assert caches() == set(KEPT)


def test_only_one_module_keeps_results_of_functions() -> None:
    """All others use `kept`, which makes them read-only."""
    users = [
        name
        for name, tree in modules()
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and node.id in {"lru_cache", "cache"}
    ]
    assert users == ["beveloid_geom.support.read_only"]


@pytest.mark.parametrize("make", KEPT.values(), ids=KEPT)
def test_kept_results_cannot_be_written_to(make: Callable[[], object]) -> None:
    assert not any(array.flags.writeable for array in arrays(make()))


def test_all_arrays_are_found() -> None:
    """In dataclasses, mappings and rows; one in another."""
    path = path_of_contact(TABLE, points=5)
    assert len(list(arrays(read_only([{"a": (path, 1.0)}, "b"])))) > 15
    assert not any(array.flags.writeable for array in arrays(path))


def test_functions_are_called_once() -> None:
    calls = []

    @kept(1)
    def squares(count: int) -> np.ndarray:
        calls.append(count)
        return np.arange(count) ** 2

    assert squares(3) is squares(3)
    assert calls == [3]
    assert squares.__name__ == "squares"
    with pytest.raises(ValueError, match="read-only"):
        squares(3)[0] = 1


RESULTS: dict[str, Callable[[Design], Any]] = {
    "path": path_of_contact,
    "certificate": lambda design: certify(path_of_contact(design, points=5)),
    "cycle": lambda design: mesh_cycle(design, "right", 2),
    "backlash": mounted_backlash,
    "mounting": mounting_of,
}
OTHERS = [table1((0.0002 * k, -0.001), Errors(offset=0.01 * k)) for k in range(4)]


def bytes_of(result: object) -> list[bytes]:
    """Of all arrays of a result, in order."""
    if isinstance(result, np.ndarray):
        return [result.tobytes()]
    parts = (
        result if isinstance(result, tuple | list) else vars(result).values() if is_dataclass(result) else ()
    )
    return [found for part in parts for found in bytes_of(part)]


def measured(design: Design) -> list[bytes]:
    return [found for result in RESULTS.values() for found in bytes_of(result(design))]


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize("made", [lambda x: pickle.loads(pickle.dumps(x)), deepcopy], ids=["pickle", "copy"])
def test_results_are_copied_as_they_are(name: str, made: Callable[[Any], Any]) -> None:
    result = RESULTS[name](OTHERS[1])
    again = made(result)
    assert bytes_of(again) == bytes_of(result)
    if name in ("backlash", "mounting"):  # kept
        assert not any(x.flags.writeable for x in vars(again).values() if isinstance(x, np.ndarray))


@pytest.mark.slow
def test_threads_and_other_processes_find_the_same() -> None:
    """Eight threads at two designs each, and a process that starts anew: bit by bit."""
    wanted = [measured(design) for design in OTHERS]
    for cache in (_kept_backlash, _kept_flanks, _kept_mounting, _kept_surface, _derivation):
        cache.cache_clear()
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(measured, 4 * OTHERS)) == 4 * wanted
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert list(pool.map(measured, OTHERS[:2])) == wanted[:2]
