"""Optimised amounts compared with brute force; crownings checked by computing the contact of the result."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import (
    Aim,
    Design,
    Errors,
    Modification,
    builtin_design,
    contact_pattern,
    fit_crowning,
    mesh_cycle,
    optimise_amounts,
    path_of_contact,
)
from beveloid_geom.operation.contact_pattern.pattern import MemberPattern
from tests.oracle.table1 import table1
from tests.stability.parallel_pairs import HELICAL, pair_of

SPUR = pair_of(3.0, (25, 50), 0.0, 112.5)
AIM = Aim(Errors(shaft_angle=np.radians(0.01)), contact_ratio=1.4, edges=False, off_centre=5.0)
HELIX, PROFILE = "pinion.helix_crowning_um", "pinion.profile_crowning_um"
TIP = "pinion.tip_relief_um"


def crowned(design: Design, helix: float, profile: float = 0.0) -> Design:
    given = Modification(helix_crowning_um=helix, profile_crowning_um=profile)
    return replace(design, pinion=design.pinion.modified(given, "right"))


def extent(side: MemberPattern) -> float:
    """Return the extent of a pattern along the face by its marked grid points, mm."""
    return float(np.ptp(side.z[side.marked]))


@pytest.mark.slow
def test_least_transmission_error_within_a_shift() -> None:
    """At the optimum the shift equals its limit. No amounts on a grid have a smaller transmission error
    within this limit. Both are computed from single paths of contact and mesh cycles."""
    aim = replace(AIM, least="transmission_error", shift=4.0)
    found = optimise_amounts(table1(), aim, {HELIX: (0.0, 30.0), PROFILE: (0.0, 10.0)})
    assert found.at_limits == ()
    assert found.design == crowned(table1(), found.amounts[HELIX], found.amounts[PROFILE])
    angles = [np.radians(angle) for angle in (0.0, 0.01, -0.01)]

    def shift(design: Design) -> float:
        """Return the shift perpendicular to the path, root mean square of both directions."""
        path, *moved = (
            path_of_contact(design.with_errors(Errors(shaft_angle=angle)), "right", 17) for angle in angles
        )
        along = np.array((path.pinion_z[9] - path.pinion_z[7], path.l1[9] - path.l1[7]))
        along /= np.hypot(*along)
        steps = [np.array((one.pinion_z[8] - path.pinion_z[8], one.l1[8] - path.l1[8])) for one in moved]
        return float(np.sqrt(0.5 * sum((dx * along[1] - dy * along[0]) ** 2 for dx, dy in steps)))

    def error(design: Design) -> tuple[float, float]:
        """Return the largest transmission error and the largest share on edges in all mountings."""
        cycles = [mesh_cycle(design.with_errors(Errors(shaft_angle=angle)), "right", 1) for angle in angles]
        return max(float(c.peak_to_peak) for c in cycles), max(float(c.edge_share) for c in cycles)

    best, edges = error(found.design)
    assert edges == 0.0
    assert shift(found.design) == pytest.approx(4.0, abs=1e-4)
    for helix in np.linspace(4.0, 28.0, 4).tolist():
        for profile in (0.6, 1.2, 2.0):
            other = crowned(table1(), helix, profile)
            size, edges = error(other)
            assert size > best - 1e-9 or edges > 0.0 or shift(other) > 4.0


@pytest.mark.slow
def test_reliefs_with_a_given_length() -> None:
    """No amount of a scan has a smaller transmission error without edge contact. The errors are computed from
    single mesh cycles."""
    relieved = Modification(helix_crowning_um=15.0, profile_crowning_um=2.0, tip_relief_length_mm=6.0)
    design = replace(table1(), pinion=table1().pinion.modified(relieved))
    aim = replace(AIM, least="transmission_error", contact_ratio=1.2)
    found = optimise_amounts(design, aim, {TIP: (-4.0, 8.0)})

    def error(amount: float) -> float:
        """Return the largest transmission error in all mountings, infinite with edge contact."""
        other = replace(design, pinion=design.pinion.modified(replace(relieved, tip_relief_um=amount)))
        cycles = [
            mesh_cycle(other.with_errors(Errors(shaft_angle=np.radians(angle))), "right", 1)
            for angle in (0.0, 0.01, -0.01)
        ]
        on_edge = any(float(cycle.edge_share) > 0.0 for cycle in cycles)
        return np.inf if on_edge else max(float(cycle.peak_to_peak) for cycle in cycles)

    best = error(found.amounts[TIP])
    scan = [error(amount) for amount in np.linspace(-4.0, 8.0, 7)]
    assert np.isfinite(best)
    assert best < min(scan) + 1e-9 < max(scan)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "flank", "member", "arcsec", "length"),
    [
        (builtin_design(), "right", "pinion", 2.0, 25.0),
        (builtin_design(), "left", "gear", 4.0, 12.0),
        (SPUR, "right", "pinion", 6.0, 12.0),
        (HELICAL, "right", "pinion", 6.0, 12.0),
    ],
    ids=["table 1", "table 1, left flank of the gear", "spur", "helical"],
)
def test_crownings_give_the_required_contact(
    design: Design, flank: str, member: str, arcsec: float, length: float
) -> None:
    found = fit_crowning(design, np.radians(arcsec / 3600.0), length, flank, member=member)
    cycle = mesh_cycle(found.design, flank, 1)
    assert float(cycle.peak_to_peak) == pytest.approx(np.radians(arcsec / 3600.0), rel=0.002)
    pattern = contact_pattern(found.design, flank, resolution=0.1)
    assert extent(getattr(pattern, member)) == pytest.approx(length, rel=0.02)
    if design is SPUR:  # the normal is the base tangent, and the pattern ends where the depth is the compound
        assert found.helix_crowning_um == pytest.approx(6.35 * (30.0 / length) ** 2, rel=0.005)
    other = {"pinion": "gear", "gear": "pinion"}[member]
    assert getattr(found.design, other) == getattr(design, other)


@pytest.mark.slow
def test_no_solution_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"^no crownings give a transmission error of 0\.01 arcsec [^\n]*$"):
        fit_crowning(table1(), np.radians(0.01 / 3600.0), 20.0)


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({}, "bounds must have 1 to 6 amounts, got 0"),
        (
            {"pinion.tip_relief_length_mm": (0.0, 1.0)},
            "pinion.tip_relief_length_mm is not an amount that can",
        ),
        (
            {TIP: (0.0, 1.0)},
            "^pinion.tip_relief_um can vary only if its length is given: write tip_relief_um = 0.0 and"
            r" tip_relief_length_mm in \[pinion.modification\]$",
        ),
        ({HELIX: (3.0, 3.0)}, "must be two numbers, lower one first"),
        ({HELIX: (0.0, np.inf)}, "must be two numbers, lower one first"),
    ],
)
def test_refused_bounds(bounds: dict[str, tuple[float, float]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        optimise_amounts(table1(), AIM, bounds)


@pytest.mark.slow
def test_no_amounts_within_the_constraints() -> None:
    with pytest.raises(ValueError, match=r"the contact ratio is 1\.6.., less than 3:"):
        optimise_amounts(table1(), replace(AIM, contact_ratio=3.0), {HELIX: (0.0, 3.0)})
