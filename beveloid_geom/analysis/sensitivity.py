"""How a path of contact answers the assembly errors: exact derivatives, not differences of results.

The path is a curve in y = (l1, l2, n_x, n_y, w1) with four equations R(y, e) = 0 that hold the assembly
errors e (`parallel.regular`). A place of it is fixed by a fifth one, c(y, e) = 0: at an end that the
limit met there is met still, in the middle that the pinion's roll is the mean of the rolls of both ends. Both
differentiated,

    [R_y; c_y] dy/de = -[R_e; c_e],   dq/de = q_y dy/de + q_e

for any quantity q of the contact. All derivatives on the right hand side come from a complex step in
y, in the layout and in the axial positions, exact to rounding. The mounting is held, as everywhere:
errors move members that were mounted without them. Derivatives by errors at the mesh follow from those by the
four errors about the common perpendicular by the chain rule (`pair.mesh_errors.by_mesh_errors`).

A greatest or least value along the path (transmission error, roll) is at an end, and moves as the end
does, or inside, where q does not change along the path: there any c does, and the one square to the
path is taken. Where two places share the greatest value the derivative is that of one of them.

Source: none in the paper, which draws paths under single errors (Figs. 12 to 15).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import COMPLEX_STEP, Codes, FloatArray, Integers
from ..contact.ends import at_shares
from ..contact.equation import (
    Meeting,
    Pairing,
    axial_and_radius,
    limit_margins,
    pairing_of,
    trace_parameters,
)
from ..contact.parallel.lines import along_lines
from ..contact.parallel.regular import (
    UNKNOWNS,
    meet_regular,
    point_on_curve,
    tangent_of,
    units_of_all,
)
from ..contact.path_polynomial import HEIGHT, NORMAL, PHASE, POINT, ROLL, PathSeries
from ..contact.path_search import Group, paths_on_flanks
from ..design.model import Design, ErrorsAt
from ..gear.flank import flank_patch
from ..gear.rack import Numbers
from ..pair.errors import ERROR_NAMES, NAMES
from ..pair.frames import layout_at
from ..pair.mesh_errors import by_mesh_errors
from ..status import Status
from ..support.chebyshev import evaluate, greatest
from ..support.few_lines import few_lines

PLACES = ("enter", "middle", "leave")
CASES_PER_BLOCK = 256
ALONG = 1e-9
"""Share of its way along the face up to which a path keeps l."""
AT_END = 1e-12
"""Distance, in the series's parameter, within which an extreme is at the end of the path."""
# Rows of `_quantities`.
_L, _U, _Z, _R, _ROLLS = (slice(2 * k, 2 * k + 2) for k in range(5))
_ROLL, _PHASE, _MARGINS = 8, 10, 11
_NO_ROW = -1
_WIDTH = _MARGINS * (len(ERROR_NAMES) + 2)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Places of one path and their derivatives by the errors whose names are `errors`, mm and rad.

    Batch axes lead, then place (enter, middle, leave), member (pinion, gear), error. `l`, `z`, `r`
    (..., 3, 2), mm: flank parameter, z from mid-face towards the heel, radius; `pinion_roll` (..., 3), rad.
    The same with `_by`, one axis more: derivatives of the place itself. Of the path as a curve on the
    member's flank, both (..., 3, 2, errors) and positive towards the heel: `face_shift_by`, of z at the same
    l; `square_shift_by`, along the flank and square to the path.

    `contact_ratio` (Eq. 16), `peak_to_peak` of the transmission error over the path (rad), batch
    shape; `contact_ratio_by`, `peak_to_peak_by` (..., errors). `limit` (..., 2): codes of `Limit` met by
    the ends. `status`: codes of `Status`; all is NaN, and `limit` -1, where it is not SOLVED. The
    middle is NaN where the roll turns back along the path."""

    __repr__ = few_lines

    flank: str
    errors: tuple[str, ...]
    l: FloatArray
    z: FloatArray
    r: FloatArray
    pinion_roll: FloatArray
    l_by: FloatArray
    z_by: FloatArray
    r_by: FloatArray
    pinion_roll_by: FloatArray
    face_shift_by: FloatArray
    square_shift_by: FloatArray
    contact_ratio: FloatArray
    contact_ratio_by: FloatArray
    peak_to_peak: FloatArray
    peak_to_peak_by: FloatArray
    limit: Codes
    status: Codes


@dataclass(frozen=True, eq=False)
class _Rates:
    """At places of the path (cases, places): quantities q (rows, ...), their derivatives by y and
    by the errors, and those of the four equations (..., 4, 5); y in units."""

    q: FloatArray
    q_y: FloatArray
    q_e: FloatArray
    r_y: FloatArray
    r_e: FloatArray


def path_sensitivity(
    design: Design, flank: str = "right", errors_at: ErrorsAt = "perpendicular"
) -> Sensitivity:
    """Differentiate a design's path of contact by the assembly errors, under the errors it has.

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape.
    flank : {'right', 'left'}
    errors_at : {'perpendicular', 'mesh'}
        Where the errors are measured by which is differentiated.

    Returns
    -------
    Sensitivity

    Raises
    ------
    ValueError
        For arrays without elements and for an unknown flank.
    """
    if 0 in design.batch_shape:
        raise ValueError("the design holds an array without elements: there is nothing to solve")
    pairing = pairing_of(design, flank)
    cases = pairing.branch.shape[0]
    table, limit = np.full((_WIDTH, cases, len(PLACES)), np.nan), np.full((cases, 2), -1, dtype=np.int8)
    scalars, status = np.full((2, cases, 1 + len(ERROR_NAMES)), np.nan), np.empty(cases, dtype=np.int8)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for start in range(0, cases, CASES_PER_BLOCK):
            block = np.arange(start, min(start + CASES_PER_BLOCK, cases))
            for group in paths_on_flanks(pairing.cases(block)):
                own = block[group.cases]
                table[:, own], scalars[:, own] = _of_group(group)
                limit[own], status[own] = group.ends.limit, group.ends.status
        lines = along_lines(pairing)
        table.reshape(_MARGINS, -1, cases, len(PLACES))[:, 1:, lines] = np.nan
        scalars[:, lines, 1:] = np.nan
        found = _result(design, flank, pairing, table, scalars, limit, status)
    return found if errors_at == "perpendicular" else _by_mesh_errors(design, found)


def _by_mesh_errors(design: Design, found: Sensitivity) -> Sensitivity:
    """Give the same with derivatives by the errors at the mesh."""
    rates = {name: value for name, value in vars(found).items() if name.endswith("_by")}
    turned: dict[str, Any] = {name: by_mesh_errors(design, value) for name, value in rates.items()}
    return replace(found, errors=NAMES["mesh"], **turned)


def _of_group(group: Group) -> tuple[FloatArray, FloatArray]:
    """Rows (_WIDTH, cases, places): values, derivatives by the errors, direction of the path; and roll
    and transmission error between their extremes (2, cases, 5), each with its derivatives."""
    series, ends = group.series, group.ends
    enter, leave = ends.x[:, :1], ends.x[:, 1:]
    middle = np.where(ends.turning[:, None], np.nan, at_shares(series, ends, np.zeros(1)))
    between = np.sort(ends.x, axis=-1)
    signed = [sign * series.coefficients[row] for row in (ROLL, PHASE) for sign in (1.0, -1.0)]
    spans = [greatest(one, between[:, :1], between[:, 1:]) for one in signed]
    x = np.concatenate((enter, middle, leave, *spans), axis=-1)
    y, units = _curve_points(series, x), units_of_all(group.pairing)
    rates = _rates(group.pairing, y, units)
    tangent = tangent_of(rates.r_y)
    at = np.stack([np.abs(x - end) <= AT_END for end in (enter, leave)])
    met = np.where(at[0], ends.limit[:, :1], ends.limit[:, 1:])
    row = np.where(at.any(axis=0), _MARGINS + met, _NO_ROW)
    by = _by_errors(rates, row, tangent)
    # The middle follows the rolls of the ends.
    goal = 0.5 * (by[_ROLL, :, 0] + by[_ROLL, :, 2])
    along = np.einsum("qpsi,psi->qps", rates.q_y, tangent)
    missing = (goal - by[_ROLL, :, 1]) / along[_ROLL, :, 1, None]
    by[:, :, 1] += along[:, :, 1, None] * missing
    places = np.concatenate(
        (rates.q[:_MARGINS, :, :3, None], by[:_MARGINS, :, :3], along[:_MARGINS, :, :3, None]), -1
    )
    swing = [
        np.concatenate(
            (rates.q[row, :, k, None] - rates.q[row, :, k + 1, None], by[row, :, k] - by[row, :, k + 1]), -1
        )
        for row, k in ((_ROLL, 3), (_PHASE, 5))
    ]
    return np.moveaxis(places, -1, 1).reshape(_WIDTH, *x.shape[:1], 3), np.stack(swing)


def _curve_points(series: PathSeries, x: FloatArray) -> FloatArray:
    """y = (l1, l2, n_x, n_y, w1) (5, cases, places) at parameters of the series."""
    rows = evaluate(series.coefficients[:HEIGHT], x)
    point, normal = (np.moveaxis(rows[part], 0, -1) for part in (POINT, NORMAL))
    return point_on_curve(point, normal, rows[0], rows[1])


def _rates(pairing: Pairing, y: FloatArray, units: FloatArray) -> _Rates:
    """Find quantities and derivatives at points of the curve (5, cases, places)."""
    _, cases, places = y.shape
    step = COMPLEX_STEP * 1j
    turns = np.zeros((UNKNOWNS, 1, 1, UNKNOWNS + len(ERROR_NAMES)), dtype=complex)
    turns[:, 0, 0, :UNKNOWNS] = step * np.eye(UNKNOWNS)
    moved = y[..., None] + turns * units[..., None]
    errors = np.zeros((len(ERROR_NAMES), UNKNOWNS + len(ERROR_NAMES)), dtype=complex)
    errors[:, UNKNOWNS:] = step * np.eye(len(ERROR_NAMES))
    near = _under_errors(pairing, np.tile(errors, places))
    residual, met = meet_regular(near, moved.reshape(UNKNOWNS, cases, -1))
    l = moved.reshape(UNKNOWNS, cases, -1)[:2]
    z, radius = axial_and_radius(near, met)
    roll = _rolls(near, met)
    phase = roll[1] + pairing.teeth[0] / pairing.teeth[1] * roll[0]
    u = trace_parameters(near, met, z)
    q = np.concatenate((l, u, z, radius, roll, phase[None], limit_margins(near, l, z, radius)))
    q = q.reshape(len(q), cases, places, -1)
    residual = np.moveaxis(residual.reshape(4, cases, places, -1), 0, -2).imag / COMPLEX_STEP
    slope = q.imag / COMPLEX_STEP
    y_part, e_part = slice(UNKNOWNS), slice(UNKNOWNS, None)
    return _Rates(
        q[..., 0].real, slope[..., y_part], slope[..., e_part], residual[..., y_part], residual[..., e_part]
    )


def _under_errors(pairing: Pairing, errors: Numbers) -> Pairing:
    """Give the pairing under further errors (4, positions), by ERROR_NAMES, which may be complex."""
    old = pairing.layout
    layout = layout_at(old.offset + errors[0], old.shaft_angle + old.sense * errors[1], old.sense)
    return replace(pairing, layout=layout, position=pairing.position + errors[2:, None])


def _rolls(pairing: Pairing, met: Meeting) -> Numbers:
    """Find `roll_angles` for complex terms: the imaginary part is that of the first order."""
    (nx, ny, v), (x0, y0, z0) = met.own, met.start
    across, along = met.normal_y * nx - met.normal_x * ny, met.normal_x * nx + met.normal_y * ny
    turn = (along.real * across.imag - across.real * along.imag) / (along.real**2 + across.real**2)
    drawn = nx * (pairing.rack.pitch_radius + x0) + ny * y0 + v * (z0 + pairing.position)
    return np.asarray(np.arctan2(across.real, along.real) + 1j * turn + (met.along - drawn) / met.moment)


def _by_errors(rates: _Rates, row: Integers, tangent: FloatArray) -> FloatArray:
    """Find derivatives of all quantities (rows, cases, places, errors), each place held by the zero of the
    quantity in `row`, or where it has none, square to the path."""
    cases, places = np.indices(row.shape)
    held = row == _NO_ROW
    last_y = np.where(held[..., None], tangent, rates.q_y[row, cases, places])
    last_e = np.where(held[..., None], 0.0, rates.q_e[row, cases, places])
    system = np.concatenate((rates.r_y, last_y[..., None, :]), axis=-2)
    right = np.concatenate((rates.r_e, last_e[..., None, :]), axis=-2)
    lost = ~np.isfinite(system.sum(axis=(-1, -2)) + right.sum(axis=(-1, -2)))
    system[lost] = np.eye(UNKNOWNS)
    lost |= np.linalg.det(system) == 0.0
    system[lost], right[lost] = np.eye(UNKNOWNS), np.nan
    moves = -np.linalg.solve(system, right)
    return np.asarray(np.einsum("qpsi,psie->qpse", rates.q_y, moves) + rates.q_e)


def _shifts(
    design: Design, flank: str, l: FloatArray, u: FloatArray, by: FloatArray, along: FloatArray
) -> FloatArray:
    """Find the shift of the path along each member's flank and square to it (2, cases, places, errors),
    from the derivatives `by` of l and u (2, 2, cases, places, errors) and its direction in them."""
    patch = flank_patch(design.stacked_members(), flank, l, u)
    tangents = np.stack((patch.tangent_l, patch.tangent_u))
    path = np.einsum("kjcpi,kjcp->jcpi", tangents, along)
    side = np.cross(patch.normal, path)
    side *= (np.sign(side[..., 2]) / np.linalg.norm(side, axis=-1))[..., None]
    return np.asarray(np.einsum("jcpi,kjcpi,kjcpe->jcpe", side, tangents, by))


def _result(
    design: Design,
    flank: str,
    pairing: Pairing,
    table: FloatArray,
    scalars: FloatArray,
    limit: Codes,
    status: Codes,
) -> Sensitivity:
    """Give the rows of all cases in the batch shape, and what follows from them."""
    shape, count = design.batch_shape, len(ERROR_NAMES)
    rows = table.reshape(_MARGINS, count + 2, *table.shape[1:])
    value, by, along = rows[:, 0], np.moveaxis(rows[:, 1:-1], 1, -1), rows[:, -1]
    face = by[_Z] - (along[_Z] / along[_L])[..., None] * by[_L]
    # A path that runs along the face has no shift along it.
    face = np.where((np.abs(along[_L]) > ALONG * np.abs(along[_Z]))[..., None], face, np.nan)
    square = _shifts(
        design, flank, value[_L], value[_U], np.stack((by[_L], by[_U])), np.stack((along[_L], along[_U]))
    )
    per_pitch = pairing.teeth[0, :, 0, None] / (2.0 * np.pi)
    ratio, swing = scalars[0] * per_pitch, scalars[1]
    plain = (np.asarray(pairing.rack.parabola) == 0.0).all(axis=0) & (status == Status.SOLVED)[:, None]
    swing = np.where(plain & ~np.isnan(scalars[1]), 0.0, swing)

    def batch(values: FloatArray) -> FloatArray:
        """(2, cases, places, ...) in the order of the result."""
        return np.moveaxis(values, 0, 2).reshape(*shape, len(PLACES), 2, *values.shape[3:])

    return Sensitivity(
        flank=flank,
        errors=ERROR_NAMES,
        l=batch(value[_L]),
        z=batch(value[_Z]),
        r=batch(value[_R]),
        pinion_roll=value[_ROLL].reshape(*shape, len(PLACES)),
        l_by=batch(by[_L]),
        z_by=batch(by[_Z]),
        r_by=batch(by[_R]),
        pinion_roll_by=by[_ROLL].reshape(*shape, len(PLACES), count),
        face_shift_by=batch(face),
        square_shift_by=batch(square),
        contact_ratio=ratio[:, 0].reshape(shape),
        contact_ratio_by=ratio[:, 1:].reshape(*shape, count),
        peak_to_peak=swing[:, 0].reshape(shape),
        peak_to_peak_by=swing[:, 1:].reshape(*shape, count),
        limit=limit.reshape(*shape, 2),
        status=status.reshape(shape),
    )
