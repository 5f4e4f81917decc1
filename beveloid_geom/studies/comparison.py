"""Every way of this package to find a contact, on the same positions: cost against true error.

`compare` gives a row for each method of `comparison_methods` and each setting. Positions are held by
the pinion's roll or by l1, which says the same; the truth is the five equations at 60 digits
(`reference.five_equations_mp`), by code that no method here shares.

- "mesh alone", "mesh, polished": proximity of sampled flanks over the sampling tolerance. Two to
  four queries a position, as the gear is turned until the flanks touch; all of them count.
- "five equations": SciPy's `fsolve` over its xtol, in scalar `math` (`reference`). Cold: each position
  from the pitch point; warm: each from the one before, in a run along the path.
- "one equation, path": `path_of_contact(points=n)` over n, with the exact ends; "one equation,
  given l1": the same at n given l1. The polynomials of the path are made anew in every call and count.
- "Newton on F": the plain iteration on the one equation over iterations and over batch sizes; points and
  rolls only, where a path has all of `ContactPath`.

`compare_first` does the same for what touches first of all teeth (`first_methods`): "grid, first contact"
over points a side, "mesh alone" and "mesh, polished" over all but the finest tolerances, "exact, first
contact" (`first_contact`) over the batch; the truth is the mesh cycle's exact pieces.

`seconds_per_position` is the processor time of a call, of all its threads, over its positions.
`setup_seconds` is that of what is kept between calls: the mounting distances for all; and the
constants of both flanks (one equation), the meshes, or the pitch point (five equations). Imports
never count.

Errors are the largest over the positions. The transmission error is gear roll plus N1/N2 pinion
roll less its value at the middle position, for the truth as for every method.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from time import get_clock_info, perf_counter, process_time
from typing import TypeAlias, TypeVar

import numpy as np

from ..arrays import FloatArray
from ..contact.equation import pairing_of
from ..contact.path import path_of_contact
from ..design.model import Design
from ..pair.mounting import mounting_of
from ..reference import pitch_region
from ..shapes.flank_mesh import flank_mesh
from .comparison_methods import (
    COUNT,
    Answer,
    Positions,
    along,
    batches,
    five_answer,
    given_answer,
    mesh_answer,
    newton_answer,
    numbers_in,
    path_answer,
    true_positions,
)
from .first_methods import exact_answer, first_positions, first_turned, grid_answer

Result = TypeVar("Result")
FIRST = ", first contact"
GRID, EXACT = "grid" + FIRST, "exact" + FIRST
MOST = 1_000
"""Largest batch of first contacts."""
ARCSEC = 3600.0 * 180.0 / np.pi
CLOCK = process_time if get_clock_info("process_time").resolution < 1e-6 else perf_counter
"""Processor time, which other programs on the machine do not change; where that is coarse, the time."""
MEASURED, LONG = 1e-3, 0.05
"""s: what takes less is repeated within a measurement; what takes longer is measured once."""
SOLVED = "solved"


@dataclass(frozen=True)
class Settings:
    """What is tried: sampling tolerances (mm), xtol of `fsolve`, Newton iterations, batch sizes, points along
    a side of a grid.

    `passes`: iterations of Newton runs over the batch sizes; `batch`: batch of those over the
    iterations; `run`: positions of a warm run of the five equations; `repeat`: measurements of a time,
    of which the least counts. Batches of a path are rounded to 10 k + 1, as is `run`. Raises TypeError
    for what are no numbers, ValueError for numbers out of range."""

    tolerances: tuple[float, ...] = (0.1, 0.01, 0.001, 0.0003)
    xtols: tuple[float, ...] = (1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-14)
    iterations: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    batches: tuple[int, ...] = (1, 10, 100, 1_000, 10_000, 100_000)
    grids: tuple[int, ...] = (8, 16, 32, 64, 128, 256)
    passes: int = 4
    batch: int = 1_000
    run: int = 21
    repeat: int = 4

    def __post_init__(self) -> None:
        numbers_in("tolerances", self.tolerances)
        numbers_in("xtols", self.xtols)
        numbers_in("iterations", self.iterations, 0)
        numbers_in("batches", self.batches, 1)
        numbers_in("grids", self.grids, 2)
        for name, least in (("passes", 0), ("batch", 1), ("run", 1), ("repeat", 0)):
            numbers_in(name, (getattr(self, name),), least)


USUAL = Settings()


@dataclass(frozen=True)
class Row:
    """One method at one setting: `kind` (tolerance, xtol, iterations, batch, points) and its `value`.

    Errors are NaN where any position was not found, and `status` then says why, else "solved"."""

    method: str
    kind: str
    value: float
    error_mm: float
    transmission_error_arcsec: float
    seconds_per_position: float
    setup_seconds: float
    status: str


@dataclass(frozen=True, eq=False)
class _Trial:
    """A method at a setting; `work` answers for `count` positions, `setup` is what came before."""

    name: tuple[str, str, float]
    work: Callable[[], Answer]
    count: int
    setup: float


Trials: TypeAlias = tuple[Callable[[Positions, Settings], Iterator[_Trial]], ...]
MeshAnswer: TypeAlias = Callable[[Positions, float, bool], Answer]


def compare(design: Design, flank: str = "right", settings: Settings = USUAL) -> tuple[Row, ...]:
    """Rows of all methods at all settings; a method that fails has its row, with the reason.

    Raises TypeError, ValueError and ImportError as `true_positions` does, and TypeError for other settings
    than `Settings`."""
    if not isinstance(settings, Settings):
        raise TypeError(f"settings must be Settings, got {type(settings).__name__}")
    return _rows(true_positions(design, flank), TRIALS, settings)


def compare_first(design: Design, flank: str = "right", settings: Settings = USUAL) -> tuple[Row, ...]:
    """Give rows of all ways to find the first contact of all teeth.

    Raises ValueError where the first contacts of the mesh cycle are not known."""
    return _rows(first_positions(design, flank), FIRST_TRIALS, settings)


def _rows(positions: Positions, trials_of: Trials, settings: Settings) -> tuple[Row, ...]:
    """Run the trials one after the other, without collecting garbage meanwhile."""
    rows, methods, collecting = [], set[str](), gc.isenabled()
    gc.disable()  # as timeit does
    try:
        with np.errstate(all="ignore"):
            for trial in chain(*(trials(positions, settings) for trials in trials_of)):
                if trial.name[0] not in methods:  # the first call of a method imports
                    methods.add(trial.name[0])
                    _row(positions, trial, 0)
                rows.append(_row(positions, trial, settings.repeat))
    finally:
        if collecting:
            gc.enable()
    return tuple(rows)


def timed(work: Callable[[], Result], repeat: int = 3) -> tuple[Result, float]:
    """Measure the result and seconds of a call: the least of a first one and of `repeat` measurements after
    it; a long call is made once."""
    begin = CLOCK()
    result = work()
    first = best = CLOCK() - begin
    if first > LONG:
        return result, first
    number = max(1, int(MEASURED / first))
    for _ in range(repeat):
        begin = CLOCK()
        for _ in range(number):
            work()
        best = min(best, (CLOCK() - begin) / number)
    return result, best


def _row(positions: Positions, trial: _Trial, repeat: int) -> Row:
    """Run a trial and hold it against the truth."""
    nothing = float("nan")
    try:
        (point, roll), seconds = timed(trial.work, repeat)
        seconds /= trial.count
    except (ArithmeticError, ValueError) as error:
        return Row(*trial.name, nothing, nothing, nothing, trial.setup, str(error))
    lost = int(np.isnan(point.sum(axis=-1) + roll.sum(axis=0)).sum())
    if lost:
        reason = f"{lost} of {len(point)} positions not found"
        return Row(*trial.name, nothing, nothing, seconds, trial.setup, reason)
    away = np.linalg.norm(point - positions.point, axis=-1).max()
    true_roll = np.stack((positions.pinion_roll, positions.gear_roll))
    ahead = np.abs(_phase(positions.design, roll) - _phase(positions.design, true_roll)).max()
    return Row(*trial.name, float(away), float(ARCSEC * ahead), seconds, trial.setup, SOLVED)


def _phase(design: Design, roll: FloatArray) -> FloatArray:
    """Find the transmission error (n,), rad, from rolls (2, n) of any precision."""
    phase = roll[1].astype(float) + design.pinion.teeth / design.gear.teeth * roll[0].astype(float)
    return np.asarray(phase - phase[len(phase) // 2])


def _setup(design: Design, work: Callable[[Design], object], repeat: int) -> float:
    """Measure the seconds of the mounting distances and of `work`, on designs of which nothing is kept yet:
    the same but for the last digits of the face widths."""
    best = float("inf")
    for grown in 1.0 + 1e-9 * np.random.default_rng().random(repeat):
        pinion, gear = (replace(part, face_width=float(part.face_width * grown)) for part in design.members)
        fresh = replace(design, pinion=pinion, gear=gear)
        begin = CLOCK()
        mounting_of(fresh)
        work(fresh)
        best = min(best, CLOCK() - begin)
    return best


def _mesh_trials(
    positions: Positions, settings: Settings, answer: MeshAnswer = mesh_answer, what: str = ""
) -> Iterator[_Trial]:
    flank = positions.flank

    def sampled(tolerance: float, design: Design) -> None:
        for member in design.members:
            flank_mesh(member, flank, tolerance)

    for tolerance in settings.tolerances:
        sample = partial(sampled, tolerance)
        try:
            setup = _setup(positions.design, sample, 1)
            sample(positions.design)  # kept, so that the trial does not sample
        except ValueError:
            setup = float("nan")  # the trial meets the same and says why
        for method, polish in (("mesh alone", False), ("mesh, polished", True)):
            work = partial(answer, positions, tolerance, polish)
            yield _Trial((method + what, "tolerance", tolerance), work, COUNT, setup)


def _five_trials(positions: Positions, settings: Settings) -> Iterator[_Trial]:
    design, flank = positions.design, positions.flank
    size, picked = along(settings.run)
    run = path_of_contact(design, flank, size).pinion_roll.copy()
    run[picked] = positions.pinion_roll
    setup = _setup(design, lambda fresh: pitch_region.pitch_guess(fresh, flank), settings.repeat)
    for xtol in settings.xtols:
        cold = partial(five_answer, positions, xtol, positions.pinion_roll, slice(None), True)
        warm = partial(five_answer, positions, xtol, run, picked, False)
        yield _Trial(("five equations, cold", "xtol", xtol), cold, COUNT, setup)
        yield _Trial(("five equations, warm", "xtol", xtol), warm, size, setup)


def _path_trials(positions: Positions, settings: Settings) -> Iterator[_Trial]:
    setup = _setup(positions.design, lambda fresh: pairing_of(fresh, positions.flank), settings.repeat)
    for size in dict.fromkeys(along(batch)[0] for batch in settings.batches):
        yield _Trial(
            ("one equation, path", "batch", size), partial(path_answer, positions, size), size, setup
        )
    for batch in settings.batches:
        calls = batches(positions, batch)
        name, count = ("one equation, given l1", "batch", batch), sum(l1.size for l1 in calls)
        yield _Trial(name, partial(given_answer, positions, calls), count, setup)


def _newton_trials(positions: Positions, settings: Settings) -> Iterator[_Trial]:
    pairing = pairing_of(positions.design, positions.flank)
    setup = _setup(positions.design, lambda fresh: pairing_of(fresh, positions.flank), settings.repeat)
    runs = [("iterations", settings.batch, passes) for passes in settings.iterations]
    runs += [("batch", batch, settings.passes) for batch in settings.batches]
    for kind, batch, passes in runs:
        calls = batches(positions, batch)
        name = ("Newton on F", kind, passes if kind == "iterations" else batch)
        work = partial(newton_answer, pairing, calls, passes)
        yield _Trial(name, work, sum(l1.size for l1 in calls), setup)


def _first_trials(positions: Positions, settings: Settings) -> Iterator[_Trial]:
    setup = _setup(positions.design, lambda fresh: pairing_of(fresh, positions.flank), settings.repeat)
    for count in settings.grids:
        work = partial(grid_answer, positions, count)
        yield _Trial((GRID, "points", count), work, COUNT, setup)
    coarse = replace(settings, tolerances=settings.tolerances[: max(1, len(settings.tolerances) - 1)])
    yield from _mesh_trials(positions, coarse, partial(mesh_answer, turned=first_turned), FIRST)
    low, high = positions.pinion_roll[0], positions.pinion_roll[-1]
    for size in (batch for batch in settings.batches if COUNT <= batch <= MOST):
        rolls = np.append(positions.pinion_roll, np.linspace(low, high, size - COUNT))
        yield _Trial((EXACT, "batch", size), partial(exact_answer, positions, rolls), size, setup)


TRIALS: Trials = (_mesh_trials, _five_trials, _path_trials, _newton_trials)
FIRST_TRIALS: Trials = (_first_trials,)
"""All methods, in the order of the rows: of the tangency, and of first contacts."""
