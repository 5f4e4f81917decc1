"""Structured quadrilaterals over the transverse section of one tooth and its part of the body.

The outline from the middle of one tooth space to that of the next is one smooth curve but for
the two edges of the tip. The lattice has the shape of a T upside down: rows of the tooth run
from the left to the right flank, columns of the tooth from the tip through the body to the
bore, and beside them columns of the body from the bottom lands and the lower halves of the
fillets. The two inner corners of the T stand in the middle of the fillets, where three cells
meet and 180 deg of metal leave about 60 deg for each. All nodes inside have four cells.

Nodes inside solve Winslow's equations

    |x_eta|^2 x_xixi - 2 x_xi . x_eta x_xieta + |x_xi|^2 x_etaeta = 0

on lattice coordinates whose steps follow those of the outline, and near an inner corner the
power 3/2 of the distance from it: a conformal map opens the T's 270 deg there to 180 deg. The
coefficients are iterated at toe, middle and heel. The linear equations so found serve the
outlines at all stations, which differ little but for a turn, and their three solutions are
blended: the nodes move as smoothly along the face as the outline does.

Winslow: Thompson, Warsi and Mastin, Numerical Grid Generation (1985), chapter VI.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, Indices

Plane: TypeAlias = NDArray[np.complex128]
"""Points of transverse planes as x + i y, mm."""

OUTLINE = ("left bottom", "left fillet", "left flank", "tip", "right flank", "right fillet", "right bottom")
"""Curves around one tooth, against the clock seen from +z."""
SIDES = ("first side", "last side")
"""Where the tooth is cut from its neighbours, in the middle of the tooth spaces."""
ITERATIONS = 100
MOST_PITCH = 1.001 * np.pi
"""rad. A single tooth's section lies all round the axis, and the lattice would meet itself."""
SETTLED = 5e-4
"""Pitches by which nodes may still move."""


@dataclass(frozen=True, eq=False)
class Section:
    """Quadrilaterals in transverse planes: `points` (n, nz, 3), mm, own frame; `quads` (m, 4),
    against the clock seen from +z; `boundary`: for each curve the indices of its points in
    order. The curves are those of the outline and 'bore', 'first side' and 'last side', the
    sides from the outline down to the bore, the bore from the first side to the last."""

    points: FloatArray
    quads: Indices
    boundary: dict[str, Indices]


@dataclass(frozen=True, eq=False)
class _Lattice:
    """Node numbers `index` (rows, columns), bore first, -1 beside the tooth; `body` rows of
    cells; columns `left` and `right` of the tooth's sides; radial stations `shares` of the body's
    rows, 0 at the bottom land, 1 at the `bore` (radius, mm)."""

    index: Indices
    body: int
    left: int
    right: int
    shares: FloatArray
    bore: float


def section_of(
    outline: dict[str, FloatArray], bore_radius: float, aspect: float = 8.0, growth: float = 1.3
) -> Section:
    """Make quadrilaterals between an outline and the bore.

    `outline`: points (k, nz, 3), mm, of the curves of `OUTLINE` from the middle of one tooth space
    to that of the next; all have the same stations, neighbours share their ends, left and right
    have equal numbers, fillets three points or more, a bottom land without width one. They
    become nodes as they are, in the planes of the tip's; of an end given twice the later curve's.
    Rows of the body are about `aspect` times as high as wide at most, and each is at most
    `growth` times as high as the next one outside. The tooth has as many columns as the tip cells.

    Raises ValueError for curves that do not fit, for a bore that is too large, for the outline of a
    single tooth and for one that cannot be filled (an undercut tooth's crosses itself)."""
    flat = _flat(outline)
    half = _corner(flat)
    lattice = _lattice_of(flat, half, bore_radius, (aspect, growth))
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


def section_size(
    outline: dict[str, FloatArray], bore_radius: float, aspect: float = 8.0, growth: float = 1.3
) -> tuple[int, int]:
    """Count the points and of quadrilaterals that `section_of` would give; raises what it does, but
    for an outline that cannot be filled."""
    flat = _flat(outline)
    lattice = _lattice_of(flat, _corner(flat), bore_radius, (aspect, growth))
    return int(lattice.index.max()) + 1, len(_quads(lattice))


def _flat(outline: dict[str, FloatArray]) -> dict[str, Plane]:
    """Give the curves as points of transverse planes, in order, checked."""
    flat = {name: np.asarray(outline[name][..., 0] + 1.0j * outline[name][..., 1]) for name in OUTLINE}
    for name, partner in zip(OUTLINE[:3], OUTLINE[:3:-1], strict=True):
        if flat[name].shape != flat[partner].shape:
            shapes = f"{len(flat[name])} and {len(flat[partner])}"
            raise ValueError(f"'{name}' and '{partner}' must have equal numbers of points, got {shapes}")
    if len(flat["left fillet"]) < 3:
        raise ValueError("a fillet needs two cells at least, the lattice has its corners there")
    size = float(np.abs(flat["left flank"]).max())
    for name, other in pairwise(OUTLINE):
        gap = float(np.abs(flat[name][-1] - flat[other][0]).max())
        if not gap < 1e-6 * size:
            raise ValueError(f"'{name}' must end where '{other}' starts, got a gap of {gap:.3g} mm")
    return flat


def _quads(lattice: _Lattice) -> Indices:
    """Find the node numbers (m, 4) of the lattice's cells, against the clock."""
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
        cure = "is the tooth undercut, or next to without a fillet? take a larger tip radius"
        raise ValueError(f"the section at z = {at:.4g} mm cannot be filled with cells: {cure}")


def _lengths(curve: Plane) -> FloatArray:
    """Find the length (mm) along points (k,) from the first."""
    return np.concatenate(([0.0], np.cumsum(np.abs(np.diff(curve)))))


def _corner(flat: dict[str, Plane]) -> int:
    """Cells of the fillet from the bottom land to the lattice's corner, near its middle."""
    left, right = (
        _lengths(curve[:, curve.shape[1] // 2]) for curve in (flat["left fillet"], flat["right fillet"][::-1])
    )
    lengths = left + right
    nearest = int(np.argmin(np.abs(lengths - 0.5 * lengths[-1])))
    return min(max(nearest, 1), len(lengths) - 2)


def _shares(root: float, bore: float, first: float, across: float, limits: tuple[float, float]) -> FloatArray:
    """Find stations 0 ... 1 from root radius to bore, three or more. The `first` row (mm) is given,
    others grow, but not beyond the aspect of cells `across` (rad) wide."""
    (aspect, growth), radii, height = limits, [root], min(first, 0.5 * (root - bore))
    while radii[-1] > bore:
        height = min(height, aspect * across * max(radii[-1], bore))
        radii.append(radii[-1] - height)
        height *= growth
    depths = root - np.array(radii)
    return np.asarray(depths / depths[-1])


def _swept(flat: dict[str, Plane]) -> FloatArray:
    """Find angles (rad) about the axis from the outline's first to its last point, by station: one pitch.
    They are added up, as a pitch may be half a turn or a whole one."""
    outline = np.concatenate([flat[name] for name in OUTLINE])
    return np.asarray(np.angle(outline[1:] * outline[:-1].conj()).sum(axis=0))


def _stretched(lengths: FloatArray, scale: float) -> FloatArray:
    """Find the lattice coordinate at lengths from an inner corner: their power 3/2, linear beyond `scale`."""
    return np.asarray(lengths * np.sqrt(lengths / (lengths + scale)))


def _lattice_of(flat: dict[str, Plane], half: int, bore: float, limits: tuple[float, float]) -> _Lattice:
    """Give the lattice's shape; the rows of the body suit the outline at the middle station."""
    first = flat["left bottom"][0]
    root = float(np.abs(first).min())
    if not 0.0 < bore < root:
        raise ValueError(f"bore_radius must be between 0 and the root radius {root:.6g} mm, got {bore:g}")
    at, pitch = len(first) // 2, _swept(flat)
    if not (pitch.min() > 0.0 and pitch.max() < MOST_PITCH):
        turn = f"from {np.degrees(pitch.min()):.4g} to {np.degrees(pitch.max()):.4g} deg"
        raise ValueError(f"an outline must go round the axis by 180 deg at most, got {turn}: one tooth only?")
    wing, tall = (
        len(flat["left bottom"]) - 1 + half,
        len(flat["left flank"]) + len(flat["left fillet"]) - 2 - half,
    )
    left, right = wing, wing + len(flat["tip"]) - 1
    width = 0.5 * sum(_profile(flat, side, half, at)[0][-1] for side in ("left", "right")) / wing
    across = float(pitch[at]) / (right + wing)
    shares = _shares(root, bore, width, across, limits)
    body = len(shares) - 1
    mask = np.zeros((body + tall + 1, right + wing + 1), dtype=bool)
    mask[: body + 1], mask[:, left : right + 1] = True, True
    return _Lattice(
        np.where(mask, np.cumsum(mask).reshape(mask.shape) - 1, -1), body, left, right, shares, bore
    )


def _profile(flat: dict[str, Plane], side: str, half: int, at: int) -> tuple[FloatArray, FloatArray]:
    """Find lengths (mm) of the outline at one station from an inner corner, down and up."""
    step = 1 if side == "left" else -1
    bottom, fillet, flank = (flat[f"{side} {part}"][::step, at] for part in ("bottom", "fillet", "flank"))
    below = np.concatenate((bottom, fillet[1 : half + 1]))[::-1]
    return _lengths(below), _lengths(np.concatenate((fillet[half:], flank[1:])))


def _coordinates(
    flat: dict[str, Plane], half: int, at: int, lattice: _Lattice, pitch: float
) -> tuple[FloatArray, FloatArray]:
    """Find the lattice coordinates xi and eta (rows, columns) that suit the outline at one station."""
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
    """Find the node numbers of the boundary's curves, in order."""
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
    """Give the inner nodes with their neighbours (9, n), row by row, and weights (5, 9, n): first
    derivatives by xi and eta, second ones by xi, by both, by eta."""
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
    """Place the nodes inside and on the bore, where columns end at right angles.

    The solutions with the coefficients of toe, middle and heel are blended by a parabola."""
    references, pitch = np.unique((0, len(z) // 2, len(z) - 1)), _swept(flat)
    found = []
    for at in references:
        xi, eta = _coordinates(flat, half, at, lattice, float(pitch[at]))
        nodes, weights = _operators(lattice, (xi, eta))
        found.append(_winslow(x[:, at].copy(), xi[0], lattice, (nodes, weights), float(pitch[at])))
    blend = np.ones((len(references), len(z)))
    for k, at in enumerate(references):
        for other in references[references != at]:
            blend[k] *= (z - z[other]) / (z[at] - z[other])
    ends = lattice.index[0]
    shares = sum(part * line[:, None] for (_, line), part in zip(found, blend, strict=True))
    x[ends] = x[ends[0]] * np.exp(1.0j * shares * pitch)
    x[nodes[4]] = sum(
        part * _solved(x, nodes, values) for (values, _), part in zip(found, blend, strict=True)
    )


def _solved(x: Plane, nodes: Indices, values: FloatArray) -> Plane:
    """Find the inner nodes (n, k) to the given ones of `x` (all, k), for equations (9, n)."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    inside = nodes[4]
    row = np.tile(np.arange(len(inside)), 9)
    matrix = csr_array((values.ravel(), (row, nodes.ravel())), shape=(len(inside), len(x)))
    fixed = np.setdiff1d(np.arange(len(x)), inside)
    known = np.ascontiguousarray(matrix[:, fixed] @ x[fixed])
    solution = splu(matrix[:, inside].tocsc(), permc_spec="MMD_AT_PLUS_A").solve(-known.view(float))
    return np.ascontiguousarray(solution).view(complex)


def _winslow(
    x: Plane,
    spacing: FloatArray,
    lattice: _Lattice,
    operators: tuple[Indices, FloatArray],
    pitch: float,
) -> tuple[FloatArray, FloatArray]:
    """Give the equations (9, n) of the inner nodes at one station, and the shares of the pitch at
    which columns reach the bore."""
    nodes, weights = operators
    ends, above = lattice.index[:2]
    shares = (spacing - spacing[0]) / (spacing[-1] - spacing[0])
    values = weights[2] + weights[4]
    for _ in range(ITERATIONS):
        x[ends] = x[ends[0]] * np.exp(1.0j * shares * pitch)
        before, x[nodes[4]] = x[nodes[4]], _solved(x[:, None], nodes, values)[:, 0]
        shares = np.append(np.unwrap(np.angle(x[above[:-1]] / x[ends[0]])) / pitch, 1.0)
        shares[0] = 0.0
        if np.abs(x[nodes[4]] - before).max() < SETTLED * abs(pitch * x[ends[0]]):
            break
        xi, eta = (np.einsum("jn,jn->n", part, x[nodes]) for part in weights[:2])
        squares = np.abs(xi) ** 2, np.abs(eta) ** 2
        mixed = -2.0 * (xi * eta.conj()).real
        values = (squares[1] * weights[2] + mixed * weights[3] + squares[0] * weights[4]) / sum(squares)
    return values, shares
