"""Monte Carlo study of the path of contact under random assembly errors.

The four errors of Fig. 5, or the five errors at the mesh, are drawn independently from a normal or a uniform
distribution and are added to the errors of the design. Every mounting is solved. A mounting without a path on
the flanks keeps its status and holds NaN.

Mountings are drawn and solved in blocks of MOUNTINGS_PER_BLOCK. Each block has its own random stream, spawned
from the seed. Therefore the result is the same bit for bit in one process and with any
`concurrent.futures.Executor` over threads, processes or the machines of a cluster (of one processor type and
NumPy version; others may round differently). The drawn errors depend on neither flank nor design: the studies
of both flanks with one seed describe the same gearboxes.

The transmission error is that of one tooth pair on its path. If the gear is furthest ahead at the ends of the
path, the edge of the next pair touches first and the transmission error in operation is different.
`tolerance_study` therefore also computes the mesh cycles of the first mountings (`operation`). For those
among them whose paths move furthest along the face, it also computes at which edges the contact pattern
ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from ..arrays import FloatArray, Integers, Mask, flank_sign
from ..contact.parallel.lines import is_line_contact
from ..design.arguments import require_integers, require_numbers, require_single
from ..design.model import Design, ErrorsAt
from ..operation.contact_pattern.pattern import contact_pattern
from ..pair.misalignment import ANGLES, ERROR_NAMES, NAMES, errors_below, mounted, size_words
from ..status import Limit, Status
from ..support.argument import ArgumentError
from ..support.array_records import joined
from ..support.array_repr import short_repr
from .cycle_statistics import CYCLES_PER_CALL, CycleStatistics, cycle_statistics
from .mountings import Mountings, solved_mountings

Distribution: TypeAlias = Literal["normal", "uniform"]
MOUNTINGS_PER_BLOCK = 1024
"""Number of mountings that are drawn from one random stream and solved in one call."""
BLOCKS_PER_TASK = 4
"""Number of blocks that a worker process solves in one task."""
CYCLE_COST_PATHS = 48
"""Cost of a mounting in operation relative to that of its path, for the progress."""
LEAST_KNOWN_SHARE = 0.9
"""Share of known values below which there are no quantiles."""
QUANTILE_SHARES = (0.0, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 1.0)
"""Probabilities for which a report has quantiles."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of the assembly errors, at least 0. An error with the tolerance 0 is 0 in all mountings.

    Either the errors about the common perpendicular or those at the mesh have tolerances, not both.

    Attributes
    ----------
    offset, pinion_axial, gear_axial, centre_distance : float
        mm.
    shaft_angle, in_plane, out_of_plane : float
        rad.
    distribution : {'normal', 'uniform'}
        'uniform': errors are distributed evenly within plus and minus the tolerance. 'normal': the mean is 0
        and the tolerance is `sigmas` standard deviations; the distribution is not truncated.
    sigmas : float
    """

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
        """Names of the errors that are drawn: those at the mesh if an error that exists only there has a
        tolerance."""
        at_mesh = any(getattr(self, name) for name in NAMES["mesh"] if name not in ERROR_NAMES)
        return NAMES["mesh"] if at_mesh else ERROR_NAMES

    def values(self) -> FloatArray:
        """Return the tolerances in the order of `names`, mm and rad."""
        return np.array([getattr(self, name) for name in self.names], dtype=float)


USUAL = Tolerances(offset=0.05, shaft_angle=math.radians(0.01), pinion_axial=0.1, gear_axial=0.1)
"""Default tolerances: those of a well machined housing of about 200 mm."""
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
"""Default tolerances for errors about the common perpendicular and for errors at the mesh."""


@dataclass(frozen=True, eq=False)
class ToleranceStudy:
    """Paths of contact of a design without and with drawn errors.

    Attributes
    ----------
    flank : str
        Driving flank, 'right' or 'left'.
    tolerances : Tolerances
        Limits and distribution of the errors.
    seed : int
        Seed of the random errors.
    nominal, mountings : Mountings
        Results without drawn errors (one mounting) and with them.
    cycles, nominal_cycles : CycleStatistics or None
        Mesh cycles of the first mountings and of the design; None if they were not requested.
    """

    __repr__ = short_repr

    flank: str
    tolerances: Tolerances
    seed: int
    nominal: Mountings
    mountings: Mountings
    nominal_cycles: CycleStatistics | None = None
    cycles: CycleStatistics | None = None

    @property
    def cases(self) -> int:
        """Number of mountings."""
        return int(self.mountings.status.size)

    def status_counts(self) -> dict[Status, int]:
        """Return the number of mountings of each status."""
        count = np.bincount(self.mountings.status, minlength=len(Status))
        return {status: int(count[status]) for status in Status}

    def limit_counts(self) -> dict[tuple[Limit, Limit], int]:
        """Return the number of paths by the limits (enter, leave) that end them, the most frequent first."""
        pairs, count = np.unique(self.mountings.limit[self.mountings.solved], axis=0, return_counts=True)
        order = np.argsort(-count, kind="stable")
        return {(Limit(pairs[k, 0]), Limit(pairs[k, 1])): int(count[k]) for k in order}

    def limits_changed(self) -> int:
        """Return the number of paths that end at other limits than the path of the design."""
        changed = (self.mountings.limit != self.nominal.limit).any(axis=1)
        return int(np.count_nonzero(changed & self.mountings.solved))

    def quantiles(self, shares: Sequence[float] = QUANTILE_SHARES) -> dict[str, FloatArray]:
        """Return the quantiles (shares) of all quantities: over the mountings with a path, and for quantities
        of the mesh cycle over those in `cycles`. They are NaN if less than LEAST_KNOWN_SHARE of the values
        are known, because quantiles of few known values would be biased."""
        solved = self.mountings.solved
        values = {name: value[solved] for name, value in self.mountings.quantities().items()}
        values |= self.cycles.quantities() if self.cycles else {}
        quantiles = dict.fromkeys(values, np.full(len(shares), np.nan))
        for name, value in values.items():
            known = value[~np.isnan(value)]
            if known.size >= max(1.0, LEAST_KNOWN_SHARE * value.size):
                quantiles[name] = np.quantile(known, shares)
        return quantiles


@dataclass(frozen=True)
class _Task:
    """Work for one call of an executor: `cases` mountings from the first one of block number `block` on."""

    design: Design
    flanks: Sequence[str]
    tolerances: Tolerances
    seed: int
    block: int
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
    blocks_per_task: int = BLOCKS_PER_TASK,
    progress: Callable[[int], object] | None = None,
) -> ToleranceStudy:
    """Compute the paths of contact of a design in many mountings with random assembly errors.

    Parameters
    ----------
    design : Design
        A single design; drawn errors are added to its errors.
    tolerances : Tolerances
    flank : {'right', 'left'}
    cases : int
        Number of mountings. A study with more mountings begins with the same ones.
    seed : int
    operation : int
        Number of mountings, the first ones drawn, whose mesh cycles are computed as well.
    executor : concurrent.futures.Executor, optional
        Distributes the work, `blocks_per_task` blocks of mountings at a time. Neither `executor` nor
        `blocks_per_task` changes the result.
    progress : callable, optional
        Called with the work done since the last call: 1 for each mounting, and CYCLE_COST_PATHS more for a
        mounting whose mesh cycle is computed.

    Returns
    -------
    ToleranceStudy

    Raises
    ------
    ValueError
        For a batch; for tolerances that are negative, not finite or not below their limits
        (`pair.misalignment.errors_below`: 10 modules of offset, the shaft angle of the pair); for tolerances
        of angles if the flanks touch along lines; for counts below 1.

    Notes
    -----
    A mounting takes 50 to 300 us, half of it for the backlash. Paths that have to be traced take about 10 ms,
    lines of contact on parallel axes 3 to 5 ms. A mesh cycle, with the contact ratio in a film, takes 5 to
    10 ms more (ratio to a path: beveloid_geom/operation/README.md, Cost). A contact pattern takes about as
    long as two mesh cycles with their contact ratios.

    References
    ----------
    Definitions: beveloid_geom/analysis/README.md, Tolerances.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> tolerances = bg.Tolerances(offset=0.02)
    >>> study = bg.tolerance_study(bg.builtin_design("ni-2017"), tolerances, cases=100)
    >>> print(f"{study.mountings.contact_ratio.min():.3f}")
    1.648
    """
    require_integers(cases=cases, seed=seed, operation=operation, blocks_per_task=blocks_per_task)
    if not 0 <= operation <= cases:
        limit = f"must be 0 to {cases}, the number of mountings, got {operation}"
        raise ArgumentError("operation", f"{limit}: reduce it, or increase cases")
    (study,) = tolerance_studies(
        design,
        tolerances,
        (flank,),
        cases,
        seed=seed,
        executor=executor,
        blocks_per_task=blocks_per_task,
        progress=progress,
    )
    if not operation:
        return study
    names, distribute = tolerances.names, map if executor is None else executor.map
    errors, parts = study.mountings.errors[:operation], []
    batches = [
        mounted(design, errors[start : start + CYCLES_PER_CALL], names)
        for start in range(0, operation, CYCLES_PER_CALL)
    ]
    for part in distribute(partial(cycle_statistics, flank=flank), batches):
        parts.append(part)
        if progress is not None:
            progress(CYCLE_COST_PATHS * part.status.size)
    cycles, nominal = (
        joined(parts, axis=0),
        cycle_statistics(mounted(design, np.zeros((1, len(names))), names), flank),
    )
    far = _furthest(study, cycles)
    ends = distribute(partial(_pattern_ends, flank=flank), [mounted(design, errors[k], names) for k in far])
    cycles = cycles.with_patterns(far, list(ends))
    if nominal.solved[0]:
        nominal = nominal.with_patterns(np.zeros(1, dtype=int), [_pattern_ends(design, flank)])
    return replace(study, cycles=cycles, nominal_cycles=nominal)


def _pattern_ends(design: Design, flank: str) -> Mask:
    """Return `ContactPattern.ends` of a mounting."""
    return contact_pattern(design, flank).ends


def useful_processes(cases: int, operation: int) -> int:
    """Return the number of tasks of paths or of mesh cycles, the larger one: the largest useful number of
    processes. More processes would share only the patterns, at most 24."""
    return max(-(-cases // (BLOCKS_PER_TASK * MOUNTINGS_PER_BLOCK)), -(-operation // CYCLES_PER_CALL))


def _furthest(study: ToleranceStudy, cycles: CycleStatistics) -> Integers:
    """Return the numbers of the mountings in operation whose paths move furthest along the face, those
    without a path on the flanks first. For these, the edges at which the contact pattern ends are
    computed."""
    moved = np.abs(study.mountings.pinion_z[:, 1] - study.nominal.pinion_z[0, 1])[: cycles.status.size]
    order = np.argsort(-np.nan_to_num(moved, nan=np.inf), kind="stable")
    return np.asarray(order[cycles.solved[order]][:24])


def tolerance_studies(
    design: Design,
    tolerances: Tolerances,
    flanks: Sequence[str],
    cases: int = 100_000,
    *,
    seed: int = 0,
    executor: Executor | None = None,
    blocks_per_task: int = BLOCKS_PER_TASK,
    progress: Callable[[int], object] | None = None,
) -> tuple[ToleranceStudy, ...]:
    """Compute the studies of several flanks in the same mountings, with the backlash computed only once.

    Parameters and ValueError are those of `tolerance_study`; `progress` counts a mounting of all flanks as
    1."""
    require_single(design)
    for flank in flanks:
        _check(design, tolerances, flank, seed)
    if min(cases, blocks_per_task) < 1:
        raise ValueError(f"cases and blocks_per_task must be at least 1, got {cases} and {blocks_per_task}")
    step = MOUNTINGS_PER_BLOCK * (1 if executor is None else blocks_per_task)
    tasks = [
        _Task(design, flanks, tolerances, seed, start // MOUNTINGS_PER_BLOCK, min(step, cases - start))
        for start in range(0, cases, step)
    ]
    distribute = map if executor is None else executor.map
    parts: list[list[Mountings]] = []
    for part in distribute(_solved_task, tasks):
        parts.append(part)
        if progress is not None:
            progress(part[0].status.size)
    names = tolerances.names
    nominal = solved_mountings(design, flanks, np.zeros((1, len(names))), names)
    every = (joined(part, axis=0) for part in zip(*parts, strict=True))
    results = zip(flanks, nominal, every, strict=True)
    return tuple(ToleranceStudy(flank, tolerances, seed, first, drawn) for flank, first, drawn in results)


def _check(design: Design, tolerances: Tolerances, flank: str, seed: int) -> None:
    flank_sign(flank)
    if seed < 0:
        raise ValueError(f"seed must be at least 0, got {seed}")
    every = sorted({name for place in NAMES.values() for name in place})
    require_numbers(**{f"tolerance of {name}": getattr(tolerances, name) for name in every})
    require_numbers(sigmas=tolerances.sigmas)
    if tolerances.distribution not in ("normal", "uniform"):
        raise ValueError(f"distribution must be 'normal' or 'uniform', got {tolerances.distribution!r}")
    if not 0.0 < tolerances.sigmas < np.inf:
        raise ValueError(f"sigmas must be positive and finite, got {tolerances.sigmas}")
    most, names = errors_below(design), tolerances.names
    for name in (name for place in NAMES.values() for name in place if name not in names):
        if getattr(tolerances, name):
            raise ValueError(
                f"tolerance of {name} is about the common perpendicular, others are at the mesh: leave it out"
            )
    angle = next((name for name in names if name in ANGLES and getattr(tolerances, name) > 0.0), None)
    if angle is not None and bool(is_line_contact(design, flank)):
        # On straight cylindrical teeth, parabolas leave line contact.
        size = -1e-3 / float(design.pinion.tool.normal_module)
        parabolas = "" if is_line_contact(design.with_parabola(size, size), flank) else "parabolas or "
        text = (
            f"must be 0 if the flanks touch along lines, got {size_words(angle, getattr(tolerances, angle))}"
        )
        text += ": any such error moves the contact to an edge"
        text += f"; give only the other tolerances, or add {parabolas}helix crowning"
        raise ArgumentError(f"tolerance of {angle}", text)
    for name in names:
        value, unit = getattr(tolerances, name), "rad" if name in ANGLES else "mm"
        if not 0.0 <= value < np.inf:
            raise ValueError(
                f"tolerance of {name} must be finite and at least 0 {unit}, got {value}: it applies both ways"
            )
        if value >= most.get(name, np.inf):
            text = f"must be less than {size_words(name, most[name])} on this pair"
            text += f", got {size_words(name, value)}"
            raise ArgumentError(f"tolerance of {name}", f"{text}: is the unit right?")


def drawn_errors(tolerances: Tolerances, seed: int, block: int, cases: int) -> FloatArray:
    """Return random errors (cases, names) of the first mountings of block number `block`, in the
    order of `Tolerances.names`, mm and rad.

    The random stream is that of the child `block` of NumPy's SeedSequence of the seed. A tolerance affects
    only the random values of its error."""
    # SeedSequence(seed).spawn gives its children this key, so that a task needs no other stream.
    stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(block,)))
    shape = (cases, len(tolerances.names))
    if tolerances.distribution == "uniform":
        drawn = stream.uniform(-1.0, 1.0, shape) * tolerances.values()
    else:
        drawn = stream.standard_normal(shape) * (tolerances.values() / tolerances.sigmas)
    return np.asarray(drawn + 0.0)  # no -0.0 for a tolerance of 0


def _solved_task(task: _Task) -> list[Mountings]:
    """Return the mountings of a task by flank. Blocks are solved one by one, because rounding depends on the
    size of the batch."""
    parts = []
    for k, start in enumerate(range(0, task.cases, MOUNTINGS_PER_BLOCK)):
        errors = drawn_errors(
            task.tolerances, task.seed, task.block + k, min(MOUNTINGS_PER_BLOCK, task.cases - start)
        )
        parts.append(solved_mountings(task.design, task.flanks, errors, task.tolerances.names))
    return [joined(of_flank, axis=0) for of_flank in zip(*parts, strict=True)]
