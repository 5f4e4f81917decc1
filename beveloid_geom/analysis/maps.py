"""Maps of a design: figures of its path of contact over two of its values, one of each member.

`over` says which values:

- 'parabola': the parabola coefficients a1, a2, 1/mm.
- 'mounting': changes of the mounting distances, mm, positive towards the member's heel. Both members
  stand there without errors: backlash changes, the lines of action do not.
- 'shift': the profile shift coefficients x1, x2. Offset and shaft angle stay as given, and with them
  the pitch point, as shifted flanks are the same surfaces, turned: mounting distances, fixed or not,
  stay too. What changes is the backlash, and where tips and roots end the path.

Coefficients whose sum is positive make the flanks hollow against each other (`hollow`), and a negative
backlash makes the other flanks interfere (`interferes`): such cells have a path, but no pair runs so.
What the teeth do over a mesh cycle, edges and hand-overs included, is found where asked for (`mesh_cycle`).

The angle is that of `analysis.path_measures`, of the chord in the pinion's side view; the shift that of
`optimise`. Source: the paper's Figs. 7 to 11 are lines of the first map, its case C3 is a quadrant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Mask, Quantity, flank_sign
from ..contact.path import path_ends
from ..design.limits import member_faults, parabola_limit
from ..design.model import Design, Errors, MeshErrors, unchecked
from ..operation.backlash_by_tangency import jammed, tangent_backlash
from ..operation.mesh_cycle import mesh_cycle
from ..pair.errors import KINDS, errors_below
from ..pair.mounting import half_pitch, mounting_of
from ..status import Status
from ..support.few_lines import few_lines
from .optimise import Aim, paths_of
from .path_measures import paths_of as measures_of
from .tolerance import USUAL_AT

Over: TypeAlias = Literal["parabola", "mounting", "shift"]
Bounds: TypeAlias = tuple[float, float]
OVER: tuple[Over, ...] = ("parabola", "mounting", "shift")
UNITS = {"parabola": "1/mm", "mounting": "mm", "shift": ""}
"""Units of the values of both members."""
PARABOLA = 0.012
"""Greatest coefficient of a usual map times the module: 0.002 1/mm on Table 1, as far as the paper's
Figs. 9 to 11 go."""
FACE = 0.6
"""Greatest change of mounting of a usual map, in greater face widths: beyond half of one paths are lost."""
SHIFT = 0.3
"""Change of the shift coefficients of a usual map, to either side."""
LARGEST_SHIFT = 3.0
STEPS, MOST_STEPS = 21, 201
CELLS = 512
"""Cells solved in one call."""
NEAR = 1e-3
"""Change of the values, mm or a coefficient, by which the rate of the backlash is taken."""
ROUNDING = 1e-9
"""mm of negative backlash that are none: members may be made to close without."""
QUADRANTS: dict[str, tuple[int, int]] = {"C1": (1, 1), "C2": (-1, -1), "C3": (1, -1), "C4": (-1, 1)}
"""Signs of both coefficients in the paper's cases."""
FIGURES = (
    *("contact_ratio", "angle", "shift", "peak_to_peak", "centre"),
    *("normal_backlash", "mounted_backlash"),
)
"""What is mapped, by the names of the fields."""
IN_OPERATION = ("cycle_peak_to_peak", "edge_share")
"""What is mapped besides if asked for."""


@dataclass(frozen=True, eq=False)
class DesignMap:
    """Figures of a design over values of its members, arrays (pinion values, gear values).

    `pinion` (n,), `gear` (m,): the values. `status`: codes of `Status` of the path as mounted; NaN where
    it is not SOLVED. `contact_ratio`: Eq. 16. `angle` (rad, -pi/2 to pi/2): of the path's chord to the
    axial direction in the pinion's side view (z, r), positive if z rises with r; pi further is the same.
    `shift` (mm): how far the place at mid-roll moves on the pinion's flank square to the path under
    `errors`, each alone and both ways (root of the sum of the squares, the mean over both ways); NaN also
    where an error carries the path off the flanks. `peak_to_peak` (rad): transmission error over the path
    of one tooth pair. `centre` (mm): z at mid-roll on the pinion. `normal_backlash` (mm): without
    parabolas and errors, that of the design followed past half a pitch. `mounted_backlash` (mm): least over
    a mesh cycle with those of the design, by tangency (`backlash_by_tangency`). `cycle_peak_to_peak` (rad),
    `edge_share`: of a mesh cycle of all teeth, as in `Running`; NaN where not asked for or not known."""

    __repr__ = few_lines

    design: Design
    flank: str
    over: Over
    errors: Errors | MeshErrors
    pinion: FloatArray
    gear: FloatArray
    status: Codes
    contact_ratio: FloatArray
    angle: FloatArray
    shift: FloatArray
    peak_to_peak: FloatArray
    centre: FloatArray
    normal_backlash: FloatArray
    mounted_backlash: FloatArray
    cycle_peak_to_peak: FloatArray
    edge_share: FloatArray

    @property
    def solved(self) -> Mask:
        """Cells with a path on the flanks."""
        return np.asarray(self.status == Status.SOLVED)

    @property
    def hollow(self) -> Mask:
        """Cells whose parabolas make the flanks hollow against each other: their sum is positive."""
        own = [float(member.tool.parabola) for member in self.design.members]
        total = np.add.outer(self.pinion, self.gear) if self.over == "parabola" else np.full((1, 1), sum(own))
        return np.broadcast_to(total > 1e-9 * np.abs(total).max(), self.status.shape)

    @property
    def interferes(self) -> Mask:
        """Cells with negative backlash: the other flanks interfere."""
        return np.asarray(self.normal_backlash < -ROUNDING)

    @property
    def jammed(self) -> Mask:
        """Cells that cannot be put together with the errors and parabolas that they have."""
        return jammed(self.mounted_backlash, float(self.design.pinion.tool.normal_module))

    @property
    def sound(self) -> Mask:
        """Cells with a path that are neither hollow nor interfere, and can be put together."""
        return self.solved & ~self.hollow & ~self.interferes & ~self.jammed

    def quadrants(self) -> dict[str, Mask]:
        """Cells of the paper's cases C1 to C4 in a map of parabola coefficients; axes belong to none."""
        if self.over != "parabola":
            return {}
        return {
            name: np.logical_and.outer(pinion * self.pinion > 0.0, gear * self.gear > 0.0)
            for name, (pinion, gear) in QUADRANTS.items()
        }


def own_values(design: Design, over: Over) -> tuple[float, float]:
    """Find where a single design lies on its map."""
    if over == "parabola":
        return float(design.pinion.tool.parabola), float(design.gear.tool.parabola)
    if over == "shift":
        return float(design.pinion.profile_shift), float(design.gear.profile_shift)
    return 0.0, 0.0


def usual_bounds(design: Design, over: Over) -> tuple[Bounds, Bounds]:
    """Find the least and greatest value of pinion and gear where none are given: see PARABOLA, FACE,
    SHIFT."""
    if over == "mounting":
        change = FACE * max(float(member.face_width) for member in design.members)
        return (-change, change), (-change, change)
    if over == "shift":
        low, high = ([x + step for x in own_values(design, over)] for step in (-SHIFT, SHIFT))
        return (low[0], high[0]), (low[1], high[1])
    most = []
    for member in design.members:
        usual = max(PARABOLA / float(member.tool.normal_module), abs(float(member.tool.parabola)))
        most.append(min(usual, parabola_limit(member)))
    return (-most[0], most[0]), (-most[1], most[1])


def usual_errors(design: Design) -> Errors | MeshErrors:
    """Give errors as large as the usual tolerances, of the place where a design has its own measured."""
    usual = USUAL_AT[design.errors_at]
    return KINDS[design.errors_at](*usual.values().tolist())


def design_at(design: Design, over: Over, pinion: Quantity, gear: Quantity) -> Design:
    """Give the design with these values of its members, arrays of one shape or numbers."""
    if over == "parabola":
        return design.with_parabola(pinion, gear)
    if over == "shift":
        first, second = (
            replace(member, profile_shift=x) for member, x in zip(design.members, (pinion, gear), strict=True)
        )
        return replace(design, pinion=first, gear=second)
    distance = mounting_of(design).distance
    moved = {"pinion_mounting": distance[0] + pinion, "gear_mounting": distance[1] + gear}
    return replace(design, pair=unchecked(design.pair, **moved))  # NaN without a layout


def map_of(
    design: Design,
    over: Over,
    flank: str = "right",
    *,
    pinion: Bounds | None = None,
    gear: Bounds | None = None,
    steps: int = STEPS,
    errors: Errors | MeshErrors | None = None,
    operation: bool = False,
    progress: Callable[[int], object] | None = None,
) -> DesignMap:
    """Find figures of a single design over `steps` times `steps` values of its members, bounds included.

    Bounds are `usual_bounds`, errors the usual tolerances (`tolerance.USUAL_AT`) unless given. A cell takes
    as long as 1 to 20 paths of 101 positions, most of it for the errors, with `operation` 20 to 30 more.
    `progress` is called with the number of cells done since.

    Raises ValueError for a batch, bounds that do not rise or that a member cannot be cut with, errors
    that are not finite or all 0, and steps below 2."""
    usual = usual_bounds(design, over) if over in OVER and not design.batch_shape else ((0.0, 0.0),) * 2
    bounds = (usual[0] if pinion is None else pinion, usual[1] if gear is None else gear)
    errors = usual_errors(design) if errors is None else errors
    _check(design, over, flank, bounds, steps, errors)
    first, second = (low + (high - low) * np.linspace(0.0, 1.0, steps) for low, high in bounds)
    x, y = (side.ravel() for side in np.meshgrid(first, second, indexing="ij"))
    rows: dict[str, list[FloatArray]] = {name: [] for name in ("status", *FIGURES, *IN_OPERATION)}
    for start in range(0, x.size, CELLS):
        block = slice(start, start + CELLS)
        for name, values in _cells(design, over, flank, errors, x[block], y[block]).items():
            rows[name].append(values)
        cells = np.full((len(IN_OPERATION), *x[block].shape), np.nan)
        for k in range(x[block].size) if operation else ():
            cells[:, k] = _in_operation(
                design_at(design, over, float(x[start + k]), float(y[start + k])), flank
            )
            if progress is not None:
                progress(1)
        for name, values in zip(IN_OPERATION, cells, strict=True):
            rows[name].append(values)
        if progress is not None and not operation:
            progress(x[block].size)
    found = {name: np.concatenate(parts).reshape(steps, steps) for name, parts in rows.items()}
    status = found.pop("status").astype(np.int8)
    return DesignMap(design, flank, over, errors, first, second, status, **found)


def _cells(
    design: Design, over: Over, flank: str, errors: Errors | MeshErrors, pinion: FloatArray, gear: FloatArray
) -> dict[str, FloatArray]:
    """Find status and figures of cells (n,), in one call each."""
    cells = design_at(design, over, pinion, gear)
    parabola = (np.broadcast_to(member.tool.parabola, pinion.shape) for member in cells.members)
    with np.errstate(invalid="ignore"):  # a path may be a single point: it has no direction
        measures, shown = measures_of(cells, flank), paths_of(cells, flank, Aim(errors), *parabola)
    backlash = _backlash(design, over, pinion, gear)
    status, lost = np.full(pinion.size, Status.SOLVED, dtype=float), measures.limit[:, 0] < 0
    if lost.any():
        status[lost] = path_ends(design_at(design, over, pinion[lost], gear[lost]), flank).status
    return {
        "status": status,
        "contact_ratio": measures.contact_ratio,
        "angle": np.radians(measures.angle["chord"][0]),
        "shift": shown.shift,
        "peak_to_peak": shown.peak_to_peak,
        "centre": shown.centre,
        "normal_backlash": backlash,
        "mounted_backlash": backlash + tangent_backlash(cells).normal - mounting_of(cells).normal_backlash,
    }


def _backlash(design: Design, over: Over, pinion: FloatArray, gear: FloatArray) -> FloatArray:
    """Find the normal backlash (n,), mm, of cells: what `mounting_of` reduces to half a pitch either way,
    and the whole pitches by which it is linear in the values."""
    values, tool = np.array(own_values(design, over)), design.gear.tool
    pitch = np.pi * float(tool.normal_module) * np.cos(float(tool.normal_pressure_angle))
    near = values[:, None] + NEAR * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    own, *moved = np.broadcast_to(mounting_of(design_at(design, over, *near)).normal_backlash, 3)
    rates = half_pitch(np.array(moved) - own, pitch) / NEAR
    linear = own + rates @ (np.stack((pinion, gear)) - values[:, None])
    reduced = mounting_of(design_at(design, over, pinion, gear)).normal_backlash
    return np.asarray(reduced + pitch * np.round((linear - reduced) / pitch))


def _in_operation(design: Design, flank: str) -> list[float]:
    """Find the figures IN_OPERATION of a cell; NaN where they are not known."""
    try:
        cycle = mesh_cycle(design, flank, 1)
    except ValueError:  # a tool whose rounds overlap has no fillets to offer
        return [np.nan] * len(IN_OPERATION)
    return [float(cycle.peak_to_peak), float(cycle.edge_share)]


def _check(
    design: Design,
    over: Over,
    flank: str,
    bounds: tuple[Bounds, Bounds],
    steps: int,
    errors: Errors | MeshErrors,
) -> None:
    flank_sign(flank)
    if over not in OVER:
        raise ValueError(f"over must be one of {', '.join(OVER)}, got {over!r}")
    if design.batch_shape:
        raise ValueError("a map takes a single design: give its cases one by one")
    if not 2 <= steps <= MOST_STEPS or steps != int(steps):
        raise ValueError(f"steps must be 2 to {MOST_STEPS}, a whole number, got {steps}")
    values = [float(value) for value in vars(errors).values()]
    if not any(values):
        raise ValueError(f"errors of a map must be finite, one of them not 0, got {values}")
    for name, most in errors_below(design).items():
        if abs(error := float(getattr(errors, name, 0.0))) >= most:
            raise ValueError(f"error of {name} must be less than {most:g} on this pair, got {error:g}")
    for name, (low, high) in zip(("pinion", "gear"), bounds, strict=True):
        if not (-np.inf < low < high < np.inf and float(high) - float(low) < np.inf):
            raise ValueError(f"bounds of the {name} must be two finite values that rise, got {low}, {high}")
    for fault in _bound_faults(design, over, bounds):
        raise ValueError(fault)


def _bound_faults(design: Design, over: Over, bounds: tuple[Bounds, Bounds]) -> Iterator[str]:
    """Find what is wrong with members at the bounds and not with them as given."""
    for k, name in enumerate(("pinion", "gear")):
        if over == "shift" and max(map(abs, bounds[k])) > LARGEST_SHIFT:
            most = f"between -{LARGEST_SHIFT:g} and {LARGEST_SHIFT:g}"
            yield f"profile shift of the {name} must be {most}, got bounds {bounds[k][0]:g}, {bounds[k][1]:g}"
        known = {str(fault) for fault in member_faults(name, design.members[k])}
        for bound in bounds[k] if over != "mounting" else ():
            at = design_at(design, over, float(bound), float(bound)).members[k]
            yield from (text for text in map(str, member_faults(name, at)) if text not in known)
