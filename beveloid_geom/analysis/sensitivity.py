"""Derivatives of a path of contact with respect to the assembly errors, exact to rounding.

The path is a curve in y = (l1, l2, n_x, n_y, w1) with four equations R(y, e) = 0 that contain the assembly
errors e (`contact.parallel.small_angle_equations`). l1 and l2 are the flank parameters, n_x and n_y are
components of the common normal, and w1 is the position of the contact in the plane of action of the pinion,
perpendicular to the normal (`contact.equation`). A position on the path is fixed by a fifth equation c(y, e)
= 0. At an end, c states that the limit is still met; in the middle, that the pinion roll is the mean of the
rolls of both ends. Differentiation gives

    [R_y; c_y] dy/de = -[R_e; c_e],   dq/de = q_y dy/de + q_e

for any quantity q of the contact. The partial derivatives of R, c and q come from complex steps in y, in the
layout and in the axial positions. The mounting is constant: errors displace members that were mounted without
errors. Derivatives by errors at the mesh follow from those by the four errors about the common perpendicular
by the chain rule (`pair.misalignment_at_mesh.by_mesh_errors`).

An extremum along the path (transmission error, roll) is either at an end and moves with it, or inside the
path, where q is stationary. There any c can be used; we take the plane perpendicular to the path. If two
positions share the largest value, the derivative is that of one of them.

Source: not in the paper, which shows paths under single errors (Figs. 12 to 15)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import COMPLEX_STEP, Codes, FloatArray, Integers, Mask
from ..contact.equation import ContactTerms, axial_and_radius, limit_margins, trace_parameters
from ..contact.flank_pair import FlankPair, generated_pairing, is_modified
from ..contact.parallel.paths import along_lines
from ..contact.parallel.small_angle_equations import (
    UNKNOWN_COUNT,
    meet_regular,
    point_on_curve,
    tangent_of,
    units_of_all,
)
from ..contact.path_polynomial import NORMAL, PHASE, POINT, ROLL, ROW_COUNT, PathSeries
from ..contact.path_positions import at_shares
from ..contact.path_search import Group, generated_paths, paths_on_flanks
from ..contact.surfaces.path_rates import surface_rates
from ..contact.surfaces.paths import surface_paths
from ..design.arguments import require_design
from ..design.model import Design, ErrorsAt
from ..gear.flank import flank_patch
from ..gear.rack import Numbers
from ..pair.frames import layout_at
from ..pair.misalignment import ERROR_NAMES, NAMES
from ..pair.misalignment_at_mesh import by_mesh_errors
from ..status import Status
from ..support.array_repr import short_repr
from ..support.chebyshev import evaluate, greatest
from .mountings import PLACES

# Rows of `_Rates.q`: pinion roll, and the first margin. The row before the margins is the transmission error.
_ROLL, _MARGINS = 8, 11
_COLUMNS = _MARGINS * (len(ERROR_NAMES) + 2)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Positions of a path and their derivatives with respect to the assembly errors.

    Axes: batch, position (enter, middle, leave), member (pinion, gear), error. Names ending in `_by` are
    derivatives with an additional axis for the errors, mm and rad. All values are NaN, and `limit` -1, unless
    `status` is SOLVED. The middle is NaN if the roll turns back along the path. In line contact the
    derivatives do not exist and are NaN. `face_shift_by` is also NaN if the path runs along the face.

    Attributes
    ----------
    errors : tuple of str
        Names of the errors.
    l, z, r : FloatArray
        (..., 3, 2), flank parameter, z from mid-face, and radius, mm.
    pinion_roll : FloatArray
        (..., 3), rad.
    face_shift_by : FloatArray
        (..., 3, 2, errors), derivative of z of the path at constant l, positive towards +z.
    square_shift_by : FloatArray
        (..., 3, 2, errors), derivative of the position of the path on the flank, perpendicular to the path,
        positive towards +z; "square" means perpendicular, not squared.
    l_by, z_by, r_by, pinion_roll_by : FloatArray
        Derivatives of `l`, `z`, `r` and `pinion_roll`.
    contact_ratio_by, peak_to_peak_by : FloatArray
        (..., errors), derivatives of `contact_ratio` and `peak_to_peak`. If the transmission error is 0 along
        the path, `peak_to_peak_by` is NaN for an error if both its signs increase it.
    contact_ratio, peak_to_peak : FloatArray
        Eq. 16, and transmission error over the path, rad.
    limit : Codes
        (..., 2), codes of `Limit` at the ends.
    status : Codes
        Codes of `Status`.
    """

    __repr__ = short_repr

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
    """Values at positions of the path (cases, positions): quantities q (rows, ...), their derivatives by y
    and by the errors, and those of the four equations (..., 4, 5); y in units."""

    q: FloatArray
    q_y: FloatArray
    q_e: FloatArray
    r_y: FloatArray
    r_e: FloatArray


def path_sensitivity(
    design: Design, flank: str = "right", errors_at: ErrorsAt = "perpendicular"
) -> Sensitivity:
    """Compute the derivatives of the path of contact with respect to the assembly errors, at the errors of
    the design.

    Parameters
    ----------
    design : Design
        Array quantities broadcast to its batch shape.
    flank : {'right', 'left'}
    errors_at : {'perpendicular', 'mesh'}
        Kind of errors: about the common perpendicular, or at the mesh (about the pitch point).

    Returns
    -------
    Sensitivity

    Raises
    ------
    ValueError
        For arrays without elements and for an unknown flank.

    References
    ----------
    Method: beveloid_geom/analysis/README.md, Sensitivity.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> sensitivity = bg.path_sensitivity(bg.builtin_design("ni-2017"))
    >>> sensitivity.errors[0], sensitivity.z_by.shape
    ('offset', (3, 2, 4))
    >>> print(f"{sensitivity.z_by[1, 0, 0]:.1f} mm per mm")
    25.2 mm per mm
    """
    require_design(design)
    if 0 in design.batch_shape:
        raise ValueError("the design contains an array without elements: give at least one case")
    pairing = generated_pairing(design, flank)
    cases = pairing.branch.shape[0]
    table, limit = (
        np.full((_COLUMNS, cases, len(PLACES)), np.nan),
        np.full((cases, 2), -1, dtype=np.int8),
    )
    scalars, status = np.full((2, cases, 1 + len(ERROR_NAMES)), np.nan), np.empty(cases, dtype=np.int8)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        modified = is_modified(design, flank)
        lines = along_lines(pairing) & (not modified)
        if modified:
            sense = np.broadcast_to(pairing.layout.sense, (cases, 1))[:, 0]
            for path in surface_paths(design, flank):
                places, scalars[:, path.cases] = surface_rates(path, sense[path.cases])
                table[:, path.cases] = places.reshape(_COLUMNS, *places.shape[2:])
                limit[path.cases], status[path.cases] = path.segment.limit, path.segment.status
                lines[path.cases] = path.problem.line_contact
        cases_per_block = 256
        for start in range(0, 0 if modified else cases, cases_per_block):
            block = np.arange(start, min(start + cases_per_block, cases))
            single = not design.batch_shape  # then the path may be known
            groups = generated_paths(design, flank) if single else paths_on_flanks(pairing.cases(block))
            for group in groups:
                group_cases = block[group.cases]
                table[:, group_cases], scalars[:, group_cases] = _of_group(group)
                limit[group_cases], status[group_cases] = group.ends.limit, group.ends.status
        table.reshape(_MARGINS, -1, cases, len(PLACES))[:, 1:, lines] = np.nan
        scalars[:, lines, 1:] = np.nan
        generated = pairing.without_parabola & (not modified)  # has no transmission error under any error
        scalars[1, :, 1:][_at_kink(table, scalars[1, :, 0]) & ~generated[:, None]] = np.nan
        sensitivity = _result(design, flank, pairing, table, scalars, limit, status)
    return sensitivity if errors_at == "perpendicular" else _by_mesh_errors(design, sensitivity)


def _at_kink(table: FloatArray, swing: FloatArray) -> Mask:
    """Return (cases, errors) where errors of both signs increase the transmission error, so that its
    peak-to-peak value `swing` (cases), rad, has no derivative.

    The transmission error is then 0 along the path, and its derivatives at the `PLACES` differ."""
    zero_tolerance_rad = 1e-12
    rate_tolerance = 1e-9  # rad per mm or rad
    rates = table.reshape(_MARGINS, -1, *table.shape[1:])[_MARGINS - 1, 1:-1]
    spread = np.fmax.reduce(rates, axis=-1) - np.fmin.reduce(rates, axis=-1)
    zero = np.abs(swing) <= zero_tolerance_rad
    return np.asarray((spread > rate_tolerance).T & zero[:, None])


def _by_mesh_errors(design: Design, sensitivity: Sensitivity) -> Sensitivity:
    """Return the sensitivity with derivatives by the errors at the mesh."""
    rates = {name: value for name, value in vars(sensitivity).items() if name.endswith("_by")}
    turned: dict[str, Any] = {name: by_mesh_errors(design, value) for name, value in rates.items()}
    return replace(sensitivity, errors=NAMES["mesh"], **turned)


def _of_group(group: Group) -> tuple[FloatArray, FloatArray]:
    """Return rows (_COLUMNS, cases, positions) of values, derivatives by the errors and direction of the
    path; and roll and transmission error between their extrema (2, cases, 5), each with its derivatives."""
    # Distance, in the parameter of the series, within which an extremum is at the end of the path.
    at_end = 1e-12
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
    at = np.stack([np.abs(x - end) <= at_end for end in (enter, leave)])
    met = np.where(at[0], ends.limit[:, :1], ends.limit[:, 1:])
    row = np.where(at.any(axis=0), _MARGINS + met, -1)
    by = _by_errors(rates, row, tangent)
    # The roll of the middle is the mean of the rolls of the ends: correct the middle along the path.
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
        for row, k in ((_ROLL, 3), (_MARGINS - 1, 5))
    ]
    return np.moveaxis(places, -1, 1).reshape(_COLUMNS, *x.shape[:1], 3), np.stack(swing)


def _curve_points(series: PathSeries, x: FloatArray) -> FloatArray:
    """Return y = (l1, l2, n_x, n_y, w1) (5, cases, positions) at parameters of the series."""
    rows = evaluate(series.coefficients[:ROW_COUNT], x)
    point, normal = (np.moveaxis(rows[part], 0, -1) for part in (POINT, NORMAL))
    return point_on_curve(point, normal, rows[0], rows[1])


def _rates(pairing: FlankPair, y: FloatArray, units: FloatArray) -> _Rates:
    """Return quantities and derivatives at points of the curve (5, cases, positions)."""
    _, cases, places = y.shape
    step = COMPLEX_STEP * 1j
    turns = np.zeros((UNKNOWN_COUNT, 1, 1, UNKNOWN_COUNT + len(ERROR_NAMES)), dtype=complex)
    turns[:, 0, 0, :UNKNOWN_COUNT] = step * np.eye(UNKNOWN_COUNT)
    moved = y[..., None] + turns * units[..., None]
    errors = np.zeros((len(ERROR_NAMES), UNKNOWN_COUNT + len(ERROR_NAMES)), dtype=complex)
    errors[:, UNKNOWN_COUNT:] = step * np.eye(len(ERROR_NAMES))
    near = _under_errors(pairing, np.tile(errors, places))
    residual, met = meet_regular(near, moved.reshape(UNKNOWN_COUNT, cases, -1))
    l = moved.reshape(UNKNOWN_COUNT, cases, -1)[:2]
    z, radius = axial_and_radius(near, met)
    roll = _rolls(near, met)
    phase = roll[1] + pairing.teeth[0] / pairing.teeth[1] * roll[0]
    u = trace_parameters(near, met, z)
    q = np.concatenate((l, u, z, radius, roll, phase[None], limit_margins(near, l, z, radius)))
    q = q.reshape(len(q), cases, places, -1)
    residual = np.moveaxis(residual.reshape(4, cases, places, -1), 0, -2).imag / COMPLEX_STEP
    slope = q.imag / COMPLEX_STEP
    y_part, e_part = slice(UNKNOWN_COUNT), slice(UNKNOWN_COUNT, None)
    return _Rates(
        q[..., 0].real, slope[..., y_part], slope[..., e_part], residual[..., y_part], residual[..., e_part]
    )


def _under_errors(pairing: FlankPair, errors: Numbers) -> FlankPair:
    """Return the flank pair under additional errors (4, positions), in the order of ERROR_NAMES; they may be
    complex."""
    old = pairing.layout
    layout = layout_at(old.offset + errors[0], old.shaft_angle + old.sense * errors[1], old.sense)
    return replace(pairing, layout=layout, position=pairing.position + errors[2:, None])


def _rolls(pairing: FlankPair, met: ContactTerms) -> Numbers:
    """Return `roll_angles` of complex terms, with the imaginary part to first order."""
    (nx, ny, v), (x0, y0, z0) = met.normal, met.start
    across, along = met.normal_y * nx - met.normal_x * ny, met.normal_x * nx + met.normal_y * ny
    turn = (along.real * across.imag - across.real * along.imag) / (along.real**2 + across.real**2)
    drawn = nx * (pairing.rack.pitch_radius + x0) + ny * y0 + v * (z0 + pairing.position)
    return np.asarray(np.arctan2(across.real, along.real) + 1j * turn + (met.along - drawn) / met.moment)


def _by_errors(rates: _Rates, row: Integers, tangent: FloatArray) -> FloatArray:
    """Return derivatives of all quantities (rows, cases, positions, errors). Each position is fixed by the
    zero of the quantity in `row`, or, if this is -1, by the plane perpendicular to the path."""
    cases, places = np.indices(row.shape)
    held = row < 0
    last_y = np.where(held[..., None], tangent, rates.q_y[row, cases, places])
    last_e = np.where(held[..., None], 0.0, rates.q_e[row, cases, places])
    system = np.concatenate((rates.r_y, last_y[..., None, :]), axis=-2)
    right = np.concatenate((rates.r_e, last_e[..., None, :]), axis=-2)
    lost = ~np.isfinite(system.sum(axis=(-1, -2)) + right.sum(axis=(-1, -2)))
    system[lost] = np.eye(UNKNOWN_COUNT)
    lost |= np.linalg.det(system) == 0.0
    system[lost], right[lost] = np.eye(UNKNOWN_COUNT), np.nan
    moves = -np.linalg.solve(system, right)
    return np.asarray(np.einsum("qpsi,psie->qpse", rates.q_y, moves) + rates.q_e)


def _shifts(
    design: Design, flank: str, l: FloatArray, u: FloatArray, by: FloatArray, along: FloatArray
) -> FloatArray:
    """Return the shift of the path along each member's flank, perpendicular to the path (2, cases, positions,
    errors), from the derivatives `by` of l and u (2, 2, cases, positions, errors) and the direction of the
    path in l and u."""
    patch = flank_patch(design.stacked_members(), flank, l, u)
    tangents = np.stack((patch.tangent_l, patch.tangent_u))
    path = np.einsum("kjcpi,kjcp->jcpi", tangents, along)
    side = np.cross(patch.normal, path)
    side *= (np.sign(side[..., 2]) / np.linalg.norm(side, axis=-1))[..., None]
    return np.asarray(np.einsum("jcpi,kjcpi,kjcpe->jcpe", side, tangents, by))


def _result(
    design: Design,
    flank: str,
    pairing: FlankPair,
    table: FloatArray,
    scalars: FloatArray,
    limit: Codes,
    status: Codes,
) -> Sensitivity:
    """Return the rows of all cases in the batch shape, with the derived quantities."""
    # A path whose l changes by less than this share of its change of z runs along the face.
    constant_l = 1e-9
    shape, count = design.batch_shape, len(ERROR_NAMES)
    # Rows of both members.
    l, u, z, r = (slice(k, k + 2) for k in range(0, 8, 2))
    rows = table.reshape(_MARGINS, count + 2, *table.shape[1:])
    value, by, along = rows[:, 0], np.moveaxis(rows[:, 1:-1], 1, -1), rows[:, -1]
    face = by[z] - (along[z] / along[l])[..., None] * by[l]
    # A path that runs along the face has no shift along the face.
    face = np.where((np.abs(along[l]) > constant_l * np.abs(along[z]))[..., None], face, np.nan)
    square = _shifts(
        design, flank, value[l], value[u], np.stack((by[l], by[u])), np.stack((along[l], along[u]))
    )
    per_pitch = pairing.teeth[0, :, 0, None] / (2.0 * np.pi)
    ratio, swing = scalars[0] * per_pitch, scalars[1]
    # Unmodified flanks have no transmission error.
    unmodified = pairing.without_parabola & (status == Status.SOLVED) & (not is_modified(design, flank))
    swing = np.where(unmodified[:, None] & ~np.isnan(scalars[1]), 0.0, swing)

    def batch(values: FloatArray) -> FloatArray:
        """Return (2, cases, positions, ...) in the axes of the result."""
        return np.moveaxis(values, 0, 2).reshape(*shape, len(PLACES), 2, *values.shape[3:])

    return Sensitivity(
        flank=flank,
        errors=ERROR_NAMES,
        l=batch(value[l]),
        z=batch(value[z]),
        r=batch(value[r]),
        pinion_roll=value[_ROLL].reshape(*shape, len(PLACES)),
        l_by=batch(by[l]),
        z_by=batch(by[z]),
        r_by=batch(by[r]),
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
