"""Tolerance study: the path of contact of a design in many mountings with drawn assembly errors.

The four errors of Fig. 5, or the five at the mesh, are drawn independently, normal or uniform, and add to
the design's own.
Every mounting is solved; one without a path on the flanks keeps its status and holds NaN.

Mountings are drawn and solved by units of UNIT, each with a random stream of its own, spawned from
the seed. The result is the same bit for bit however the units are spread: in this process, or by
any `concurrent.futures.Executor` over threads, processes or the machines of a cluster (alike: another
processor or NumPy may round otherwise). Mountings drawn depend on neither flank nor design: both
flanks with one seed are the same gearboxes.

The transmission error is that of one tooth pair on its path (as in `path`). Where it is lowest at
the ends of the path the next pair's edge touches first, and in operation it is another
(`operation`), which `tolerance_study` also finds, of as many of the first mountings as asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask, flank_sign
from ..contact.parallel.lines import touches_along_lines
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design, ErrorsAt
from ..operation.backlash_by_tangency import TangentBacklash, jammed, tangent_backlash
from ..pair.errors import ANGLES, ERROR_NAMES, MESH_ERROR_NAMES, NAMES, errors_below, mounted
from ..status import Limit, Status
from ..support.few_lines import few_lines
from .running import TOGETHER, Running, all_of, running
from .sliding import least_along

Distribution: TypeAlias = Literal["normal", "uniform"]
PLACES = ("enter", "middle", "leave")
"""The columns of positions: the ends of the path and its mid-roll."""
UNIT = 1024
"""Mountings drawn from one random stream and solved in one call."""
POINTS = 17
"""Positions of a path, from which its extreme transmission errors are interpolated."""
RUNNING_COST = 48
"""Mountings whose paths take as long as one in operation."""
SHARES = (0.0, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 1.0)
"""Quantiles of a report."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of the assembly errors, mm and rad, at least 0 (not drawn): of those about the common
    perpendicular or of those at the mesh.

    'uniform': errors lie evenly within plus and minus the tolerance. 'normal': their mean is 0 and
    the tolerance is `sigmas` standard deviations; they are not cut off there."""

    offset: float = 0.0
    shaft_angle: float = 0.0
    pinion_axial: float = 0.0
    gear_axial: float = 0.0
    distribution: Distribution = "normal"
    sigmas: float = 3.0
    centre_distance: float = 0.0
    in_plane: float = 0.0
    out_of_plane: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the errors that are drawn: those at the mesh where one of them alone has a
        tolerance."""
        at_mesh = any(getattr(self, name) for name in MESH_ERROR_NAMES if name not in ERROR_NAMES)
        return MESH_ERROR_NAMES if at_mesh else ERROR_NAMES

    def values(self) -> FloatArray:
        """Give the tolerances, in the order of `names`."""
        return np.array([getattr(self, name) for name in self.names], dtype=float)


USUAL = Tolerances(offset=0.05, shaft_angle=math.radians(0.01), pinion_axial=0.1, gear_axial=0.1)
"""Tolerances where none are given, as in figures: those of a well machined housing of some 200 mm."""
USUAL_AT: dict[ErrorsAt, Tolerances] = {
    "perpendicular": USUAL,
    "mesh": Tolerances(
        centre_distance=USUAL.offset,
        in_plane=USUAL.shaft_angle,
        out_of_plane=USUAL.shaft_angle,
        pinion_axial=USUAL.pinion_axial,
        gear_axial=USUAL.gear_axial,
    ),
}
"""The same by where a design has its errors measured."""


@dataclass(frozen=True, eq=False)
class Mountings:
    """Paths of contact of n mountings; NaN where a mounting has no path.

    `errors` (n, names): drawn errors by the names of the tolerances, mm and rad, without the design's own.
    `status` (n): codes of `Status`. `limit` (n, 2): codes of `Limit` where the path enters and
    leaves, -1 without a path. `pieces` (n): in how many the path lies on the flanks.
    `contact_ratio` (n): Eq. 16, 0 without contact on the flanks. `peak_to_peak` (n): greatest less
    least transmission error of the path, rad. `pinion_z, pinion_r, gear_z, gear_r` (n, 3), mm:
    where it enters, at mid-roll, where it leaves. `normal_backlash` (n), mm: least over a mesh cycle by
    tangency, with or without a path on these flanks, and `tangency` (n), codes of `Tangency`, what it is
    for the teeth; `jammed` (n): whether it is too little to put the pair together."""

    __repr__ = few_lines

    errors: FloatArray
    status: Codes
    limit: Codes
    pieces: Integers
    contact_ratio: FloatArray
    peak_to_peak: FloatArray
    pinion_z: FloatArray
    pinion_r: FloatArray
    gear_z: FloatArray
    gear_r: FloatArray
    normal_backlash: FloatArray
    tangency: Codes
    jammed: Mask

    @property
    def solved(self) -> Mask:
        """The mountings with a path on the flanks."""
        return np.asarray(self.status == Status.SOLVED)

    def quantities(self) -> dict[str, FloatArray]:
        """Find what a study gives the spread of, by name, each (n,): mm and rad."""
        names = "contact_ratio", "peak_to_peak", "normal_backlash"
        found = {name: getattr(self, name) for name in names}
        for name in ("pinion_z", "gear_z"):
            found |= {f"{name}_{place}": getattr(self, name)[:, k] for k, place in enumerate(PLACES)}
        return found


@dataclass(frozen=True, eq=False)
class ToleranceStudy:
    """Paths of contact of a design as it is (`nominal`, one mounting) and under drawn errors; and the first
    mountings in operation, as many as were asked for, with the design as it is (`nominal_running`)."""

    __repr__ = few_lines

    flank: str
    tolerances: Tolerances
    seed: int
    nominal: Mountings
    mountings: Mountings
    nominal_running: Running | None = None
    running: Running | None = None

    @property
    def cases(self) -> int:
        """Number of mountings."""
        return int(self.mountings.status.size)

    def status_counts(self) -> dict[Status, int]:
        """Mountings of each status, all statuses."""
        count = np.bincount(self.mountings.status, minlength=len(Status))
        return {status: int(count[status]) for status in Status}

    def limit_counts(self) -> dict[tuple[Limit, Limit], int]:
        """Mountings with a path by the limits (enter, leave) that end it, the most frequent first."""
        pairs, count = np.unique(self.mountings.limit[self.mountings.solved], axis=0, return_counts=True)
        order = np.argsort(-count, kind="stable")
        return {(Limit(pairs[k, 0]), Limit(pairs[k, 1])): int(count[k]) for k in order}

    def limits_changed(self) -> int:
        """Mountings with a path that another limit ends than that of the design as it is."""
        changed = (self.mountings.limit != self.nominal.limit).any(axis=1)
        return int(np.count_nonzero(changed & self.mountings.solved))

    def quantiles(self, shares: Sequence[float] = SHARES) -> dict[str, FloatArray]:
        """Find quantiles (shares) of the quantities over the mountings with a path, and of those in operation
        over the mountings for which they are known; NaN without any.

        Mountings without a path are in `status_counts`, not here."""
        solved = self.mountings.solved
        found = {name: value[solved] for name, value in self.mountings.quantities().items()}
        found |= self.running.quantities() if self.running else {}
        known = {name: value[~np.isnan(value)] for name, value in found.items()}
        nothing = np.full(len(shares), np.nan)
        return {name: np.quantile(value, shares) if value.size else nothing for name, value in known.items()}


@dataclass(frozen=True)
class _Task:
    """A piece of work that pickles: `cases` mountings from the start of the unit `unit` on."""

    design: Design
    flanks: Sequence[str]
    tolerances: Tolerances
    seed: int
    unit: int
    cases: int


def tolerance_study(
    design: Design,
    tolerances: Tolerances,
    flank: str = "right",
    cases: int = 100_000,
    *,
    seed: int = 0,
    operation: int = 0,
    executor: Executor | None = None,
    units_per_task: int = 4,
    progress: Callable[[int], object] | None = None,
) -> ToleranceStudy:
    """Solve a design in many mountings with drawn assembly errors.

    Parameters
    ----------
    design : Design
        A single one; drawn errors add to its own.
    tolerances : Tolerances
    flank : {'right', 'left'}
    cases : int
        Mountings. A study with more begins with the same ones.
    seed : int
    operation : int
        Mountings, the first ones drawn, that are studied in operation, too.
    executor : concurrent.futures.Executor, optional
        Spreads the work, `units_per_task` units of UNIT mountings at a time; neither changes the result by
        a bit.
    progress : callable, optional
        Called with the work done since: 1 a mounting, RUNNING_COST more for one in operation.

    Returns
    -------
    ToleranceStudy

    Raises
    ------
    ValueError
        For a batch, tolerances that are negative, not finite or as large as the layout's own value, and
        counts below 1.

    Notes
    -----
    About 50 to 300 microseconds a mounting, of which the backlash takes a half; the few whose paths are
    followed by their length take some 10 ms, those of lines on parallel axes 3 to 5 ms. In operation
    a mounting takes some 5 to 10 ms, as long as four to six paths of 101 positions.
    """
    if not 0 <= operation <= cases:
        raise ValueError(f"operation must be 0 to {cases}, the number of mountings, got {operation}")
    (study,) = tolerance_studies(
        design,
        tolerances,
        (flank,),
        cases,
        seed=seed,
        executor=executor,
        units_per_task=units_per_task,
        progress=progress,
    )
    if not operation:
        return study
    names, spread = tolerances.names, map if executor is None else executor.map
    own, runs, first = np.zeros((1, len(names))), [], study.mountings.errors[:operation]
    starts = range(0, operation, TOGETHER)
    together = [mounted(design, first[start : start + TOGETHER], names) for start in starts]
    for run in spread(partial(running, flank=flank), together):
        runs.append(run)
        if progress is not None:
            progress(RUNNING_COST * run.status.size)
    return replace(study, running=all_of(runs), nominal_running=running(mounted(design, own, names), flank))


def tolerance_studies(
    design: Design,
    tolerances: Tolerances,
    flanks: Sequence[str],
    cases: int = 100_000,
    *,
    seed: int = 0,
    executor: Executor | None = None,
    units_per_task: int = 4,
    progress: Callable[[int], object] | None = None,
) -> tuple[ToleranceStudy, ...]:
    """Study several flanks in the same mountings, each as `tolerance_study` does, and their backlash, which
    is that of both, once. Arguments and ValueError as there; `progress` counts a mounting of all as 1."""
    for flank in flanks:
        _check(design, tolerances, flank, seed)
    if min(cases, units_per_task) < 1:
        raise ValueError(f"cases and units_per_task must be at least 1, got {cases} and {units_per_task}")
    step = UNIT * (1 if executor is None else units_per_task)
    tasks = [
        _Task(design, flanks, tolerances, seed, start // UNIT, min(step, cases - start))
        for start in range(0, cases, step)
    ]
    spread = map if executor is None else executor.map
    parts: list[list[Mountings]] = []
    for part in spread(_solved_task, tasks):
        parts.append(part)
        if progress is not None:
            progress(part[0].status.size)
    names = tolerances.names
    nominal = _solved(design, flanks, np.zeros((1, len(names))), names)
    found = zip(flanks, nominal, map(_joined, zip(*parts, strict=True)), strict=True)
    return tuple(ToleranceStudy(flank, tolerances, seed, own, all_) for flank, own, all_ in found)


def _check(design: Design, tolerances: Tolerances, flank: str, seed: int) -> None:
    flank_sign(flank)
    if design.batch_shape:
        raise ValueError("a tolerance study takes a single design: give its cases one by one")
    if seed < 0:
        raise ValueError(f"seed must be at least 0, got {seed}")
    if tolerances.distribution not in ("normal", "uniform"):
        raise ValueError(f"distribution must be 'normal' or 'uniform', got {tolerances.distribution!r}")
    if not 0.0 < tolerances.sigmas < np.inf:
        raise ValueError(f"sigmas must be positive and finite, got {tolerances.sigmas}")
    most, names = errors_below(design), tolerances.names
    for name in (name for place in NAMES.values() for name in place if name not in names):
        if getattr(tolerances, name):
            raise ValueError(
                f"tolerance of {name} is about the common perpendicular, others at the mesh: leave it out"
            )
    lean = next((name for name in names if name in ANGLES and getattr(tolerances, name) > 0.0), None)
    if lean is not None and bool(touches_along_lines(design, flank)):
        raise ValueError(
            f"tolerance of {lean} must be 0 where flanks touch along lines: every error of it puts the"
            " contact on an edge, parabolas keep it on the flanks"
        )
    for name in names:
        value, unit = getattr(tolerances, name), "rad" if name in ANGLES else "mm"
        if not 0.0 <= value < np.inf:
            raise ValueError(
                f"tolerance of {name} must be finite and at least 0 {unit}, got {value}: it holds both ways"
            )
        if value >= most.get(name, np.inf):
            raise ValueError(
                f"tolerance of {name} must be less than {most[name]:g} {unit} on this pair,"
                f" got {value:g}: is the unit right?"
            )


def drawn_errors(tolerances: Tolerances, seed: int, unit: int, cases: int) -> FloatArray:
    """Draw the errors (cases, names) of the first mountings of a unit, by the names of the tolerances, mm and
    rad.

    The stream is that of the child `unit` of numpy's SeedSequence of the seed. A tolerance changes
    its own error only."""
    # The key is what SeedSequence(seed).spawn gives its children; so a task needs no others.
    stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(unit,)))
    shape = (cases, len(tolerances.names))
    if tolerances.distribution == "uniform":
        drawn = stream.uniform(-1.0, 1.0, shape) * tolerances.values()
    else:
        drawn = stream.standard_normal(shape) * (tolerances.values() / tolerances.sigmas)
    return np.asarray(drawn + 0.0)  # no -0.0 where there is no tolerance


def _solved_task(task: _Task) -> list[Mountings]:
    """Give the mountings of a task by flank, unit by unit: rounding depends on what is solved in one call."""
    parts = []
    for k, start in enumerate(range(0, task.cases, UNIT)):
        errors = drawn_errors(task.tolerances, task.seed, task.unit + k, min(UNIT, task.cases - start))
        parts.append(_solved(task.design, task.flanks, errors, task.tolerances.names))
    return [_joined(of_flank) for of_flank in zip(*parts, strict=True)]


def _joined(parts: Sequence[Mountings]) -> Mountings:
    names = [field.name for field in fields(Mountings)]
    return Mountings(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _solved(
    design: Design, flanks: Sequence[str], errors: FloatArray, names: Sequence[str]
) -> list[Mountings]:
    """Mountings with these drawn errors (n, names) by flank, in one call."""
    cases = mounted(design, errors, names)
    paths = {flank: path_of_contact(cases, flank, POINTS) for flank in flanks}
    backlash = tangent_backlash(cases, {flank: path.ends for flank, path in paths.items()})
    return [_mountings(path, backlash, errors) for path in paths.values()]


def _mountings(path: ContactPath, backlash: TangentBacklash, errors: FloatArray) -> Mountings:
    at = [0, POINTS // 2, POINTS - 1]
    module = float(path.design.pinion.tool.normal_module)
    return Mountings(
        errors=errors,
        status=path.ends.status,
        limit=path.ends.limit,
        pieces=path.ends.pieces,
        contact_ratio=path.ends.contact_ratio,
        peak_to_peak=swing_of(path.transmission_error),
        pinion_z=path.pinion_z[:, at],
        pinion_r=path.pinion_r[:, at],
        gear_z=path.gear_z[:, at],
        gear_r=path.gear_r[:, at],
        normal_backlash=backlash.normal,
        tangency=backlash.status,
        jammed=jammed(backlash.normal, module),
    )


def swing_of(values: FloatArray) -> FloatArray:
    """Find the greatest less least value (...) of smooth curves through values (..., points) at equal
    steps."""
    place = np.broadcast_to(np.arange(values.shape[-1], dtype=float), values.shape)
    (_, least), (_, most) = (least_along(place, sign * values) for sign in (1.0, -1.0))
    return np.asarray(-least - most)
