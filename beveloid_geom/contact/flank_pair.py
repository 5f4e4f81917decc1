"""Constants of a flank pair: racks, layout, and limits of the flanks; and the terms of each member in F.

`pairing_of` collects them for designs and batches of designs. Pinion and gear are on the leading axis of all
arrays, (2, cases, 1), where the batch axes of the design are one axis of cases. The terms are steps 1 and 2
of the derivation in `equation`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np

from ..arrays import FloatArray, Integers, Mask, flank_sign
from ..design.arguments import require_unmodified
from ..design.member import Member, stacked, unchecked
from ..design.model import Design
from ..gear.crossing_curve import CrossingCurve
from ..gear.flank_limits import active_range, may_fold, tip_radius
from ..gear.rack import Numbers, Rack, rack_at, rack_of
from ..gear.tooth_side import is_batch, undercut_edge
from ..pair.frames import Layout, layout_by_case
from ..pair.mounting import mounting_of
from ..support.frozen_arrays import cached, read_only


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of undercut of one member.

    `curves` has one entry for each different member of a batch: the edge, or None without an edge that
    depends on z. `number` (cases,) is the index in `curves` of each case, -1 for a case without an edge.
    Without `number`, all cases have the curve `curves[0]`.
    """

    curves: tuple[CrossingCurve | None, ...]
    number: Integers | None = None

    def cases(self, index: Integers | slice) -> Edges:
        """Return the edges of the cases `index`."""
        return self if self.number is None else Edges(self.curves, self.number[index])

    def by_curve(self) -> Iterator[tuple[CrossingCurve, Integers | slice]]:
        """Iterate over the curves and the cases of each."""
        for k, curve in enumerate(self.curves):
            if curve is not None and self.number is None:
                yield curve, slice(None)
            elif curve is not None and (at := np.flatnonzero(self.number == k)).size:
                yield curve, at


@dataclass(frozen=True, eq=False)
class FlankPair:
    """Constants of one flank pair.

    Racks, layout with errors, `branch` (the sign of n_x), axial `position` of the mid-faces (mm), numbers of
    `teeth`, and the limits of the active flanks. Shapes (2, cases, 1), or (cases, 1) where shared.

    `lowest` and `highest` (mm) bound the flank parameter l over the entire active flank. `tip` is the tip
    radius at mid-face (mm), `taper` the tangent of the cone angle, and `half_width` half the face width (mm).
    `edges` has one entry for pinion and gear: the edges of undercut whose l depends on z, or None. It is
    empty if neither member has such an edge.
    """

    rack: Rack
    layout: Layout
    branch: FloatArray
    position: FloatArray
    teeth: FloatArray
    lowest: FloatArray
    highest: FloatArray
    tip: FloatArray
    taper: FloatArray
    half_width: FloatArray
    edges: tuple[Edges | None, ...] = ()

    def cases(self, index: Integers | slice) -> FlankPair:
        """Return the flank pairs of the cases `index`."""
        pick = {name: getattr(self, name)[..., index, :] for name in _BY_CASE}
        layout = {name: value[index] for name, value in vars(self.layout).items()}
        edges = tuple(edge and edge.cases(index) for edge in self.edges)
        return FlankPair(
            rack=self.rack.pick((slice(None), index)), layout=Layout(**layout), edges=edges, **pick
        )

    @cached_property
    def near_gear(self) -> tuple[FloatArray, MemberTerms]:
        """Samples of l2, mm, over the gear flank and a tenth of its depth beyond, and the terms of the gear
        there.
        """
        low, high = self.lowest[1], self.highest[1]
        l2 = low + np.linspace(-0.1, 1.1, 7)[:, None, None] * (high - low)
        return read_only((l2, terms_of_one(self, l2, 1)))

    @cached_property
    def undefined(self) -> Mask:
        """Whether a case (cases) has no flanks, or no mounting."""
        known = (self.lowest + self.highest + self.position).sum(axis=0) + self.layout.offset
        return read_only(np.asarray(~np.isfinite(known)[:, 0]))

    @cached_property
    def edged(self) -> Mask:
        """Whether a flank of each case (cases) has an edge of undercut that depends on z."""
        result = np.zeros(len(self.branch), dtype=bool)
        for edges in self.edges:
            for _, at in edges.by_curve() if edges else ():
                result[at] = True
        return read_only(result)

    @cached_property
    def parallel(self) -> Mask:
        """Whether the axes of each case (cases) are parallel. Their contacts are those of
        `parallel.equation`.
        """
        return read_only(np.asarray(self.layout.parallel[:, 0]))

    @cached_property
    def without_parabola(self) -> Mask:
        """Whether the racks of both members of each case (cases) have no parabola."""
        coefficients = np.broadcast_to(self.rack.parabola, (2, *self.branch.shape))
        return read_only((coefficients == 0.0).all(axis=(0, 2)))

    @cached_property
    def scale(self) -> FloatArray:
        """Size of the terms of F (cases, 1), mm, to which its rounding error is proportional."""
        sizes = self.rack.pitch_radius + np.abs(self.position)
        return read_only(np.asarray(sizes[0] + sizes[1] + self.layout.offset))


_BY_CASE = tuple(field.name for field in fields(FlankPair) if field.name not in ("rack", "layout", "edges"))


@dataclass(frozen=True, eq=False)
class MemberTerms:
    """Contribution of one member to F at its flank parameter.

    `normal` and rack point `start` (3, ...), mm, in the generating frame; `square` is the root
    S = sqrt(1 - v^2), the component of the normal perpendicular to the axis; `moment` g of the normal about
    the axis, mm; and the coefficients of eta = A + B w: A is `level`, mm, B is `slope`.
    """

    normal: Numbers
    start: Numbers
    square: Numbers
    moment: Numbers
    level: Numbers
    slope: Numbers

    def of(self, member: int) -> MemberTerms:
        """Return the terms of pinion (0) or gear (1) from those of both."""
        normal, start, *remaining = vars(self).values()
        return MemberTerms(normal[:, member], start[:, member], *(value[member] for value in remaining))

    def pick(self, *index: Any) -> MemberTerms:
        """Return the terms of one member at an `index` of cases and positions."""
        return MemberTerms(*(value[..., *index] for value in vars(self).values()))


Distinct: TypeAlias = tuple[list[Member], Integers]
Each: TypeAlias = tuple[Member | Distinct, Member | Distinct]


def _flanks(members: Member, flank: str, each: Each | None, undercut: bool = True) -> dict[str, Any]:
    """Return the fields of a `FlankPair` that depend on the stacked members alone.

    `each` contains both members if all cases have the same single members. Without `undercut` the flanks are
    not limited by undercut.
    """
    rack, (lowest, highest) = rack_of(members, flank), active_range(members, flank)
    edges: tuple[Edges | None, ...] = ()
    if undercut and (folding := may_fold(members, rack, lowest, highest)).any():
        each = each or _distinct(members, folding)
        edges = _edges(each[0], flank, lowest[0]), _edges(each[1], flank, lowest[1])
    return {
        "rack": rack,
        "teeth": np.asarray(members.teeth),
        "lowest": lowest,
        "highest": highest,
        "tip": tip_radius(members, 0.0),
        "taper": np.asarray(np.tan(members.cone_angle)),
        "half_width": np.asarray(0.5 * members.face_width),
        "edges": edges if any(edges) else (),
    }


def _distinct(members: Member, folding: Mask) -> Each:
    """Return the different pinions and gears that may be undercut, and the number (cases,) of the member of
    each case, -1 for a member without undercut.

    `folding` (2, cases) states where the generated surface may turn back on itself, which is undercut.
    """
    tool, result = members.tool, []
    for j, folds in enumerate(folding.reshape(2, -1)):
        at, number = np.flatnonzero(folds), np.full(folds.size, -1)
        names = [name for name, value in vars(members).items() if isinstance(value, np.ndarray)]
        columns = [vars(tool)[name] for name in vars(tool)] + [vars(members)[name] for name in names]
        rows = np.stack([column[j, at, 0] for column in columns], axis=-1)
        rows, inverse = np.unique(rows, axis=0, return_inverse=True)
        number[at] = inverse.reshape(-1)  # NumPy 2.0 returns a column
        singles = []
        for row in rows.tolist():
            values = dict(zip([*vars(tool), *names], row, strict=True))
            single = unchecked(tool, **{name: values.pop(name) for name in vars(tool)})
            singles.append(unchecked(members, tool=single, **values))
        result.append((singles, number))
    return result[0], result[1]


def _edges(member: Member | Distinct, flank: str, lowest: FloatArray) -> Edges | None:
    """Return the edges of undercut of a single member, or of members with the numbers of their cases.

    An edge with the same l in all planes raises `lowest` (cases, 1), mm, instead.
    """
    singles, number = member if isinstance(member, tuple) else ([member], None)
    curves: list[CrossingCurve | None] = []
    for k, single in enumerate(singles):
        curve, at = undercut_edge(single, flank), slice(None) if number is None else number == k
        # On cylinders the edge is the same in all planes.
        if curve is not None and single.cone_angle == 0.0:
            lowest[at], curve = np.maximum(lowest[at], curve.start(np.zeros(1))), None
        curves.append(curve)
    return Edges(tuple(curves), number) if any(curves) else None


@cached(64)
def _cached_flanks(pinion: Member, gear: Member, flank: str) -> Mapping[str, Any]:
    return MappingProxyType(_flanks(stacked(pinion, gear), flank, (pinion, gear)))


def pairing_of(design: Design, flank: str, undercut: bool = True) -> FlankPair:
    """Return the constants of the contact of `flank` ('right' or 'left') of both members.

    Without `undercut` the flanks are not limited by undercut. Results of single designs are cached, and so
    are the parts that depend on the members alone.

    Raises
    ------
    ModifiedFlanksError
        For flanks with a modification, to which the equation does not apply.
    """
    require_unmodified(
        flank, "calculations with the one equation of contact", pinion=design.pinion, gear=design.gear
    )
    if undercut and not design.batch_shape:
        return _cached_pairing(design, flank)
    return _pairing(design, flank, undercut)


def is_modified(design: Design, flank: str) -> bool:
    """Return whether a flank of a design has a modification.

    The equation of contact does not apply to modified flanks; `surfaces` solves their path.
    """
    return any(member.modification(flank) is not None for member in design.members)


def generated_pairing(design: Design, flank: str, undercut: bool = True) -> FlankPair:
    """Return the constants of `pairing_of` for the generated flanks.

    Racks, layout, positions and limits are the same with and without modifications.
    """
    if is_modified(design, flank):
        shape = design.batch_shape  # amounts may be arrays
        pinion, gear = (member.modified(None) for member in design.members)
        design = unchecked(design, pinion=pinion, gear=gear, batch_shape=shape)
    return pairing_of(design, flank, undercut)


def may_be_undercut(design: Design, flank: str) -> bool:
    """Return whether a flank of a design may be undercut. If False, no flank is undercut."""
    members = design.stacked_members()
    return bool(may_fold(members, rack_of(members, flank), *active_range(members, flank)).any())


def _pairing(design: Design, flank: str, undercut: bool = True) -> FlankPair:
    shape, mounting = design.batch_shape, mounting_of(design)
    if shape or not undercut:
        single = not any(map(is_batch, design.members))
        each = design.members if single else None
        flanks: Mapping[str, Any] = _flanks(design.stacked_members(), flank, each, undercut)
    else:
        flanks = _cached_flanks(*design.members, flank)
    # Mounting distances plus axial errors.
    position = np.empty((2, *shape))
    position[0] = mounting.distance[0] + design.errors.pinion_axial
    position[1] = mounting.distance[1] + design.errors.gear_axial
    branch = np.broadcast_to(mounting.branch[0 if flank_sign(flank) > 0.0 else 1], shape)
    return FlankPair(
        layout=layout_by_case(design),
        branch=branch.reshape(-1, 1),
        position=position.reshape(2, -1, 1),
        **flanks,
    )


_cached_pairing = cached(8)(_pairing)


def terms_of(pairing: FlankPair, l: Numbers) -> MemberTerms:
    """Return the terms of both members at flank parameters (2, cases, positions), mm."""
    return _terms(pairing.rack, pairing.position, l)


def terms_of_one(pairing: FlankPair, l: Numbers, member: int) -> MemberTerms:
    """Return the terms of pinion (0) or gear (1) at its flank parameters (..., cases, positions), mm."""
    return _terms(pairing.rack.parts[member], pairing.position[member], l)


def _terms(rack: Rack, position: FloatArray, l: Numbers) -> MemberTerms:
    normal, start, tangent = rack_at(rack, l)
    nx, ny, v = normal
    square = np.sqrt(1.0 - v * v)
    # Generated line at u = 0: n.Q = S xi + v z0, w = S z0 - v xi; B is d eta / d w along the line.
    ratio = square / nx
    xi = rack.pitch_radius / ratio + start[0] * ratio
    slope = ny * tangent[2] / (square * tangent[1])
    # Intersect the generated line with w = 0: A = eta - B w.
    z = start[2] + position
    level = square * xi + v * z + slope * (v * xi - square * z)
    return MemberTerms(normal, start, square, rack.pitch_radius * ny, level, slope)
