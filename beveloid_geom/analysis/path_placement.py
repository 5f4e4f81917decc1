"""Two assembly errors that move the path of contact to a required position: the inverse of `sensitivity`.

The middle of a path is its position at mid-roll, half-way in roll between the two ends of the path. The
wanted position is given by z on the pinion, a share of the face width, and by l1, centred in profile. A path
that runs from tip to tip of the members is centred in any case; under errors it must keep the l1 that its
middle has without errors. For all other paths, the required l1 is that of the reference line of the tool,
which is near the middle of its flank. With the two errors e,

    F(e) = (z(e) - z_wanted, l1(e) - l1_wanted) = 0

is solved by Newton's method, which starts from the design and takes exact derivatives of the middle from
`sensitivity`. Of the full step and its seven halvings, the one that comes nearest is taken, if it reduces the
distance. If the iteration does not converge within the limits of the errors (`search_limits`), it is repeated
from the grid points whose paths lie nearest to the wanted position. If these do not converge either, all
results are NaN and the status is NOT_CONVERGED, or NO_PATH if the grid, which contains the design, has no
path at all.

If the errors use up the backlash, the pair cannot be assembled. The middle then keeps z_wanted and leaves the
centre of the profile, no further than until the backlash is 0 (OFF_CENTRE). This is a root of the backlash as
a function of l1. Positions on both sides of the centre are tried, up to a quarter of the profile depth. The
root lies between the nearest one at which the pair can be assembled and the next one towards the centre; it
is found by bisection. If the pair jams at all trial positions, the values are NaN."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.path import path_of_contact
from ..design.arguments import require_numbers, require_single
from ..design.field_limits import float64_of
from ..design.model import Design, Errors
from ..gear.flank_limits import active_range
from ..operation.backlash import mounted_backlash
from ..operation.mesh_cycle import mesh_cycle
from ..pair.misalignment import ANGLES, NAMES, mounted, place_of
from ..status import Limit, PlaceStatus, Status
from ..support.argument import ArgumentError
from ..support.array_repr import short_repr
from .pattern_matrix import check_names
from .sensitivity import path_sensitivity

POSITION_TOLERANCE_MM = 1e-6


@dataclass(frozen=True, eq=False)
class Placement:
    """Mountings that move the middle of a path to shares `at` (n) of the face width of the pinion.

    Attributes
    ----------
    by : tuple of str
        Names of the two errors.
    limits : FloatArray
        (2,), search limits of the errors in both directions, mm or rad.
    wanted_z, wanted_l : FloatArray and float
        Required position of the middle on the pinion: z (n,) and flank parameter, mm.
    errors : FloatArray
        (n, 2), errors to be added to those of the design, mm or rad. The following values belong to this
        mounting.
    z, l : FloatArray
        (n,), position of the middle, mm, from a path computed for the new mounting.
    distance : FloatArray
        (n,), distance from the required position, relative to face width and profile depth.
    contact_ratio : FloatArray
        (n,), Eq. 16.
    normal_backlash : FloatArray
        (n,), backlash as mounted, mm.
    cycle_peak_to_peak, edge_share : FloatArray
        (n,), transmission error of all teeth, rad, and share of the mesh cycle in which edges touch.
    status : Codes
        (n,), codes of `PlaceStatus`. NOT_CONVERGED: all values are NaN. OFF_CENTRE: the values belong to the
        nearest position in profile at which the pair can be assembled. JAMMED: it cannot be assembled at any
        trial position; only `exact` is known. NO_PATH: neither the design nor any mounting that was tried has
        a path.
    jammed : Mask
        (n,): the pair cannot be assembled with `errors`, or at no trial position (JAMMED).
    exact : FloatArray
        (n, 2), errors that move the middle to the required position, even if the pair cannot be assembled
        there; NaN if there are none.
    """

    __repr__ = short_repr

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
class _PlacementSearch:
    """Search variables: two errors of a design, as shares (..., 2) of their `limits`. Positions are (z, l1)
    of the middle of the path, mm. Distances are relative to the size `unit` (2,) of the pinion flank, mm."""

    design: Design
    flank: str
    by: tuple[str, str]
    limits: FloatArray
    unit: FloatArray

    def under(self, shares: FloatArray) -> Design:
        """Return the mountings (...) under errors (..., 2)."""
        return mounted(self.design, shares * self.limits, self.by)

    def places(self, shares: FloatArray) -> FloatArray:
        """Return the middles (n, 2) of the paths under errors (n, 2); NaN without a path."""
        path = path_of_contact(self.under(shares), self.flank, 3)
        middles = np.stack((path.pinion_z[:, 1], path.l1[:, 1]), axis=-1)
        return np.where((path.ends.status == Status.SOLVED)[:, None], middles, np.nan)

    def rates(self, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the middles (n, 2) and their derivatives (n, 2, 2) by the shares."""
        at = place_of(self.by)
        sensitivity = path_sensitivity(self.under(shares), self.flank, at)
        columns = [NAMES[at].index(name) for name in self.by]
        by = np.stack((sensitivity.z_by[:, 1, 0], sensitivity.l_by[:, 1, 0]), axis=1)[..., columns]
        return np.stack((sensitivity.z[:, 1, 0], sensitivity.l[:, 1, 0]), axis=-1), by * self.limits

    def apart(self, places: FloatArray, wanted: FloatArray) -> FloatArray:
        """Return distances (...); infinite without a position."""
        far = np.linalg.norm((places - wanted) / self.unit, axis=-1)
        return np.where(np.isnan(far), np.inf, far)


def place_path(
    design: Design,
    at: Sequence[float] = (0.25, 0.5, 0.75),
    by: tuple[str, str] = ("offset", "shaft_angle"),
    flank: str = "right",
    l: float | None = None,
) -> Placement:
    """Compute two errors that move the middle of the path to shares `at` of the face width, centred in
    profile.

    Parameters
    ----------
    design : Design
        A single design; the errors are added to its errors.
    at : sequence of float
        Shares of the pinion face width from the end at -z, above 0 and below 1.
    by : (str, str)
        Names of two errors. Axial errors are changes of the mounting distances.
    flank : {'right', 'left'}
    l : float, optional
        Required flank parameter on the pinion, mm; by default the value at which the path is centred in
        profile (`centred`).

    Returns
    -------
    Placement

    Raises
    ------
    ValueError
        For a batch; for parallel axes; for unknown errors; for shares outside their limits; for `l` outside
        the active profile of the pinion; and if the tip rounds of a tool overlap.

    References
    ----------
    Method: beveloid_geom/analysis/README.md, Placement of a path.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> placement = bg.place_path(bg.builtin_design("ni-2017"), at=[0.5])
    >>> print(f"offset error {placement.errors[0, 0]:.4f} mm")
    offset error 0.0238 mm
    """
    require_single(design)
    flank_sign(flank)
    check_names(by, "by")
    if design.pair.shaft_angle == 0.0:
        text = "on parallel axes a path runs along the complete face, also with parabolas, so that its middle"
        cure = "give the pair a shaft angle (`beveloid-geom propose`), or compute the effect of errors by"
        raise ValueError(f"{text} cannot be moved: {cure} `beveloid-geom pattern --over offset,shaft-angle`")
    require_numbers(l=l)
    share = float64_of("at", at)
    if share.ndim != 1 or not share.size or not ((share > 0.0) & (share < 1.0)).all():
        raise ValueError(f"at must be one or more shares of the face, above 0 and below 1, got {at}")
    low, high = map(float, active_range(design.pinion, flank))
    wanted_l = centred(design, flank) if l is None else float(l)
    if not low <= wanted_l <= high:
        limits = f"from {low:.4g} to {high:.4g} mm"
        text = f"must be on the pinion profile, {limits}, got {wanted_l:g}"
        raise ArgumentError("l", f"{text}: omit it for the centre of the profile")
    face = float(design.pinion.face_width)
    search = _PlacementSearch(design, flank, by, search_limits(design, by), np.array((face, high - low)))
    wanted = np.stack((face * (share - 0.5), np.full(share.shape, wanted_l)), axis=-1)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        exact, shares, status = _solved(search, wanted)
    return _forward(search, share, wanted, exact, shares, status)


def search_limits(design: Design, by: tuple[str, str]) -> FloatArray:
    """Return the search limits (2,) of two errors, mm or rad, in both directions.

    They are a module for the offset or centre distance, the smaller face width for an axial position, and for
    an angle the rotation that moves the end of the smaller face by a module, at most 5 deg and 0.9 times the
    shaft angle."""
    module = float(design.pinion.tool.normal_module)
    face = min(float(member.face_width) for member in design.members)
    angle = min(2.0 * module / face, np.radians(5.0), 0.9 * abs(float(design.pair.shaft_angle)))
    sizes = dict.fromkeys(ANGLES, angle) | dict.fromkeys(("offset", "centre_distance"), module)
    return np.array([sizes.get(name, face) for name in by])


def centred(design: Design, flank: str) -> float:
    """Return l1 (mm) of a middle that is centred in profile: that of the path without errors if it runs from
    tip to tip, else that of the reference line."""
    path = path_of_contact(design.with_errors(Errors()), flank, 3)
    tips = set(path.ends.limit.tolist()) == {Limit.GEAR_TIP, Limit.PINION_TIP}
    if tips and path.ends.status == Status.SOLVED:
        return float(path.l1[1])
    return 0.0 - float(design.pinion.tool.parabola_apex)


def _solved(search: _PlacementSearch, wanted: FloatArray) -> tuple[FloatArray, FloatArray, Codes]:
    """Return, for required positions (n, 2), the shares of the limits (n, 2) that reach them, those of a pair
    that can be assembled, both NaN without a solution, and the status (n)."""
    shares = _newton(search, wanted, np.zeros_like(wanted))
    reached = _reached(search, shares, wanted)
    # Points of the starting grid in each error, and starting values taken from it.
    grid_points, grid_starts = 41, 3
    missed = PlaceStatus.NOT_CONVERGED
    if not reached.all():
        side = np.linspace(-1.0, 1.0, grid_points)
        grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        places = search.places(grid)
        if not np.isfinite(places).all(axis=-1).any():
            missed = PlaceStatus.NO_PATH  # Newton's method has no starting value
    for k in np.flatnonzero(~reached):
        start = grid[np.argsort(search.apart(places, wanted[k]), kind="stable")[:grid_starts]]
        goal = np.broadcast_to(wanted[k], start.shape)
        ends = _newton(search, goal, start)
        if len(ends := ends[_reached(search, ends, goal)]):
            shares[k], reached[k] = ends[np.abs(ends).max(axis=-1).argmin()], True  # the smallest errors
    status = np.where(reached, PlaceStatus.REACHED, missed)
    exact = np.where(reached[:, None], shares, np.nan)
    assembled, jams = exact.copy(), reached & np.asarray(mounted_backlash(search.under(exact)).jammed)
    for k in np.flatnonzero(jams):
        assembled[k] = _off_centre(search, wanted[k], exact[k])
        status[k] = PlaceStatus.JAMMED if np.isnan(assembled[k]).any() else PlaceStatus.OFF_CENTRE
    return exact, assembled, status.astype(np.int8)


def _reached(search: _PlacementSearch, shares: FloatArray, wanted: FloatArray) -> Mask:
    """Return whether errors (n, 2) within the limits move the middle to the required positions (n, 2)."""
    off = np.abs(search.places(shares) - wanted).max(axis=-1)
    return np.asarray((off <= POSITION_TOLERANCE_MM) & (np.abs(shares) <= 1.0).all(axis=-1))


def _newton(search: _PlacementSearch, wanted: FloatArray, start: FloatArray) -> FloatArray:
    """Return shares (n, 2) of the limits after Newton steps towards the required positions (n, 2).

    Only rows that have not arrived are continued. Rows whose step gains less than `least_gain` are stopped:
    they approach a local minimum of the distance, not the required position."""
    newton_max_iterations = 40
    # Longest Newton step, as a share of the limits.
    longest_step = 0.1
    shares, (place, by) = start.copy(), search.rates(start)
    lengths, going = 0.5 ** np.arange(8), np.arange(len(start))
    # Smallest relative reduction of the distance for which a Newton iteration is continued.
    least_gain = 0.02
    for _ in range(newton_max_iterations):
        left = np.abs(place[going] - wanted[going]).max(axis=-1)
        going = going[np.isfinite(by[going]).all(axis=(1, 2)) & (left > 1e-3 * POSITION_TOLERANCE_MM)]
        if going.size == 0:
            break
        goal, off = wanted[going], search.apart(place[going], wanted[going])
        step = (np.linalg.pinv(by[going]) @ (goal - place[going])[..., None])[..., 0]
        step *= np.minimum(1.0, longest_step / np.maximum(np.abs(step).max(axis=-1), 1e-300))[:, None]
        # All shortened steps are tried in one call; the one that comes nearest is taken.
        tried = np.clip(shares[going, None] + lengths[:, None] * step[:, None], -1.0, 1.0)
        places, rates = search.rates(tried.reshape(-1, 2))
        places, rates = places.reshape(tried.shape), rates.reshape(*tried.shape, 2)
        far = search.apart(places, goal[:, None])
        best = far.argmin(axis=1)
        row = np.flatnonzero(far.min(axis=1) < off)
        pick, moved = (row, best[row]), going[row]
        shares[moved], place[moved], by[moved] = tried[pick], places[pick], rates[pick]
        going = moved[far[pick] <= (1.0 - least_gain) * off[row]]
    return shares


def _off_centre(search: _PlacementSearch, wanted: FloatArray, exact: FloatArray) -> FloatArray:
    """Return shares (2) of the limits that keep z of the required position (2) and leave the required l1 only
    until the pair can be assembled; NaN if it cannot at any trial position.

    `exact` (2) are the shares that reach the required position, where the pair jams."""
    off_centre_tolerance_mm = 1e-4

    def solved(off: FloatArray, start: FloatArray) -> tuple[FloatArray, Mask]:
        """Return shares (n, 2) for distances (n), mm, from the required l1, and whether the pair can be
        assembled there."""
        goal = wanted + np.stack((np.zeros_like(off), off), axis=-1)
        shares = _newton(search, goal, np.broadcast_to(start, goal.shape).copy())
        good = _reached(search, shares, goal)
        good[good] = ~np.asarray(mounted_backlash(search.under(shares[good])).jammed) if good.any() else False
        return shares, good

    # Trial distances from the centre of the profile, as shares of the profile depth.
    off_centre_shares = 0.25 * (np.arange(1, 7) / 6.0) ** 2
    trials = np.concatenate((off_centre_shares, -off_centre_shares)) * search.unit[1]
    shares, good = solved(trials, exact)
    if not good.any():
        return np.full(2, np.nan)
    first = int(np.where(good, np.abs(trials), np.inf).argmin())
    solved_shares, far = shares[first], trials[first]
    # Bisection between the nearest trial that can be assembled and the next one towards the centre.
    near = np.sign(far) * np.abs(trials[np.abs(trials) < abs(far)]).max(initial=0.0)
    while abs(far - near) > off_centre_tolerance_mm:
        between = 0.5 * (near + far)
        shares, good = solved(np.array([between]), solved_shares)
        solved_shares, far, near = (shares[0], between, near) if good[0] else (solved_shares, far, between)
    return np.asarray(solved_shares)


def _forward(
    search: _PlacementSearch,
    share: FloatArray,
    wanted: FloatArray,
    exact: FloatArray,
    shares: FloatArray,
    status: Codes,
) -> Placement:
    """Return the placement with the results of its mountings, computed for the new errors."""
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
        jammed=backlash.jammed | (status == PlaceStatus.JAMMED),
        exact=exact * search.limits,
    )
