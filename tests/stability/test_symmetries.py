"""Symmetries hold to rounding: mirrored, exchanged and scaled pairs have the same results.

The effect of rounding is computed for each result. All inputs are changed by a small relative amount, one at
a time. The changes of the result, scaled to one unit of rounding, are added and multiplied by `OPERATIONS`.
The sum is large for sensitive pairs: Table 1's right flanks move by 57 m per rad of shaft angle, which is 0.1
nm for its rounding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Status,
    contact_pattern,
    first_contact,
    mesh_cycle,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.path import path_ends
from beveloid_geom.operation.contact_pattern.pattern import MemberPattern
from beveloid_geom.operation.cycle.segment_fit import END_TOLERANCE_PITCHES
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.status import FirstStatus
from tests.operation.test_first_contact import EDGES
from tests.oracle.table1 import table1
from tests.symmetry import OTHER, exchanged, mirrored, scaled

EPS = float(np.finfo(float).eps)
OPERATIONS, NUDGE = 32.0, 1e-8
"""Number of rounding errors from the inputs to a result that may add up; relative change of an input."""
SWAPPED_LIMIT = np.array([1, 0, 3, 2, 5, 4, 7, 6, -1])
"""Codes of the limits with pinion and gear exchanged; the last one means no limit, -1."""
DESIGNS = {
    "unmodified": (0.0, 0.0),
    "recommended": (0.001, -0.001),
    "approximate line contact": (0.0003, 0.0003),
    "convex": (-0.0005, -0.0005),
}

FIRST = {name: table1(parabola, Errors(0.05, 1e-4, 0.1, -0.2)) for name, parabola in DESIGNS.items()} | EDGES


@dataclass(frozen=True)
class Seen:
    """Another view of a design: its `flank`, the `factor` of lengths, the sign of rolls and of y, and the
    index of the `member` that corresponds to member 0."""

    name: str
    design: Design
    flank: str
    factor: float = 1.0
    sign: float = 1.0
    first: int = 0


def seen_otherwise(design: Design, flank: str) -> list[Seen]:
    sizes = (0.01 / 6.0, 0.5, 100.0 / 6.0)  # modules 0.01, 3 and 100 mm
    return [
        Seen("mirror", mirrored(design), OTHER[flank], sign=-1.0),
        *(Seen(f"scaled {size:.2g}", scaled(design, size), flank, factor=size) for size in sizes),
    ]


def nudged(design: Design) -> list[Design]:
    """Return the design with one input after the other changed by the share NUDGE."""
    pair, (pinion, gear), more = design.pair, design.members, 1.0 + NUDGE
    return [
        replace(design, pair=replace(pair, offset=pair.offset * more)),
        replace(design, pair=replace(pair, shaft_angle=pair.shaft_angle * more)),
        replace(design, pinion=replace(pinion, helix_angle=pinion.helix_angle * more)),
        replace(design, gear=replace(gear, cone_angle=gear.cone_angle * more)),
    ]


def rounding(answer: Callable[[Design], FloatArray], design: Design) -> FloatArray:
    """Return the effect of rounding on each number of a result."""
    value = answer(design)
    shifts = [np.abs(answer(other) - value) * (EPS / NUDGE) for other in nudged(design)]
    return np.asarray(OPERATIONS * (np.sum(shifts, axis=0) + EPS * np.abs(value).max(initial=1.0)))


def lengths(path: ContactPath) -> FloatArray:
    names = ("l1", "l2", "u1", "u2", "pinion_z", "gear_z", "pinion_r", "gear_r")
    return np.array([getattr(path, name) for name in names])


def angles(path: ContactPath, sign: float = 1.0) -> FloatArray:
    """Return the rolls with a sign, and the transmission error, whose sign does not change."""
    return np.array([sign * path.pinion_roll, sign * path.gear_roll, path.transmission_error])


parabolas = st.tuples(*[st.floats(-0.0012, 0.0012)] * 2)


@settings(max_examples=8)
@given(parabolas, st.floats(-0.3, 0.3), st.floats(-2.0, 2.0), st.sampled_from(["right", "left"]))
def test_paths_mirrored_and_scaled(
    parabola: tuple[float, float], offset: float, axial: float, flank: str
) -> None:
    design = table1(parabola, Errors(offset=offset, gear_axial=axial))
    path = path_of_contact(design, flank, 9)
    for seen in seen_otherwise(design, flank):
        other = path_of_contact(seen.design, seen.flank, 9)
        assert other.ends.status == path.ends.status, seen.name
        assert np.array_equal(other.ends.limit, path.ends.limit), seen.name
        assert other.ends.pieces == path.ends.pieces
        if path.ends.status != Status.SOLVED:
            continue
        l1 = path.l1  # the same positions in all changed designs
        again = path_of_contact(seen.design, seen.flank, l1=l1 * seen.factor)

        def in_mm(moved: Design, l1: FloatArray = l1) -> FloatArray:
            return lengths(path_of_contact(moved, flank, l1=l1))

        def in_rad(moved: Design, l1: FloatArray = l1) -> FloatArray:
            return angles(path_of_contact(moved, flank, l1=l1))

        assert (np.abs(lengths(again) / seen.factor - in_mm(design)) <= rounding(in_mm, design)).all()
        assert (np.abs(angles(again, seen.sign) - in_rad(design)) <= rounding(in_rad, design)).all()
        turned = again.point * (1.0, seen.sign, 1.0) / seen.factor
        bound = rounding(lambda moved: path_of_contact(moved, flank, l1=l1).point, design)  # noqa: B023
        assert (np.abs(turned - path_of_contact(design, flank, l1=l1).point) <= bound).all()


@settings(max_examples=8)
@given(parabolas, st.floats(-0.3, 0.3), st.sampled_from(["right", "left"]))
def test_ends_and_ratios(parabola: tuple[float, float], offset: float, flank: str) -> None:
    """Mirrored and scaled pairs, and exchanged members, for which the roll of the other member is
    compared."""
    design = table1(parabola, Errors(offset=offset))
    ends = path_ends(design, flank)

    def numbers(moved: Design) -> FloatArray:
        found = path_ends(moved, flank)
        return np.concatenate((found.l1, found.l2, [found.contact_ratio]))

    bound = rounding(numbers, design)
    for seen in seen_otherwise(design, flank):
        found = path_ends(seen.design, seen.flank)
        apart = np.concatenate((found.l1, found.l2)) / seen.factor - numbers(design)[:4]
        assert not (np.abs(apart) > bound[:4]).any(), seen.name  # NaN without a path
        assert abs(found.contact_ratio - ends.contact_ratio) <= bound[4] or np.isnan(ends.contact_ratio)
    other = path_ends(exchanged(design), flank)
    assert other.status == ends.status
    if ends.status == Status.SOLVED:
        turned = np.ptp(path_of_contact(design, flank, 2001).gear_roll) * 45 / (2.0 * np.pi)
        assert other.contact_ratio == pytest.approx(turned, abs=1e-6)
    assert np.array_equal(np.sort(SWAPPED_LIMIT[other.limit]), np.sort(ends.limit))
    assert not (np.abs(np.sort(other.l1) - np.sort(ends.l2)) > bound[2:4].max()).any()
    assert not (np.abs(np.sort(other.l2) - np.sort(ends.l1)) > bound[:2].max()).any()


@pytest.mark.parametrize("name", DESIGNS)
def test_paths_of_exchanged_members(name: str, flank: str) -> None:
    design = table1(DESIGNS[name], Errors(0.05, 1e-4, 0.1, -0.2))
    path = path_of_contact(design, flank, 9)
    other = path_of_contact(exchanged(design), flank, l1=path.l2)
    assert (other.status == Status.SOLVED).all()
    order = [1, 0, 3, 2, 5, 4, 7, 6]
    bound = rounding(lambda moved: lengths(path_of_contact(moved, flank, l1=path.l1)), design)
    assert (np.abs(lengths(other)[order] - lengths(path)) <= bound).all()
    turned = rounding(lambda moved: angles(path_of_contact(moved, flank, l1=path.l1)), design)
    assert (np.abs(angles(other)[[1, 0]] - angles(path)[:2]) <= turned[:2]).all()
    assert (np.abs(other.normal[:, 0] - path.normal[:, 0]) < 1e-12).all()


def cycle_rolls(design: Design, flank: str, count: int = 7) -> FloatArray:
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    return np.asarray(float(pitch_point_roll(design, flank)) + pitch * (np.arange(count) + 0.37) / count)


@pytest.mark.slow
@pytest.mark.parametrize("name", FIRST)
def test_first_contacts(name: str, flank: str) -> None:
    """Tooth pair, edges and fillets, position, and roll. The numbers of tooth pairs change their sign if
    the members are exchanged or mirrored."""
    design = FIRST[name]
    first = first_contact(design, flank, cycle_rolls(design, flank))
    assert (first.status == FirstStatus.SOLVED).all()

    def places(moved: Design) -> FloatArray:
        found = first_contact(moved, flank, first.pinion_roll)
        same = found.pair == first.pair
        return np.where(
            same, (found.l1, found.z1, found.l2, found.z2), (first.l1, first.z1, first.l2, first.z2)
        )

    bound = rounding(places, design)
    turn = OPERATIONS * EPS * 2.0 * np.pi
    for seen in seen_otherwise(design, flank):
        rolls = seen.sign * first.pinion_roll
        found = first_contact(seen.design, seen.flank, rolls)
        assert np.array_equal(found.status, first.status)
        assert np.array_equal(found.pair, seen.sign * first.pair), seen.name
        assert np.array_equal(found.limit, first.limit), seen.name
        assert np.abs(seen.sign * found.gear_roll - first.gear_roll).max() <= turn, seen.name
        assert np.abs(found.transmission_error - first.transmission_error).max() <= turn, seen.name
        where = np.array((found.l1, found.z1, found.l2, found.z2)) / seen.factor
        assert (np.abs(where - places(design)) <= bound).all(), seen.name
    other = first_contact(exchanged(design), flank, first.gear_roll)
    assert np.abs(other.gear_roll - first.pinion_roll).max() <= turn
    if (
        name != "unmodified"
    ):  # two pairs touch at the same time there, and the pair that came last is another one
        assert np.array_equal(other.pair, -first.pair)
        assert np.array_equal(np.sort(SWAPPED_LIMIT[other.limit]), np.sort(first.limit))
        where = np.array((other.l2, other.z2, other.l1, other.z1))
        assert (np.abs(where - places(design)) <= bound).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_certificates(name: str, flank: str) -> None:
    """Verdicts are equal. Separations are equal to rounding of the rolls, except where an edge of one
    member overlaps: a rotation of the one or the other member is equal to first order only."""
    design = table1(DESIGNS[name], Errors(0.05, 1e-4, 0.1, -0.2))
    path = path_of_contact(design, flank, 9)
    inner = path_of_contact(design, flank, l1=path.l1[1:-1])  # at the ends, tangencies lie on edges
    proof = path_certificate(inner)
    lever = 0.5 * 6.0 * 45.0
    for seen in seen_otherwise(design, flank):
        other = path_certificate(path_of_contact(seen.design, seen.flank, l1=inner.l1 * seen.factor))
        assert np.array_equal(other.verdict, proof.verdict), seen.name
        apart = other.separation / seen.factor - proof.separation
        bound = rounding(lambda moved: path_of_contact(moved, flank, l1=inner.l1).gear_roll, design)
        assert (np.abs(apart) <= lever * (bound + OPERATIONS * EPS * 2.0 * np.pi)).all(), seen.name
    other = path_certificate(path_of_contact(exchanged(design), flank, l1=inner.l2))
    assert np.array_equal(other.verdict, proof.verdict)
    second_order = proof.separation**2 / design.pinion.tool.normal_module
    assert (np.abs(other.separation - proof.separation) <= 1e-10 + second_order).all()


@pytest.mark.slow
def test_mesh_cycles() -> None:
    """Extrema may differ by the error of the kinks, which are found to END_TOLERANCE_PITCHES pitches."""
    flank, design = "left", table1(DESIGNS["recommended"], Errors(0.05, 1e-4, 0.1, -0.2))
    cycle = mesh_cycle(design, flank)
    samples = first_contact(design, flank, cycle.start + cycle.pitch * np.linspace(0.0, 1.0, 97))
    steepest = np.abs(np.diff(samples.transmission_error)).max() * 96.0  # rad a pitch
    bound = 8.0 * END_TOLERANCE_PITCHES * steepest + OPERATIONS * EPS * 2.0 * np.pi
    seen = seen_otherwise(design, flank)
    for other in seen[:2]:
        found = mesh_cycle(other.design, other.flank)
        assert found.changes.shape == cycle.changes.shape, other.name
        assert np.array_equal(found.hand_over, cycle.hand_over[:: int(other.sign)])
        assert abs(found.peak_to_peak - cycle.peak_to_peak) <= bound, other.name
        assert abs(found.mean - cycle.mean) <= bound, other.name
        assert np.abs(np.abs(found.harmonics) - np.abs(cycle.harmonics)).max() <= bound, other.name
        assert abs(found.edge_share - cycle.edge_share) <= 100.0 * END_TOLERANCE_PITCHES * cycle.changes.size
    swapped = mesh_cycle(exchanged(design), flank)
    assert swapped.changes.shape == cycle.changes.shape
    assert abs(swapped.peak_to_peak * 29.0 / 45.0 - cycle.peak_to_peak) <= bound


def marked(pattern: MemberPattern) -> NDArray[np.bool_]:
    return np.isfinite(pattern.least)


@pytest.mark.slow
def test_contact_patterns(flank: str) -> None:
    """Patterns of equivalent pairs are equal. The pair is unmodified, so that its motion is not interpolated;
    the marking compound is scaled with the pair."""
    design, noise = table1(errors=Errors(0.05, 1e-4, 0.1, -0.2)), OPERATIONS * EPS * 300.0
    pattern = contact_pattern(design, flank, 0.00635, resolution=5.0)
    swapped = Seen("exchanged", exchanged(design), flank, first=1)
    mirror, small, _, large = seen_otherwise(design, flank)
    for seen in (mirror, small, large, swapped):
        k = seen.factor
        other = contact_pattern(seen.design, seen.flank, 0.00635 * k, resolution=5.0 * k)
        members = (other.gear, other.pinion) if seen.first else (other.pinion, other.gear)
        for one, same in zip((pattern.pinion, pattern.gear), members, strict=True):
            assert np.array_equal(one.status, same.status), seen.name
            assert np.array_equal(marked(one), marked(same))
            assert np.nanmax(np.abs(same.least / k - one.least)) <= noise, seen.name
            # The border depends on the root of the separation, which grows across it: the error of the area
            # is the noise over the thickness, times the number of cells across the pattern.
            assert abs(same.area / k**2 - one.area) <= one.least.size * noise / 0.00635 * one.area
