"""Structured quadrilaterals in the transverse section of one tooth and its part of the body.

The outline from the middle of one tooth space to that of the next is a smooth curve except for the two edges
of the tip and of undercut. The lattice has the shape of a T upside down. Rows of the tooth run from the left
to the right flank. Columns of the tooth run from the tip through the body to the bore. Next to them are
columns of the body from the bottom lands and the lower halves of the fillets. The two inner corners of the
T are in the middle of the fillets, where three cells meet, each with about 60 deg of the 180 deg of metal.
All inner nodes have four cells.

1. Lattice coordinates (xi, eta) are chosen whose steps are those of the outline. Near an inner corner they
   are the power 3/2 of the distance from it, because a conformal map opens the 270 deg of the T to 180 deg.
2. Inner nodes solve the equations of Winslow

       |x_eta|^2 x_xixi - 2 x_xi . x_eta x_xieta + |x_xi|^2 x_etaeta = 0

   (Thompson, Warsi and Mastin, Numerical Grid Generation (1985), chapter VI). Their coefficients are iterated
   at toe, middle and heel.
3. The linear equations with each of these coefficients are solved for the outlines of all stations, which
   hardly differ except for a rotation. The three solutions are blended by a parabola, so that nodes move as
   smoothly along the face as the outline.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Indices

Plane: TypeAlias = NDArray[np.complex128]
"""Points in transverse planes as x + i y, mm."""

OUTLINE = ("left bottom", "left fillet", "left flank", "tip", "right flank", "right fillet", "right bottom")
"""Curves around one tooth, counter-clockwise seen from +z."""
GROWTH_RATIO = 1.4
"""Largest ratio of the heights of successive rows of the body from the root to the bore, and ratio of
successive steps along a flank from the fillet on (`element_sizes`)."""
SIDES = ("first side", "last side")
"""Cuts between the tooth and its neighbours, in the middle of the tooth spaces."""


@dataclass(frozen=True, eq=False)
class Section:
    """Quadrilaterals in transverse planes, in the frame of the gear.

    Attributes
    ----------
    points : array (n, nz, 3)
        mm.
    quads : array (m, 4)
        Indices of points, counter-clockwise seen from +z.
    boundary : dict
        Indices of the points of each curve, in order: the curves of OUTLINE, 'bore' from the first to the
        last side, and 'first side' and 'last side' from the outline to the bore.
    """

    points: FloatArray
    quads: Indices
    boundary: dict[str, Indices]


@dataclass(frozen=True, eq=False)
class _Lattice:
    """Lattice of a section: node numbers `index` (rows, columns) from the bore on, -1 next to the tooth;
    number `body` of rows of cells in the body; columns `left` and `right` of the flanks; radial stations
    `shares` of the rows of the body, 0 at the bottom land and 1 at the `bore` (radius, mm)."""

    index: Indices
    body: int
    left: int
    right: int
    shares: FloatArray
    bore: float


def section_of(outline: dict[str, FloatArray], bore_radius: float) -> Section:
    """Return quadrilaterals between an outline and the bore.

    Parameters
    ----------
    outline : dict of arrays (k, nz, 3)
        Points of the curves of OUTLINE, mm, which become nodes. Curves have the same stations and share their
        ends with their neighbours. Left and right curves have equal numbers of points. Fillets have three or
        more, and bottom lands without width have one. The columns of the tooth are those of the tip.
    bore_radius : float
        mm, between 0 and the smallest root radius (`bore_of`).

    Returns
    -------
    Section

    Raises
    ------
    ValueError
        For curves that do not match, an outline that surrounds the axis, and an outline that cannot be
        filled, for example because it intersects itself.
    """
    flat = _flat(outline)
    half = _corner(flat)
    lattice = _lattice_of(flat, half, bore_radius)
    boundary = _boundary(lattice, flat, half)
    x = np.zeros((int(lattice.index.max()) + 1, flat["tip"].shape[1]), dtype=complex)
    for name, curve in flat.items():
        x[boundary[name]] = curve
    for name in SIDES:
        start = x[boundary[name][0]]
        x[boundary[name]] = start * (1.0 - lattice.shares[:, None] * (1.0 - bore_radius / np.abs(start)))
    _fill(x, outline["tip"][0, :, 2], flat, half, lattice)
    points = np.stack((x.real, x.imag, np.broadcast_to(outline["tip"][0, :, 2], x.shape)), axis=-1)
    quads = _quads(lattice)
    _refuse_folds(x, points[0, :, 2], quads)
    return Section(points, quads, boundary)


def section_size(outline: dict[str, FloatArray], bore_radius: float) -> tuple[int, int]:
    """Return the numbers of points and of quadrilaterals of `section_of` without computing the section.
    Parameters and errors are the same, but the outline is not filled."""
    flat = _flat(outline)
    lattice = _lattice_of(flat, _corner(flat), bore_radius)
    return int(lattice.index.max()) + 1, len(_quads(lattice))


def _flat(outline: dict[str, FloatArray]) -> dict[str, Plane]:
    """Return the curves as points in transverse planes, in order. Raises ValueError if they do not match."""
    flat = {name: np.asarray(outline[name][..., 0] + 1.0j * outline[name][..., 1]) for name in OUTLINE}
    if len(flat["left fillet"]) < 3:
        cells = len(flat["left fillet"]) - 1
        raise ValueError(f"a fillet must have at least 2 cells, got {cells}")
    size = float(np.abs(flat["left flank"]).max())
    for name, other in pairwise(OUTLINE):
        gap = float(np.abs(flat[name][-1] - flat[other][0]).max())
        if not gap < 1e-6 * size:
            raise ValueError(f"'{name}' must end where '{other}' starts, got a gap of {gap:.3g} mm")
    return flat


def _quads(lattice: _Lattice) -> Indices:
    """Return the node numbers (m, 4) of the cells of the lattice, counter-clockwise."""
    index = lattice.index
    quads = np.stack((index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]), axis=-1)
    return np.asarray(quads[(quads >= 0).all(axis=-1)])


def _refuse_folds(x: Plane, z: FloatArray, quads: Indices) -> None:
    """Raise ValueError unless all quadrilaterals are convex."""
    corners = [x[quads[:, k]] for k in range(4)]
    bent = np.stack(
        [((corners[k - 1] - corners[k]).conj() * (corners[(k + 1) % 4] - corners[k])).imag for k in range(4)]
    )
    if not bent.max() < 0.0:
        at = z[int(np.argmax(bent.max(axis=(0, 1))))]
        cure = "increase the tip_radius of the tool, or check the tooth for undercut"
        raise ValueError(f"the section at z = {at:.4g} mm cannot be filled with cells: {cure}")


def _lengths(curve: Plane) -> FloatArray:
    """Return the lengths (mm) along points (k,) from the first one."""
    return np.concatenate(([0.0], np.cumsum(np.abs(np.diff(curve)))))


def _corner(flat: dict[str, Plane]) -> int:
    """Return the number of cells of a fillet from the bottom land to the corner of the lattice, near its
    middle."""
    left, right = (
        _lengths(curve[:, curve.shape[1] // 2]) for curve in (flat["left fillet"], flat["right fillet"][::-1])
    )
    lengths = left + right
    nearest = int(np.argmin(np.abs(lengths - 0.5 * lengths[-1])))
    return min(max(nearest, 1), len(lengths) - 2)


def _shares(root: float, bore: float, first: float, across: float) -> FloatArray:
    """Return three or more stations 0 ... 1 from the root radius to the bore. Heights of rows grow from the
    `first` one (mm) up to the limit of the aspect ratio of cells that are `across` (rad) wide."""
    # Largest ratio of height and width of the rows, approximately.
    max_aspect = 8.0
    radii, height = [root], min(first, 0.5 * (root - bore))
    while radii[-1] > bore:
        height = min(height, max_aspect * across * max(radii[-1], bore))
        radii.append(radii[-1] - height)
        height *= GROWTH_RATIO
    depths = root - np.array(radii)
    return np.asarray(depths / depths[-1])


def _swept(flat: dict[str, Plane]) -> FloatArray:
    """Return the angle (rad) about the axis from the first to the last point of the outline at each station,
    one pitch. The angles of all steps are added, because a pitch may be half a turn."""
    outline = np.concatenate([flat[name] for name in OUTLINE])
    return np.asarray(np.angle(outline[1:] * outline[:-1].conj()).sum(axis=0))


def _stretched(lengths: FloatArray, scale: float) -> FloatArray:
    """Return lattice coordinates at lengths from an inner corner: their power 3/2, linear beyond `scale`."""
    return np.asarray(lengths * np.sqrt(lengths / (lengths + scale)))


def _lattice_of(flat: dict[str, Plane], half: int, bore: float) -> _Lattice:
    """Return the lattice. The rows of the body follow from the outline at the middle station."""
    # Largest angle of the section about the axis, rad: that of a gear with two teeth.
    max_pitch = 1.001 * np.pi
    first = flat["left bottom"][0]
    root = float(np.abs(first).min())
    at, pitch = len(first) // 2, _swept(flat)
    if not (pitch.min() > 0.0 and pitch.max() < max_pitch):
        turn = f"from {np.degrees(pitch.min()):.4g} to {np.degrees(pitch.max()):.4g} deg"
        limit = "be that of one tooth and span at most 180 deg about the axis"
        raise ValueError(f"an outline must {limit}, got {turn}")
    wing, tall = (
        len(flat["left bottom"]) - 1 + half,
        len(flat["left flank"]) + len(flat["left fillet"]) - 2 - half,
    )
    left, right = wing, wing + len(flat["tip"]) - 1
    width = 0.5 * sum(_profile(flat, side, half, at)[0][-1] for side in ("left", "right")) / wing
    across = float(pitch[at]) / (right + wing)
    shares = _shares(root, bore, width, across)
    body = len(shares) - 1
    mask = np.zeros((body + tall + 1, right + wing + 1), dtype=bool)
    mask[: body + 1], mask[:, left : right + 1] = True, True
    return _Lattice(
        np.where(mask, np.cumsum(mask).reshape(mask.shape) - 1, -1), body, left, right, shares, bore
    )


def _profile(flat: dict[str, Plane], side: str, half: int, at: int) -> tuple[FloatArray, FloatArray]:
    """Return lengths (mm) along the outline at one station, from an inner corner downwards and upwards."""
    step = 1 if side == "left" else -1
    bottom, fillet, flank = (flat[f"{side} {part}"][::step, at] for part in ("bottom", "fillet", "flank"))
    below = np.concatenate((bottom, fillet[1 : half + 1]))[::-1]
    return _lengths(below), _lengths(np.concatenate((fillet[half:], flank[1:])))


def _coordinates(
    flat: dict[str, Plane], half: int, at: int, lattice: _Lattice, pitch: float
) -> tuple[FloatArray, FloatArray]:
    """Return lattice coordinates xi and eta (rows, columns) for the outline at one station."""
    wings, walls = [], []
    for side in ("left", "right"):
        below, above = _profile(flat, side, half, at)
        scale = 0.25 * below[half]
        wings.append(_stretched(below, scale))
        walls.append(_stretched(above, scale)[1:])
    rim = float(np.abs(flat["left fillet"][half, at] - flat["right fillet"][-1 - half, at]))
    tip = _lengths(flat["tip"][:, at])
    top = np.concatenate((-wings[0][::-1], rim * tip[1:-1] / tip[-1], rim + wings[1]))
    start = np.abs(flat["left bottom"][0, at])
    bore = lattice.bore
    depths = -lattice.shares[::-1] * (start - bore)
    reach = start * np.sin(0.5 * min(pitch, np.pi))
    # The columns are those of the outline at the root, and become even towards the bore.
    blend = np.concatenate((np.exp(depths / reach), np.ones(len(walls[0]))))[:, None]
    xi = blend * top + (1.0 - blend) * np.linspace(top[0], top[-1], len(top))
    across = np.clip(top / rim, 0.0, 1.0)
    eta = np.concatenate(
        (
            np.repeat(depths[:, None], len(top), axis=1),
            walls[0][:, None] * (1.0 - across) + walls[1][:, None] * across,
        )
    )
    return xi, eta


def _boundary(lattice: _Lattice, flat: dict[str, Plane], half: int) -> dict[str, Indices]:
    """Return the node numbers of the curves of the boundary, in order."""
    index, body, left, right = lattice.index, lattice.body, lattice.left, lattice.right
    profiles = {
        "left": np.concatenate((index[body, : left + 1], index[body + 1 :, left])),
        "right": np.concatenate((index[:body:-1, right], index[body, right:])),
    }
    curves = {"tip": index[-1, left : right + 1], "bore": index[0]}
    curves |= {"first side": index[body::-1, 0], "last side": index[body::-1, -1]}
    for side, profile in profiles.items():
        start = 0
        for name in (name for name in flat if name.startswith(side)):
            end = start + len(flat[name])
            curves[name] = profile[start:end]
            start = end - 1
    return curves


def _operators(lattice: _Lattice, coordinates: tuple[FloatArray, FloatArray]) -> tuple[Indices, FloatArray]:
    """Return the inner nodes with their neighbours (9, n), row by row, and finite difference weights (5, 9,
    n): first derivatives by xi and eta, and second derivatives by xi, by both, and by eta."""
    window = np.lib.stride_tricks.sliding_window_view(lattice.index, (3, 3))
    rows, columns = np.nonzero((window >= 0).all(axis=(2, 3)))
    nodes = window[rows, columns].reshape(-1, 9).T
    first, second = np.zeros((2, 3, len(rows))), np.zeros((2, 3, len(rows)))
    for axis, (values, step) in enumerate(zip(coordinates, ((0, 1), (1, 0)), strict=True)):
        here = values[rows + 1, columns + 1]
        back = here - values[rows + 1 - step[0], columns + 1 - step[1]]
        ahead = values[rows + 1 + step[0], columns + 1 + step[1]] - here
        both = back + ahead
        first[axis] = -ahead / (back * both), (ahead - back) / (back * ahead), back / (ahead * both)
        second[axis] = 2.0 / (back * both), -2.0 / (back * ahead), 2.0 / (ahead * both)
    weights = np.zeros((5, 3, 3, len(rows)))
    weights[0, 1], weights[1, :, 1] = first
    weights[2, 1], weights[4, :, 1] = second
    weights[3] = first[1][:, None] * first[0]
    return nodes, weights.reshape(5, 9, -1)


def _fill(x: Plane, z: FloatArray, flat: dict[str, Plane], half: int, lattice: _Lattice) -> None:
    """Compute the inner nodes and those on the bore in place. Columns are perpendicular to the bore.

    The solutions with the coefficients of toe, middle and heel are blended by a parabola (step 3)."""
    references, pitch = np.unique((0, len(z) // 2, len(z) - 1)), _swept(flat)
    solutions = []
    for at in references:
        xi, eta = _coordinates(flat, half, at, lattice, float(pitch[at]))
        nodes, weights = _operators(lattice, (xi, eta))
        solutions.append(_winslow(x[:, at].copy(), xi[0], lattice, (nodes, weights), float(pitch[at])))
    blend = np.ones((len(references), len(z)))
    for k, at in enumerate(references):
        for other in references[references != at]:
            blend[k] *= (z - z[other]) / (z[at] - z[other])
    ends = lattice.index[0]
    shares = sum(part * line[:, None] for (_, line), part in zip(solutions, blend, strict=True))
    x[ends] = x[ends[0]] * np.exp(1.0j * shares * pitch)
    x[nodes[4]] = sum(
        part * _solved(x, nodes, values) for (values, _), part in zip(solutions, blend, strict=True)
    )


def _solved(x: Plane, nodes: Indices, values: FloatArray) -> Plane:
    """Return the inner nodes (n, k) that solve equations (9, n) with the boundary nodes of `x` (all, k)."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    inside = nodes[4]
    row = np.tile(np.arange(len(inside)), 9)
    matrix = csr_array((values.ravel(), (row, nodes.ravel())), shape=(len(inside), len(x)))
    fixed = np.setdiff1d(np.arange(len(x)), inside)
    constant = np.ascontiguousarray(matrix[:, fixed] @ x[fixed])
    solution = splu(matrix[:, inside].tocsc(), permc_spec="MMD_AT_PLUS_A").solve(-constant.view(float))
    return np.ascontiguousarray(solution).view(complex)


def _winslow(
    x: Plane,
    spacing: FloatArray,
    lattice: _Lattice,
    operators: tuple[Indices, FloatArray],
    pitch: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the equations (9, n) of the inner nodes at one station (step 2), and the angles at which columns
    reach the bore, as fractions of the pitch."""
    # Largest movement of nodes in the last iteration.
    max_move_pitches = 5e-4
    nodes, weights = operators
    ends, above = lattice.index[:2]
    shares = (spacing - spacing[0]) / (spacing[-1] - spacing[0])
    # Start from the equation of Laplace.
    values = weights[2] + weights[4]
    max_iterations = 100
    for _ in range(max_iterations):
        x[ends] = x[ends[0]] * np.exp(1.0j * shares * pitch)
        before, x[nodes[4]] = x[nodes[4]], _solved(x[:, None], nodes, values)[:, 0]
        shares = np.append(np.unwrap(np.angle(x[above[:-1]] / x[ends[0]])) / pitch, 1.0)
        shares[0] = 0.0
        if np.abs(x[nodes[4]] - before).max() < max_move_pitches * abs(pitch * x[ends[0]]):
            break
        # Coefficients of the equations of Winslow from the present nodes.
        xi, eta = (np.einsum("jn,jn->n", part, x[nodes]) for part in weights[:2])
        squares = np.abs(xi) ** 2, np.abs(eta) ** 2
        mixed = -2.0 * (xi * eta.conj()).real
        values = (squares[1] * weights[2] + mixed * weights[3] + squares[0] * weights[4]) / sum(squares)
    return values, shares
