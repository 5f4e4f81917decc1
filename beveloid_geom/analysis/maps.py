"""Maps of a design: quantities of its path of contact over any two of its numeric inputs.

Inputs are named as in `pair.named_inputs`. Each cell of the map is a design with two changed values. The
cells are solved in vectorised calls.

A cell may have a path and still be useless: the relative curvature of the flanks may be negative
(`hollow`), so that the tangency is not the first contact, and a negative backlash makes the opposite flanks
interfere (`interferes`). Edge contact and hand-over between tooth pairs are found only with `operation=True`
(`mesh_cycle`).

Figs. 7 to 11 of the paper are lines of the map of the parabola coefficients. The cases C1 to C4 of the paper
are the quadrants of this map (`DesignMap.quadrants`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.path import path_ends
from ..design.arguments import require_numbers, require_single, require_two_numbers
from ..design.limits import parabola_limit
from ..design.model import Design, Errors, MeshErrors
from ..operation.backlash_by_tangency import jammed, tangent_backlash
from ..operation.mesh_cycle import mesh_cycle
from ..pair.misalignment import ERROR_CLASSES, errors_below, size_words
from ..pair.mounting import mounting_of, within_half_pitch
from ..pair.named_inputs import (
    INPUTS,
    PRESETS,
    Bounds,
    Inputs,
    bound_faults,
    bounds_argument,
    design_at,
    inputs_of,
    own_values,
)
from ..status import Status
from ..support.argument import ArgumentError
from ..support.array_repr import short_repr
from .optimise import Aim, objectives_of
from .path_measures import measures_of
from .tolerance import USUAL_AT

QUANTITIES = (
    "contact_ratio",
    "angle",
    "shift",
    "peak_to_peak",
    "centre",
    "normal_backlash",
    "mounted_backlash",
)
"""Quantities of a map: fields of DesignMap."""
IN_OPERATION = ("cycle_peak_to_peak", "edge_share")
"""Quantities that are computed only with `operation=True`."""


@dataclass(frozen=True, eq=False)
class DesignMap:
    """Quantities of a design over two inputs; arrays (n first values, m second values).

    Attributes
    ----------
    over : tuple of str
        Names of the inputs, keys of INPUTS.
    errors : Errors or MeshErrors
        Assembly errors for which `shift` is computed.
    first, second : FloatArray
        (n,) and (m,), values of the inputs, in the units of INPUTS.
    status : Codes
        Codes of `Status` of the path. All quantities of the path are NaN where it is not SOLVED.
    contact_ratio : FloatArray
        Eq. 16.
    angle : FloatArray
        Angle of the chord of the path to the axial direction in the side view (z, r) of the pinion, rad,
        -pi/2 to pi/2; positive if z increases with r.
    shift : FloatArray
        Shift of the position at mid-roll on the flank of the pinion, perpendicular to the path, under
        `errors`, mm. The squared shifts under +error and -error are averaged and added over the errors;
        `shift` is the root of this sum. NaN also where an error moves the path off the flanks.
    peak_to_peak : FloatArray
        Transmission error over the path of one tooth pair, rad.
    centre : FloatArray
        z at mid-roll on the pinion, mm.
    normal_backlash : FloatArray
        Normal backlash without parabolas and errors, mm. It is not reduced to half a pitch: it changes
        continuously over the map, starting from the backlash of the design.
    mounted_backlash : FloatArray
        Smallest backlash over a mesh cycle, mm, of the flanks without edge contact (`tangent_backlash`), with
        the parabolas, modifications and errors of the design of the cell, not with `errors`; NaN if unknown.
        Edges can touch earlier (`operation.backlash.mounted_backlash`).
    cycle_peak_to_peak, edge_share : FloatArray
        Transmission error of all teeth, rad, and share of the mesh cycle in which edges touch; NaN where not
        computed.
    """

    __repr__ = short_repr

    design: Design
    flank: str
    over: Inputs
    errors: Errors | MeshErrors
    first: FloatArray
    second: FloatArray
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
    def preset(self) -> str | None:
        """Name of the pair of inputs in PRESETS, or None."""
        return next((name for name, over in PRESETS.items() if over == self.over), None)

    @property
    def solved(self) -> Mask:
        """Cells with a path on the flanks."""
        return np.asarray(self.status == Status.SOLVED)

    @property
    def hollow(self) -> Mask:
        """Cells whose flanks are concave relative to each other: the sum of their parabola coefficients is
        positive."""
        cells = design_at(self.design, self.over, self.first[:, None], self.second)
        pinion, gear = (np.asarray(member.tool.parabola_of(self.flank)) for member in cells.members)
        total = pinion + gear
        return np.broadcast_to(total > 1e-9 * np.abs(total).max(), self.status.shape)

    @property
    def interferes(self) -> Mask:
        """Cells with negative backlash: the opposite flanks interfere."""
        backlash_rounding_mm = 1e-9
        return np.asarray(self.normal_backlash < -backlash_rounding_mm)

    @property
    def jammed(self) -> Mask:
        """Cells that cannot be assembled, with errors and modifications, by `mounted_backlash`. Cells with an
        unknown backlash are False."""
        return jammed(self.mounted_backlash, float(self.design.pinion.tool.normal_module))

    @property
    def sound(self) -> Mask:
        """Cells with a path that are not `hollow`, do not interfere and are not known to be `jammed`."""
        return self.solved & ~self.hollow & ~self.interferes & ~self.jammed

    def quadrants(self) -> dict[str, Mask]:
        """Return the cells of the paper's cases C1 to C4; cells on the axes belong to no case. Empty for
        other inputs."""
        # Signs of the parabola coefficients in the cases of the paper.
        quadrants: dict[str, tuple[int, int]] = {"C1": (1, 1), "C2": (-1, -1), "C3": (1, -1), "C4": (-1, 1)}
        if self.preset != "parabola":
            return {}
        return {
            name: np.logical_and.outer(pinion * self.first > 0.0, gear * self.second > 0.0)
            for name, (pinion, gear) in quadrants.items()
        }


def usual_bounds(design: Design, over: str | Inputs) -> tuple[Bounds, Bounds]:
    """Return the default bounds of both inputs.

    Parabola coefficients reach to plus and minus 0.012 / module in 1/mm (0.002 1/mm on Table 1, as in Figs. 9
    to 11 of the paper), or to the largest coefficient of the member, but not beyond `parabola_limit`. Apexes
    reach one module to both sides of the reference line. Mounting distances change by 0.6 times the larger
    face width; with more than half of it, some paths are lost. Profile shift coefficients change by 0.3.
    Raises ArgumentError for other inputs."""
    first, second = (_usual(design, name) for name in inputs_of(over))
    return first, second


def _usual(design: Design, name: str) -> Bounds:
    member = design.gear if name.endswith("gear") else design.pinion
    if name.startswith("parabola_apex"):
        return -(module := float(member.tool.normal_module)), module
    if name.startswith("parabola"):
        coefficients = [abs(float(value)) for value in member.tool.parabolas.values()]
        usual = max(0.012 / float(member.tool.normal_module), *coefficients)
        return -(most := min(usual, parabola_limit(member))), most
    if name.endswith("mounting_change"):
        change = 0.6 * max(float(each.face_width) for each in design.members)
        return -change, change
    if name.startswith("profile_shift"):
        return float(member.profile_shift) - 0.3, float(member.profile_shift) + 0.3
    unit = INPUTS[name][1] or "normal modules"
    text = f"must be given, because it has no usual range: give the lower and the upper limit in {unit}"
    raise ArgumentError(bounds_argument(name), text)


def usual_errors(design: Design) -> Errors | MeshErrors:
    """Return errors as large as the usual tolerances. They are about the common perpendicular or at the mesh,
    like the errors of the design."""
    usual = USUAL_AT[design.errors_at]
    return ERROR_CLASSES[design.errors_at](*usual.values().tolist())


def design_map(
    design: Design,
    over: str | Inputs,
    flank: str = "right",
    *,
    first: Bounds | None = None,
    second: Bounds | None = None,
    steps: int = 21,
    errors: Errors | MeshErrors | None = None,
    operation: bool = False,
    progress: Callable[[int], object] | None = None,
) -> DesignMap:
    """Compute quantities of a design over `steps` times `steps` values of two of its inputs.

    Parameters
    ----------
    design : Design
        A single design.
    over : str or tuple of str
        A key of PRESETS, or two keys of INPUTS.
    flank : {'right', 'left'}
    first, second : tuple of float, optional
        Bounds of the inputs, in the units of INPUTS; `usual_bounds` by default.
    steps : int
        Number of values of each input, 2 to 201.
    errors : Errors or MeshErrors, optional
        Assembly errors of the shift; the usual tolerances by default.
    operation : bool
        Compute the mesh cycle of each cell as well.
    progress : callable, optional
        Called with the number of cells computed since the last call.

    Returns
    -------
    DesignMap

    Raises
    ------
    ArgumentError
        For unknown inputs; for bounds that are missing, do not increase, are outside the limits of their
        input, or with which a member cannot be generated.
    ValueError
        For a batch; for errors that are not finite or all 0; for steps outside the limits.

    Notes
    -----
    A cell takes as long as 1 to 20 paths of 101 positions, a mesh cycle as long as 20 to 30.

    References
    ----------
    Definitions: beveloid_geom/analysis/README.md, Maps and the recommendation of the paper.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> design = bg.builtin_design("ni-2017")
    >>> grid = bg.design_map(design, "parabola", first=(0.0, 0.001), second=(-0.001, 0.0), steps=2)
    >>> grid.contact_ratio.round(3)
    array([[1.307, 1.651],
           [1.816, 0.075]])
    """
    cells_per_call = 512
    require_single(design)
    flank_sign(flank)
    over = inputs_of(over)
    require_two_numbers(first=first, second=second)
    require_numbers(steps=steps)
    bounds = tuple(
        _usual(design, name) if given is None else given
        for name, given in zip(over, (first, second), strict=True)
    )
    errors = usual_errors(design) if errors is None else errors
    _check(design, over, bounds, steps, errors)
    first_values, second_values = (low + (high - low) * np.linspace(0.0, 1.0, steps) for low, high in bounds)
    x, y = (side.ravel() for side in np.meshgrid(first_values, second_values, indexing="ij"))
    rows: dict[str, list[FloatArray]] = {name: [] for name in ("status", *QUANTITIES, *IN_OPERATION)}
    for start in range(0, x.size, cells_per_call):
        block = slice(start, start + cells_per_call)
        for name, column in _cells(design, over, flank, errors, x[block], y[block]).items():
            rows[name].append(column)
        cells = np.full((len(IN_OPERATION), x[block].size), np.nan)
        for k in range(x[block].size) if operation else ():
            cells[:, k] = _in_operation(
                design_at(design, over, float(x[start + k]), float(y[start + k])), flank
            )
            if progress is not None:
                progress(1)
        for name, column in zip(IN_OPERATION, cells, strict=True):
            rows[name].append(column)
        if progress is not None and not operation:
            progress(x[block].size)
    grids = {name: np.concatenate(parts).reshape(steps, steps) for name, parts in rows.items()}
    status = grids.pop("status").astype(np.int8)
    return DesignMap(design, flank, over, errors, first_values, second_values, status, **grids)


def _cells(
    design: Design,
    over: Inputs,
    flank: str,
    errors: Errors | MeshErrors,
    first: FloatArray,
    second: FloatArray,
) -> dict[str, FloatArray]:
    """Return status and quantities of cells (n,); one call computes each quantity for all cells."""
    cells = design_at(design, over, first, second)
    parabola = (np.broadcast_to(m.tool.parabola_of(flank), first.shape) for m in cells.members)
    with np.errstate(invalid="ignore"):  # a path may be a single point, which has no direction
        measures, shown = measures_of(cells, flank), objectives_of(cells, flank, Aim(errors), *parabola)
    backlash = _backlash(design, over, first, second)
    status, lost = np.full(first.size, Status.SOLVED, dtype=float), measures.limit[:, 0] < 0
    if lost.any():
        status[lost] = path_ends(design_at(design, over, first[lost], second[lost]), flank).status
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


def _backlash(design: Design, over: Inputs, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the normal backlash (n,), mm, of cells.

    `mounting_of` reduces the backlash to plus and minus half a pitch. The number of pitches to be added
    follows from the linear change of the backlash with both values."""
    values, tool, step = np.array(own_values(design, over)), design.gear.tool, 1e-3
    pitch = np.pi * float(tool.normal_module) * np.cos(float(tool.normal_pressure_angle))
    near = values[:, None] + step * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    given, *moved = np.broadcast_to(mounting_of(design_at(design, over, *near)).normal_backlash, 3)
    rates = within_half_pitch(np.array(moved) - given, pitch) / step
    linear = given + rates @ (np.stack((first, second)) - values[:, None])
    reduced = mounting_of(design_at(design, over, first, second)).normal_backlash
    return np.asarray(reduced + pitch * np.round((linear - reduced) / pitch))


def _in_operation(design: Design, flank: str) -> list[float]:
    """Return the quantities IN_OPERATION of a cell; NaN if they are not known."""
    try:
        cycle = mesh_cycle(design, flank, 1)
    except ValueError:  # the fillets of a tool whose tip rounds overlap are not defined
        return [np.nan] * len(IN_OPERATION)
    return [float(cycle.peak_to_peak), float(cycle.edge_share)]


def _check(
    design: Design, over: Inputs, bounds: tuple[Bounds, ...], steps: int, errors: Errors | MeshErrors
) -> None:
    if not 2 <= steps <= 201 or steps != int(steps):
        raise ValueError(f"steps must be a whole number from 2 to 201, got {steps}")
    values = [float(value) for value in vars(errors).values()]
    if not any(values):
        raise ValueError(f"errors of a map must be finite and not all 0, got {values}")
    for name, most in errors_below(design).items():
        if abs(error := float(getattr(errors, name, 0.0))) >= most:
            text = f"must be less than {size_words(name, most)} on this pair, got {size_words(name, error)}"
            raise ArgumentError(f"error of {name}", f"{text}: is the unit right?")
    for name, (low, high) in zip(over, bounds, strict=True):
        if not (-np.inf < low < high < np.inf and float(high) - float(low) < np.inf):
            text = f"must be two finite values, lower one first, got {low}, {high}"
            raise ArgumentError(bounds_argument(name), text)
    for fault in bound_faults(design, over, bounds):
        raise fault
