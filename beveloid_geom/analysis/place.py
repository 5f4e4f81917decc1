"""The inverse of a pattern under errors: which two errors put the path of contact where it is wanted.

The middle of a path is its place at mid-roll (`sensitivity`), half-way in roll between where it enters and
leaves the flanks. Wanted is its z on the pinion, a share of the face from the toe, and its l1: centred in
profile. A path that runs from tip to tip of the members is centred by itself, so that under errors it is to
keep the l1 that its middle has without them; where a face ends the path as designed, l1 = 0 is wanted, the
middle of the tool's flank. With e the two errors,

    F(e) = (z(e) - z_wanted, l1(e) - l1_wanted) = 0

is solved by Newton's method from the design on, with exact derivatives of the middle (`sensitivity`), its
steps halved while they do not come nearer. What it does not reach is looked for on a grid over all errors
within `limits_of`, and by Newton from there; then the nearest by sequential quadratic programming, that at
the least root of the sum of the squares of both differences, as shares of face and of profile.

Where the errors found use up the backlash the pair cannot be assembled. Then the middle stays at its share of
the face and leaves the centre of the profile, no further than until the backlash is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.path import path_of_contact
from ..design.model import Design, Errors
from ..gear.flank import highest_parameter, root_parameter
from ..operation.backlash import mounted_backlash
from ..operation.mesh_cycle import mesh_cycle
from ..pair.errors import ANGLES, NAMES, mounted, place_of
from ..status import Limit, PlaceStatus, Status
from ..support.few_lines import few_lines
from .pattern_matrix import check_names
from .sensitivity import path_sensitivity

ON_PARALLEL = (
    "on parallel axes a path runs along the whole face, with parabolas too, so that it has no middle to place"
    ": give the pair a shaft angle (`beveloid-geom propose`), or see what errors do with"
    " `beveloid-geom pattern --over offset,shaft-angle`"
)

AT = (0.25, 0.5, 0.75)
"""Shares of the face at which the middle is wanted where none are given."""
CLOSE = 1e-6
"""mm within which a place is reached."""
STEPS, HALVINGS = 40, 8
LONGEST = 0.1
"""Newton steps at most; how often one is halved; the longest, as a share of the limits."""
LEAST_SHARE, GRID, STARTS, POLISHED = 1e-5, 60, 12, 3
"""Least share of the limits at which the search looks; even sizes of an error at which it does; mountings of
each kind from which it goes on; those of all from which it looks for the nearest."""
ALIKE = 9
"""Digits of shares of the limits that tell mountings apart."""
FLAT = 1e-3
"""Share of its greatest rate that a middle moves at least where the search counts it as moving."""
BESIDE, NARROW = 0.25 * (np.arange(1, 7) / 6.0) ** 2, 1e-4
"""Shares of the profile by which the middle leaves its centre in search of backlash; mm to which the least is
found."""
LOST = 1e6
"""Shares of the flank, of what has no path."""
WIDEST_ANGLE = float(np.radians(5.0))


@dataclass(frozen=True, eq=False)
class Placement:
    """Mountings that put the middle of a design's path on `flank` at shares `at` (n) of the pinion's face.

    `by`: names of the two errors; `limits` (2), mm or rad, to either side, within which they were looked for.
    `wanted_z` (n), `wanted_l`: where on the pinion, mm. `errors` (n, 2), mm or rad, to be added to the
    design's own; what follows is of the mounting with them, from a path solved anew: `z`, `l` (n) of its
    middle, mm; `distance` (n) from where it is wanted, share of the flank; `contact_ratio` (n), Eq. 16;
    `normal_backlash` (n), mm, as mounted; `cycle_peak_to_peak` (n), rad, and `edge_share` (n) in operation.
    `status` (n), codes of `PlaceStatus`: OUT_OF_REACH, all this is of the nearest; OFF_CENTRE, of the one
    nearest in profile that can be assembled. `jammed` (n): whether it cannot. `exact` (n, 2): errors that put
    the middle there whether or not the pair can be assembled, NaN if none do."""

    __repr__ = few_lines

    design: Design
    flank: str
    by: tuple[str, str]
    limits: FloatArray
    at: FloatArray
    wanted_z: FloatArray
    wanted_l: float
    errors: FloatArray
    z: FloatArray
    l: FloatArray
    distance: FloatArray
    contact_ratio: FloatArray
    normal_backlash: FloatArray
    cycle_peak_to_peak: FloatArray
    edge_share: FloatArray
    status: Codes
    jammed: Mask
    exact: FloatArray


@dataclass(frozen=True, eq=False)
class _Search:
    """What is varied: two errors of a design, in shares (..., 2) of their `limits`; places are (z, l1), mm,
    of the middle of its path, and distances shares of the pinion's flank of the size `unit` (2), mm."""

    design: Design
    flank: str
    by: tuple[str, str]
    limits: FloatArray
    unit: FloatArray

    def under(self, shares: FloatArray) -> Design:
        """Give the mountings (...) under errors (..., 2)."""
        return mounted(self.design, shares * self.limits, self.by)

    def places(self, shares: FloatArray) -> FloatArray:
        """Find the middles (n, 2) of paths solved under errors (n, 2); NaN without a path."""
        path = path_of_contact(self.under(shares), self.flank, 3)
        found = np.stack((path.pinion_z[:, 1], path.l1[:, 1]), axis=-1)
        return np.where((path.ends.status == Status.SOLVED)[:, None], found, np.nan)

    def rates(self, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Find middles (n, 2) and their derivatives (n, 2, 2) by the shares."""
        at = place_of(self.by)
        found = path_sensitivity(self.under(shares), self.flank, at)
        columns = [NAMES[at].index(name) for name in self.by]
        by = np.stack((found.z_by[:, 1, 0], found.l_by[:, 1, 0]), axis=1)[..., columns]
        return np.stack((found.z[:, 1, 0], found.l[:, 1, 0]), axis=-1), by * self.limits

    def apart(self, places: FloatArray, wanted: FloatArray) -> FloatArray:
        """Give distances (...), infinite without a place."""
        far = np.linalg.norm((places - wanted) / self.unit, axis=-1)
        return np.where(np.isnan(far), np.inf, far)


def place_path(
    design: Design,
    at: Sequence[float] = AT,
    by: tuple[str, str] = ("offset", "shaft_angle"),
    flank: str = "right",
    l: float | None = None,
) -> Placement:
    """Find two errors under which the path's middle is at shares `at` of the face, centred in profile.

    Parameters
    ----------
    design : Design
        A single one; errors are added to its own.
    at : sequence of float
        Shares of the pinion's face width from the toe, above 0 and below 1.
    by : (str, str)
        Names of two errors; axial ones are changes of the mounting distances.
    flank : {'right', 'left'}
    l : float, optional
        Where on the pinion's profile, mm, in place of what is centred (see `centred`).

    Returns
    -------
    Placement

    Raises
    ------
    ValueError
        For a batch, parallel axes, errors without a name, shares that are none, `l` off the pinion's active
        profile, and where a tool's rounds overlap.
    """
    flank_sign(flank)
    check_names(by, "by")
    if design.batch_shape:
        raise ValueError("a path is placed of a single design: give its cases one by one")
    if design.pair.shaft_angle == 0.0:
        raise ValueError(ON_PARALLEL)
    share = np.array(at, dtype=float)
    if share.ndim != 1 or not share.size or not ((share > 0.0) & (share < 1.0)).all():
        raise ValueError(f"at must be shares of the face above 0 and below 1, at least one, got {at}")
    low, high = float(root_parameter(design.pinion)), float(highest_parameter(design.pinion))
    wanted_l = centred(design, flank) if l is None else float(l)
    if not low <= wanted_l <= high:
        raise ValueError(f"l must be on the pinion's profile, {low:.4g} to {high:.4g} mm, got {wanted_l:g}")
    face = float(design.pinion.face_width)
    search = _Search(design, flank, by, limits_of(design, by), np.array((face, high - low)))
    wanted = np.stack((face * (share - 0.5), np.full(share.shape, wanted_l)), axis=-1)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        exact, shares, status = _found(search, wanted)
    return _forward(search, share, wanted, exact, shares, status)


def limits_of(design: Design, by: tuple[str, str]) -> FloatArray:
    """Give how large errors (2), mm or rad, are looked for to either side: a module of offset or centre
    distance, as much of shaft angle, in plane or out of it, as turns half the lesser face by a module (5 deg
    at most, and nine tenths of the shaft angle), the lesser face width of an axial position."""
    module = float(design.pinion.tool.normal_module)
    face = min(float(member.face_width) for member in design.members)
    angle = min(2.0 * module / face, WIDEST_ANGLE, 0.9 * abs(float(design.pair.shaft_angle)))
    sizes = dict.fromkeys(ANGLES, angle) | dict.fromkeys(("offset", "centre_distance"), module)
    return np.array([sizes.get(name, face) for name in by])


def centred(design: Design, flank: str) -> float:
    """Give l1 (mm) of a middle that is centred in profile: that of the path without errors if it runs from
    tip to tip, else 0."""
    path = path_of_contact(design.with_errors(Errors()), flank, 3)
    tips = set(path.ends.limit.tolist()) == {Limit.GEAR_TIP, Limit.PINION_TIP}
    return float(path.l1[1]) if tips and path.ends.status == Status.SOLVED else 0.0


def _found(search: _Search, wanted: FloatArray) -> tuple[FloatArray, FloatArray, Codes]:
    """Find, for places wanted (n, 2), shares of the limits (n, 2) that reach them and those that are nearest
    and can be assembled, both NaN without any, and status (n)."""
    shares = _newton(search, wanted, np.zeros_like(wanted))
    for k in np.flatnonzero(~_reached(search, shares, wanted)):
        begin = np.concatenate((shares[k : k + 1], _lowest(search, wanted[k])))
        goal = np.broadcast_to(wanted[k], begin.shape)
        ends = _newton(search, goal, begin)
        good = _reached(search, ends, goal)
        if good.any():
            ends = np.unique(np.round(ends[good], ALIKE), axis=0)
            jams = np.asarray(mounted_backlash(search.under(ends)).jammed)
            first = ends[np.lexsort((np.abs(ends).max(axis=-1), jams))[:1]]
            shares[k] = _newton(search, wanted[k : k + 1], first)[0]
        else:
            order = np.argsort(search.apart(search.places(ends), goal), kind="stable")
            shares[k] = _polished(search, wanted[k], ends[order[:POLISHED]])
    reached = _reached(search, shares, wanted)
    exact, status = np.where(reached[:, None], shares, np.nan), np.full(len(wanted), PlaceStatus.REACHED)
    status[~reached] = PlaceStatus.OUT_OF_REACH
    jammed = np.asarray(mounted_backlash(search.under(shares)).jammed)
    nearest = shares.copy()
    for k in np.flatnonzero(reached & jammed):
        status[k] = PlaceStatus.OFF_CENTRE
        nearest[k] = _with_backlash(search, wanted[k], shares[k])
    status[np.isnan(shares).any(axis=1)] = PlaceStatus.NO_PATH
    return exact, nearest, status.astype(np.int8)


def _reached(search: _Search, shares: FloatArray, wanted: FloatArray) -> Mask:
    """Say (n) whether errors within the limits put the middle where it is wanted."""
    off = np.abs(search.places(shares) - wanted).max(axis=-1)
    return np.asarray((off <= CLOSE) & (np.abs(shares) <= 1.0).all(axis=-1))


def _newton(search: _Search, wanted: FloatArray, start: FloatArray) -> FloatArray:
    """Go from shares (n, 2) of the limits towards places wanted (n, 2), by steps that come nearer."""
    shares, (place, by) = start, search.rates(start)
    lengths = 0.5 ** np.arange(HALVINGS)
    row = np.arange(len(start))
    for _ in range(STEPS):
        off = search.apart(place, wanted)
        going = np.isfinite(by).all(axis=(1, 2)) & (np.abs(place - wanted).max(axis=-1) > 1e-3 * CLOSE)
        step = np.zeros_like(shares)
        for k in np.flatnonzero(going):
            step[k] = -np.linalg.lstsq(by[k], (place - wanted)[k], rcond=None)[0]
        step *= np.minimum(1.0, LONGEST / np.maximum(np.abs(step).max(axis=-1), 1e-300))[:, None]
        tried = np.clip(shares[:, None] + lengths[:, None] * step[:, None], -1.0, 1.0)
        places, rates = search.rates(tried.reshape(-1, 2))
        places, rates = places.reshape(tried.shape), rates.reshape(*tried.shape, 2)
        far = search.apart(places, wanted[:, None])
        best = np.where(far < off[:, None], far, np.inf).argmin(axis=1)
        nearer = going & (far[row, best] < off)
        if not nearer.any():
            break
        pick = row[nearer], best[nearer]
        shares = shares.copy()
        shares[nearer], place[nearer], by[nearer] = tried[pick], places[pick], rates[pick]
    return shares


def _with_backlash(search: _Search, wanted: FloatArray, exact: FloatArray) -> FloatArray:
    """Find shares (2) of the limits that put the middle at the share of the face wanted (2), as little beside
    the l1 wanted as leaves backlash; from those that jam the pair. NaN where none within BESIDE do."""
    sides, found = np.concatenate((BESIDE, -BESIDE)) * search.unit[1], np.full(2, np.nan)

    def tried(beside: FloatArray, start: FloatArray) -> tuple[FloatArray, Mask]:
        """Give shares (n, 2) that move the middle in profile by (n), mm, and whether it can run so."""
        goal = wanted + np.stack((np.zeros_like(beside), beside), axis=-1)
        shares = _newton(search, goal, np.broadcast_to(start, goal.shape).copy())
        good = _reached(search, shares, goal)
        good[good] = ~np.asarray(mounted_backlash(search.under(shares[good])).jammed) if good.any() else False
        return shares, good

    shares, good = tried(sides, exact)
    if not good.any():
        return found
    first = np.flatnonzero(good)[np.abs(sides[good]).argmin()]
    found, far = shares[first], sides[first]
    near = max((one for one in np.abs(sides) if one < abs(far)), default=0.0) * np.sign(far)
    while abs(far - near) > NARROW:
        between = near + (far - near) * np.array((0.25, 0.5, 0.75))
        shares, good = tried(between, found)
        first = int(np.append(good, True).argmax())
        near = between[first - 1] if first else near
        if first < len(good):
            found, far = shares[first], between[first]
    return np.asarray(found)


def _lowest(search: _Search, wanted: FloatArray) -> FloatArray:
    """Look over all shares of the limits, on an even grid and on one in proportion down to LEAST_SHARE, for
    middles near a place wanted (2): shares (n, 2), the nearest of each and those nearer than all beside."""
    begin = []
    for sizes in (np.linspace(0.0, 1.0, GRID + 1)[1:], np.geomspace(LEAST_SHARE, 1.0, GRID // 3)):
        side = np.concatenate((-sizes[::-1], [0.0], sizes))
        shares = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1)
        far = search.apart(search.places(shares.reshape(-1, 2)), wanted).reshape(shares.shape[:2])
        beside = np.lib.stride_tricks.sliding_window_view(np.pad(far, 1, constant_values=np.inf), (3, 3))
        lowest = np.isfinite(far) & (far <= beside.min(axis=(2, 3)))
        for among in (lowest, np.isfinite(far)):
            begin.append(shares[among][np.argsort(far[among])][:STARTS])
    return np.asarray(np.unique(np.concatenate(begin), axis=0))


def _polished(search: _Search, wanted: FloatArray, starts: FloatArray) -> FloatArray:
    """Go on from some shares (n, 2) to the nearest middle, by sequential quadratic programming in coordinates
    in which the middle moves evenly; give that which comes nearest, NaN without any."""
    from scipy import optimize

    minimize: Any = optimize.minimize
    best, nearest = np.full(2, np.nan), np.inf
    for start in starts[np.isfinite(starts).all(axis=1)]:
        by = search.rates(start[None])[1]
        if not np.isfinite(by).all():
            continue
        left, size, right = np.linalg.svd(by[0] / search.unit[:, None])
        basis = right.T / np.maximum(size, FLAT * size[0]) @ left.T

        def far(
            x: FloatArray, start: FloatArray = start, basis: FloatArray = basis
        ) -> tuple[float, FloatArray]:
            """Give the square of the distance, and its derivatives (2)."""
            place, by = search.rates((start + basis @ x)[None])
            off = (place[0] - wanted) / search.unit
            if not np.isfinite(off).all():
                return LOST, np.zeros(2)
            return float(off @ off), np.asarray(2.0 * off @ (by[0] / search.unit[:, None]) @ basis)

        def room(x: FloatArray, start: FloatArray = start, basis: FloatArray = basis) -> FloatArray:
            """Give how far the shares are within the limits (4)."""
            shares = start + basis @ x
            return np.concatenate((1.0 - shares, 1.0 + shares))

        rules = {"type": "ineq", "fun": room}
        options = {"maxiter": STEPS, "ftol": 1e-14}
        end = minimize(far, np.zeros(2), jac=True, method="SLSQP", constraints=rules, options=options).x
        for shares in (np.clip(start + basis @ end, -1.0, 1.0), start):
            value = float(search.apart(search.places(shares[None]), wanted)[0])
            if value < nearest:
                best, nearest = shares, value
    return best


def _forward(
    search: _Search,
    share: FloatArray,
    wanted: FloatArray,
    exact: FloatArray,
    shares: FloatArray,
    status: Codes,
) -> Placement:
    """Solve the mountings found anew."""
    at = search.under(shares)
    places = search.places(shares)
    cycle = mesh_cycle(at, search.flank, 1)
    far, backlash = search.apart(places, wanted), mounted_backlash(at)
    return Placement(
        design=search.design,
        flank=search.flank,
        by=search.by,
        limits=search.limits,
        at=share,
        wanted_z=wanted[:, 0],
        wanted_l=float(wanted[0, 1]),
        errors=shares * search.limits,
        z=places[:, 0],
        l=places[:, 1],
        distance=np.where(np.isfinite(far), far, np.nan),
        contact_ratio=path_of_contact(at, search.flank, 2).ends.contact_ratio,
        normal_backlash=backlash.normal,
        cycle_peak_to_peak=cycle.peak_to_peak,
        edge_share=cycle.edge_share,
        status=status,
        jammed=backlash.jammed,
        exact=exact * search.limits,
    )
