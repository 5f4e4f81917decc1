"""Parabola coefficients of a pair for a stated aim: least shift of the path, or least transmission error.

The coefficients a1, a2 are sought within bounds, so that the shift of the path on the pinion's flank
under given assembly errors is least, or the transmission error of all teeth under any of them, while the
contact ratio (Eq. 16) is at least a given one and the path is centred on the face. A grid that does not
depend on the bounds finds where to start, where none beside is better. SciPy's SLSQP goes on from there.

The shift is that of the place at mid-roll, square to the path as designed: what moves along the path
is no shift of it. (z, l1) are taken for plane coordinates of the flank. Coefficients whose sum is
positive make the two flanks hollow against each other: their tangency is then not where the teeth
touch first, so that they are left out.

Edges. Where the path of a tooth pair ends with no other pair ahead, an edge carries. An aim may ask for no
edges, in the mounting as designed and under each error both ways. That is no bound of the sum of the
coefficients: on Table 1's right flanks edges carry with sums close to 0, and with sums far below 0 again,
where an error moves the path towards one of its ends. The optimiser therefore takes the leads at the ends of
all these paths (`edges`) for conditions. What it proposes is judged by the mesh cycles of all teeth, the best
first, and the first without edges is the answer: it has none, whatever the leads say.
Where an edge touches for another reason than the end of a path, the least may be missed, or nothing
found; then what edges carry at the optimum without this condition is said.

Transmission error. Where no edge carries, that of all teeth follows from the path (`edges.swing_of_all`); the
greatest in the mountings of the aim is to be least. Next to unmodified flanks have next to none under any
error, and the greatest shift: such an aim wants a limit of that.

Source: the aim is that of the paper's section 5 (D1), which judges coefficients by eye.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ..arrays import FloatArray, flank_sign
from ..contact.path import path_of_contact
from ..design.model import Design, Errors, MeshErrors
from ..operation.backlash_by_tangency import jammed, tangent_backlash
from ..pair.errors import mounted
from ..support.read_only import kept
from .edges import Operation, leads_of, operation_of, swing_of_all
from .tolerance import swing_of

Vector: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]

POINTS = 17
"""Positions of a path; the direction in the middle is that between the neighbours of mid-roll."""
UNIT = 1e-3
"""1/mm: coefficients near 1 for the optimiser."""
STEP, FINER, EVEN, STARTS, BESIDE = 0.001, 0.25, 12, 4, 3.0
"""Step of the grid times the module, 1/mm mm, and what part of that its sums have; how many even ones there
are from 0; from how many of its places the optimiser starts, and how many steps it first goes either way."""
NEARLY = 1.0
"""Share of a bound by which a start may miss it while others do not."""
SLACK = 1e-6
"""Share of a bound by which a result may miss it."""
PASSES, PRECISE = 60, 1e-8
LEAD, USUAL_LEAD = 1e-9, 1e-4
"""rad: least lead of another tooth pair where a path ends, some 1e-8 1/mm of the coefficients of Table 1 from
edges, and one by which leads are scaled."""
GOALS = ("shift", "transmission_error")
"""What may be least."""


@dataclass(frozen=True)
class Aim:
    """What coefficients are to do.

    `errors`: assembly errors, about the common perpendicular or at the mesh, whose effect is to be least,
    each taken alone and both ways, mm and rad; the contact ratio to be reached; how far the place at mid-roll
    may lie from mid-face, mm; the
    transmission error of the path, peak to peak, that may not be exceeded, rad; bounds of the
    coefficients, 1/mm; whether edges may carry a part of a mesh cycle, without errors or with one; the shift
    that may not be exceeded, mm; what is to be least, the shift or the transmission error of all teeth."""

    errors: Errors | MeshErrors
    contact_ratio: float = 1.6
    off_centre: float = 1.0
    peak_to_peak: float = np.inf
    pinion_parabola: tuple[float, float] = (-0.002, 0.002)
    gear_parabola: tuple[float, float] = (-0.002, 0.002)
    edges: bool = True
    shift: float = np.inf
    least: Literal["shift", "transmission_error"] = "shift"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the errors."""
        return tuple(vars(self.errors))

    def mountings(self) -> FloatArray:
        """Give errors (n, names), mm and rad: none, then each alone, both ways."""
        sizes = np.array(list(vars(self.errors).values()))
        single = np.diag(sizes)[sizes != 0.0]
        both = np.stack((single, -single), axis=1).reshape(-1, sizes.size)
        return np.concatenate((np.zeros((1, sizes.size)), both))

    def mounted(self, design: Design) -> Design:
        """Give a single design in all mountings of the aim, batch axis (n)."""
        return mounted(design, self.mountings(), self.names)


@dataclass(frozen=True, eq=False)
class Paths:
    """Figures of designs with other coefficients, each of the shape of the coefficients; NaN without a path.

    `shift` (mm): root of the sum of the squared shifts under the errors of an aim, over both signs
    their mean; `contact_ratio`; `centre` (mm): z at mid-roll on the pinion; `peak_to_peak` (rad) of the
    transmission error over the path. `leads` (2 n, ...), rad: of other tooth pairs where the paths of the n
    mountings of an aim end (`edges`), none for an aim that allows edges. `goals` (k, ...), of which the
    greatest is to be least: the shift (mm), or transmission errors of all teeth in the mountings (rad)."""

    shift: FloatArray
    contact_ratio: FloatArray
    centre: FloatArray
    peak_to_peak: FloatArray
    leads: FloatArray
    goals: FloatArray

    def margins(self, aim: Aim) -> FloatArray:
        """Find what the conditions are met by (conditions, ...), in shares of their bounds; negative if
        not."""
        ratio = self.contact_ratio / aim.contact_ratio - 1.0
        off, swing = self.centre / aim.off_centre, self.peak_to_peak / aim.peak_to_peak
        moved = 1.0 - self.shift / aim.shift
        return np.array([ratio, 1.0 - off, 1.0 + off, 1.0 - swing, moved, *(self.leads - LEAD) / USUAL_LEAD])


@dataclass(frozen=True, eq=False)
class Optimum:
    """Coefficients found (1/mm), the design with them, the figures of its path and of the given one, and what
    all teeth of both do in the mountings of the aim, NaN where a tool's rounds overlap."""

    pinion_parabola: float
    gear_parabola: float
    design: Design
    found: Paths
    given: Paths
    found_operation: Operation
    given_operation: Operation


def paths_of(design: Design, flank: str, aim: Aim, pinion: FloatArray, gear: FloatArray) -> Paths:
    """Find figures of a design with the parabola coefficients `pinion`, `gear`, 1/mm; all broadcast."""
    pinion, gear = np.broadcast_arrays(np.asarray(pinion, dtype=float), np.asarray(gear, dtype=float))
    errors = aim.mountings()
    errors = errors.reshape(-1, *[1] * pinion.ndim, errors.shape[1])
    batch = mounted(design.with_parabola(pinion, gear), errors, aim.names)
    path = path_of_contact(batch, flank, POINTS)
    middle = POINTS // 2
    place = np.stack((path.pinion_z, path.l1), axis=-1)
    along = place[0, ..., middle + 1, :] - place[0, ..., middle - 1, :]
    with np.errstate(invalid="ignore"):  # a path may be a single point: it has no direction
        along = along / np.hypot(along[..., 0], along[..., 1])[..., None]
    moved = place[1:, ..., middle, :] - place[0, ..., middle, :]
    across = moved[..., 0] * along[..., 1] - moved[..., 1] * along[..., 0]
    shift = np.sqrt(0.5 * (across**2).sum(axis=0))
    return Paths(
        shift=shift,
        contact_ratio=path.ends.contact_ratio[0],
        centre=place[0, ..., middle, 0],
        peak_to_peak=swing_of(path.transmission_error[0]),
        leads=np.empty((0, *pinion.shape)) if aim.edges else leads_of(path).reshape(-1, *pinion.shape),
        goals=shift[None] if aim.least == "shift" else swing_of_all(path),
    )


def optimise_parabola(design: Design, aim: Aim, flank: str = "right") -> Optimum:
    """Find the parabola coefficients that meet an aim with the least shift, or the least transmission error.

    Parameters
    ----------
    design : Design
        A single one; its own coefficients are compared with those found.
    aim : Aim
    flank : {'right', 'left'}

    Returns
    -------
    Optimum

    Raises
    ------
    ValueError
        For a batch, an aim without errors or with bounds that leave nothing, where no coefficients were
        found that meet the conditions, where none of these can be put together, and, if the aim asks for no
        edges, where edges carry with all of them or a tool's rounds overlap.
    """
    _check(design, aim, flank)
    if aim.edges:
        candidates, fault = _candidates(design, flank, aim)
        if fault:
            raise ValueError(fault)
        first, second = candidates[0]
    else:
        first, second = _without_edges(design, flank, aim)
    changed = design.with_parabola(float(first), float(second))
    own = (np.asarray(member.tool.parabola) for member in design.members)
    return Optimum(
        pinion_parabola=float(first),
        gear_parabola=float(second),
        design=changed,
        found=paths_of(design, flank, aim, first, second),
        given=paths_of(design, flank, aim, *own),
        found_operation=_operation(changed, flank, aim),
        given_operation=_operation(design, flank, aim),
    )


def _candidates(design: Design, flank: str, aim: Aim) -> tuple[FloatArray, str]:
    """Find coefficients (n, 2), 1/mm, that meet an aim by its paths, those with the best first; and,
    without any, what they fail by."""
    limits = np.array([aim.pinion_parabola, aim.gear_parabola]) / UNIT
    starts = _starts(design, flank, aim, limits)
    x = np.hstack((starts, *(_refined(design, flank, aim, limits, start) for start in starts.T)))
    paths = paths_of(design, flank, aim, UNIT * x[0], UNIT * x[1])
    met = (_margins(paths, aim, x) >= -SLACK).all(axis=0) & np.isfinite(paths.shift)
    if not met.any():
        best = float(np.max(paths.contact_ratio, initial=0.0, where=~np.isnan(paths.contact_ratio)))
        swing = f" and {aim.peak_to_peak:.3g} rad of error" if np.isfinite(aim.peak_to_peak) else ""
        swing += f" and a shift of {aim.shift:g} mm" if np.isfinite(aim.shift) else ""
        return x[:, :0].T, (
            f"no coefficients were found for a contact ratio of {aim.contact_ratio:g} within"
            f" {aim.off_centre:g} mm of mid-face{swing}, the greatest ratio tried is {best:.3f}:"
            " ask for less, or widen the bounds"
        )
    backlash = tangent_backlash(design.with_parabola(UNIT * x[0], UNIT * x[1])).normal
    met &= ~jammed(backlash, float(design.pinion.tool.normal_module))
    if not met.any():
        return x[:, :0].T, (
            f"all coefficients found for the aim leave no backlash, {np.nanmax(backlash):.4f} mm at the most:"
            " take less profile shift, or a larger offset where the axes cross"
        )
    order = np.argsort(np.where(met, paths.goals.max(axis=0), np.inf), kind="stable")[: np.count_nonzero(met)]
    return UNIT * x[:, order].T, ""


def _without_edges(design: Design, flank: str, aim: Aim) -> FloatArray:
    """Find coefficients (2), 1/mm, that meet an aim and with which edges carry nothing in its mountings.

    Raises ValueError if none are found: for what else is not met, for a tool whose mesh cycle is unknown,
    for edges."""
    for pair in _candidates(design, flank, aim)[0]:
        if _operation(design.with_parabola(*pair.tolist()), flank, aim).edge_share == 0.0:
            return np.asarray(pair)
    others, fault = _candidates(design, flank, replace(aim, edges=True, least="shift"))
    if fault:
        raise ValueError(fault)
    best = others[0].tolist()
    share = operation_of(aim.mounted(design.with_parabola(*best)), flank).edge_share
    carried = (
        "a mesh cycle is not known" if np.isnan(share) else f"edges carry {100.0 * share:.3g} % of a cycle"
    )
    raise ValueError(
        "no coefficients were found with which no edge carries, as designed and under the errors: with pinion"
        f" {best[0]:.6g}, gear {best[1]:.6g} 1/mm, the best without this condition, {carried}:"
        " take smaller errors, ask for less, or widen the bounds"
    )


def _operation(design: Design, flank: str, aim: Aim) -> Operation:
    """Find what all teeth do in the mountings of an aim; NaN if a tool's rounds overlap."""
    try:
        return operation_of(aim.mounted(design), flank)
    except ValueError:  # such a tool has no fillets to offer
        return Operation()


def _margins(paths: Paths, aim: Aim, x: FloatArray) -> FloatArray:
    """Find margins of all conditions (conditions, ...) at coefficients x (2, ...), in UNIT."""
    return np.concatenate((paths.margins(aim), -x.sum(axis=0)[None]))


def _refined(design: Design, flank: str, aim: Aim, limits: FloatArray, start: Vector) -> FloatArray:
    """Find coefficients (2, 2), in UNIT, at which the optimiser ends beside the start, and from there on: of
    two valleys it might leave the one that it starts in."""
    from scipy.optimize import Bounds, NonlinearConstraint, minimize

    @kept(8)  # conditions are asked for with the same coefficients
    def paths(first: float, second: float) -> Paths:
        return paths_of(design, flank, aim, np.asarray(UNIT * first), np.asarray(UNIT * second))

    def greatest(x: Vector) -> float:
        """Give the greatest of the goals, over that of the start."""
        return float(x[2])

    def conditions(x: Vector) -> FloatArray:
        found = paths(*x[:2].tolist())
        margins = np.append(_margins(found, aim, x[:2]), x[2] - found.goals / scale)
        return np.asarray(np.nan_to_num(margins, nan=-1.0))

    scale = float(np.nan_to_num(paths(*start.tolist()).goals.max(), nan=1.0)) or 1.0
    reach, ends = BESIDE * _step(design), []
    for box in (np.clip(start[:, None] + (-reach, reach), *limits.T[:, :, None]), limits):
        goal = float(np.nan_to_num(paths(*start.tolist()).goals.max(), nan=scale)) / scale
        result = minimize(
            greatest,
            np.append(start, goal),
            method="SLSQP",
            bounds=Bounds(np.append(box[:, 0], 0.0), np.append(box[:, 1], np.inf)),
            constraints=NonlinearConstraint(conditions, 0.0, np.inf),
            options={"maxiter": PASSES, "ftol": PRECISE},
        )
        start = np.clip(result.x[:2], box[:, 0], box[:, 1])
        ends.append(start)
    return np.stack(ends, axis=1)


def _step(design: Design) -> float:
    """Give the step of the grid, in UNIT."""
    return STEP / (UNIT * float(design.pinion.tool.normal_module))


def _check(design: Design, aim: Aim, flank: str) -> None:
    flank_sign(flank)
    if design.batch_shape:
        raise ValueError("the optimiser takes a single design: give its cases one by one")
    errors = list(vars(aim.errors).values())
    if not any(errors):
        raise ValueError(f"errors of the aim must be finite, one of them not 0, got {errors}")
    if aim.least not in GOALS:
        raise ValueError(f"least of the aim must be one of {', '.join(GOALS)}, got {aim.least!r}")
    if aim.least == "transmission_error" and aim.edges:
        raise ValueError(
            "the least transmission error is that of teeth whose edges do not carry: ask for no edges"
        )
    for name in ("contact_ratio", "off_centre", "peak_to_peak", "shift"):
        value = getattr(aim, name)
        if not value > 0.0 or (value == np.inf and name not in ("peak_to_peak", "shift")):
            raise ValueError(f"{name} of the aim must be positive and finite, got {value}")
    for name in ("pinion_parabola", "gear_parabola"):
        low, high = getattr(aim, name)
        if not -np.inf < low < high < np.inf:
            raise ValueError(f"{name} of the aim must be two finite bounds that rise, got {low}, {high}")
    if aim.pinion_parabola[0] + aim.gear_parabola[0] >= 0.0:
        raise ValueError("the bounds leave no sum of both coefficients below 0: lower one of them")


def _starts(design: Design, flank: str, aim: Aim, limits: FloatArray) -> FloatArray:
    """Find coefficients (2, n), in UNIT, beside which none on a grid miss the conditions by less or, missing
    as little, are better; the best first. Of two grids: an even one between the bounds, and one of sums and
    differences of the coefficients that is the same whatever the bounds, and finer in the sums."""
    first, second = (np.linspace(low, high, EVEN // 2 + 1) for low, high in limits.tolist())
    even = np.meshgrid(first, second, indexing="ij")
    step, most = _step(design), float(np.abs(limits).sum())
    sums, apart = -_graded(FINER * step, most), 2.0 * _graded(step, 0.5 * most)
    total, apart = np.meshgrid(sums, np.append(-apart[:0:-1], apart), indexing="ij")
    found = [
        _least_of(design, flank, aim, limits, np.array(x))
        for x in (even, (0.5 * (total + apart), 0.5 * (total - apart)))
    ]
    x, missed, goal = (np.concatenate(rows, axis=-1) for rows in zip(*found, strict=True))
    near = np.flatnonzero(missed <= max(NEARLY, float(missed.min(initial=np.inf))))
    return x[:, near[np.lexsort((goal[near], missed[near]))][:STARTS]]


def _least_of(
    design: Design, flank: str, aim: Aim, limits: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the coefficients (2, n) of a grid x (2, rows, columns) beside which none are better, by how much
    they miss the conditions (n,), and the greatest of their goals (n,)."""
    inside = ((x >= limits[:, :1, None]) & (x <= limits[:, 1:, None])).all(axis=0) & (x.sum(axis=0) <= SLACK)
    missed, goal = np.full((2, *inside.shape), np.inf)
    if not inside.any():
        return x[:, :0, 0], missed[:0, 0], goal[:0, 0]
    shown = paths_of(design, flank, aim, *(UNIT * x[:, inside]))
    missed[inside] = np.maximum(np.nan_to_num(-shown.margins(aim), nan=np.inf).max(axis=0), 0.0)
    goal[inside] = shown.goals.max(axis=0)
    met = inside & (missed == missed.min())
    backlash = tangent_backlash(design.with_parabola(*(UNIT * x[:, met]))).normal
    missed[met] += jammed(backlash, float(design.pinion.tool.normal_module))
    rank = np.empty(missed.shape)
    rank.flat[np.lexsort((goal.ravel(), missed.ravel()))] = np.arange(rank.size)
    wide, (rows, columns) = np.pad(rank, 1, constant_values=np.inf), rank.shape
    beside = [wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    least = inside & (rank <= np.min(beside, axis=0))
    return x[:, least], missed[least], goal[least]


def _graded(step: float, most: float) -> FloatArray:
    """Give values from 0 to `most`: of up to EVEN steps each, from there to twice as many each second, and so
    on."""
    doublings = int(np.log2(max(1.0, most / (EVEN * step)))) + 1
    beyond = [2.0**k * n for k in range(doublings) for n in range(EVEN + 2, 2 * EVEN + 1, 2)]
    values = step * np.append(np.arange(EVEN + 1), beyond)
    return values[values <= most]
