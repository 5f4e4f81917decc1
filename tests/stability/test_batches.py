"""Batches of designs: each case has the result of the single design; a case without a result is NaN and
affects no other case."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    Modification,
    first_contact,
    mesh_cycle,
    mounted_backlash,
    path_certificate,
    path_of_contact,
    path_sensitivity,
    path_sliding,
)
from beveloid_geom.analysis.pressure import Load, path_pressure
from beveloid_geom.analysis.sliding import least_sliding
from beveloid_geom.contact.ellipse import contact_ellipse
from beveloid_geom.contact.rounding import rounding_error
from beveloid_geom.design.member import unchecked
from beveloid_geom.operation.backlash_by_tangency import tangent_backlash
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.operation.operating_ratio import operating_ratio
from tests.contact.test_path import NUMBERS
from tests.oracle.table1 import table1

from .answers import changed
from .five_residuals import mapped
from .parallel_pairs import pair_of

MODIFIED = table1((0.001, -0.001))
OFFSET = np.array([[-0.4, 0.0, 40.0], [0.3, np.nan, 0.1]])
BENT = table1().with_parabola(np.array([[0.001], [-0.0005]]), -0.0005)
"""Members and mountings; of two cases one leaves the faces, one has no layout."""
BENT = BENT.with_errors(unchecked(Errors(), offset=OFFSET))
TURNED = MODIFIED.with_errors(Errors(np.array([[-0.2], [0.1]]), np.radians([0.0, 0.01, -0.02])))
"""Mountings only."""
MANY = MODIFIED.with_errors(Errors(np.linspace(-0.4, 0.4, 259)))
"""More cases than a block of `path_sensitivity`."""
APART = MODIFIED.with_errors(Errors(np.array([0.2, -5.0])))
"""In the second case tips touch bottom lands."""
FLAT = table1(errors=Errors(offset=np.array([-0.2, 0.0, 0.1])))
APEX = {"parabola_right": np.array([8e-4, -3e-4]), "parabola_apex": np.array([2.0, -1.0])}
BY_FLANK = replace(table1(), pinion=changed(table1().pinion, **APEX))
CROWNED = replace(TURNED, pinion=MODIFIED.pinion.modified(Modification(helix_crowning_um=10.0)))
CROWNINGS = Modification(helix_crowning_um=np.array([[5.0], [10.0]]))
CROWNINGS_AND_TOOLS = replace(table1(), pinion=table1().pinion.modified(CROWNINGS)).with_parabola(
    np.array([0.0, 0.0005, 0.001])
)
PARALLEL = pair_of(3.0, (25, 31), 15.0, 87.3, cone_deg=3.0).with_errors(
    Errors(offset=np.array([0.0, 0.05, 0.0, 0.0]), shaft_angle=np.radians([0.0, 0.0, 1e-4, 0.05]))
)
"""Lines of contact, and tilted axes."""
RELIEF = Modification(tip_relief_um=10.0, tip_relief_length_mm=1.0)
RELIEVED = pair_of(2.0, (20, 35), 0.0, 55.1).with_errors(
    Errors(offset=np.array([0.0, 0.02, 0.0, -0.01]), shaft_angle=np.array([0.0, 0.0, 2e-5, 0.0]))
)
RELIEVED = replace(RELIEVED, pinion=RELIEVED.pinion.modified(RELIEF))
"""Two of the cases touch along lines."""
VALUES = ("l", "z", "r", "pinion_roll", "contact_ratio", "peak_to_peak")
RATES = " ".join((*VALUES, *(f"{name}_by" for name in VALUES), "face_shift_by square_shift_by status limit"))
SLID = "specific specific_total profile lengthwise speed gear_rate sliding rolling contact_velocity"
ROLL = float(pitch_point_roll(table1(), "right")) + 2.0 * np.pi / 29.0 * (np.arange(4) + 0.3) / 4


def path(design: Design, points: int) -> ContactPath:
    return path_of_contact(design, points=points)


def least(design: Design) -> SimpleNamespace:
    return SimpleNamespace(speed=least_sliding(path_sliding(path(design, 7)))[1])


def ratio(design: Design) -> SimpleNamespace:
    return SimpleNamespace(ratio=operating_ratio(design, "right", 0.002))


def rounding(design: Design) -> SimpleNamespace:
    return SimpleNamespace(moved=rounding_error(path(design, 4)))


ANSWERS: dict[str, tuple[Design, Callable[[Design], Any], str, float, float]] = {
    "path": (BENT, lambda d: path(d, 7), " ".join((*NUMBERS, "status")), 0.0, 1e-10),
    "many paths": (MANY, lambda d: path(d, 3), "point", 0.0, 1e-10),
    "ends": (BENT, lambda d: path(d, 2).ends, "contact_ratio status", 0.0, 1e-10),
    "sensitivity": (BENT, path_sensitivity, RATES, 1e-8, 1e-10),
    "many sensitivities": (MANY, path_sensitivity, "z_by contact_ratio peak_to_peak_by limit", 1e-8, 1e-10),
    "sliding": (BENT, lambda d: path_sliding(path(d, 7)), SLID, 0.0, 1e-8),
    "least sliding": (BENT, least, "speed", 0.0, 1e-9),
    "ellipse": (BENT, lambda d: contact_ellipse(path(d, 3)), "semi_axes status", 1e-9, 0.0),
    "pressure": (
        BENT,
        lambda d: path_pressure(path(d, 5), Load(force=1e4)),
        "force pressure semi_axes angle reaches status",
        1e-7,
        1e-9,
    ),
    "effect of rounding": (FLAT, rounding, "moved", 1e-3, 0.0),
    "parabolas by flank": (BY_FLANK, lambda d: path(d, 5), "point", 0.0, 1e-10),
    "crowning": (CROWNED, lambda d: path(d, 7), "l1 l2 point gear_roll", 0.0, 1e-9),
    "crownings and tools": (CROWNINGS_AND_TOOLS, lambda d: path(d, 7), "point", 0.0, 1e-9),
    "parallel axes": (PARALLEL, lambda d: path(d, 4), "point", 0.0, 1e-10),
    "relieved, on parallel axes": (RELIEVED, lambda d: path(d, 9).ends, "contact_ratio status", 0.0, 1e-9),
    "certificate": (TURNED, lambda d: path_certificate(path(d, 11)), "verdict separation", 0.0, 1e-11),
    "first contact": (TURNED, lambda d: first_contact(d, "right", ROLL), "gear_roll limit pair", 0.0, 1e-13),
    "cycle": (APART, lambda d: mesh_cycle(d, "right", 4), "changes harmonics mean lost", 1e-9, 1e-10),
    "operating ratio": (APART, ratio, "ratio", 0.0, 1e-9),
    "backlash": (FLAT.with_parabola(-0.0005, -0.0005), mounted_backlash, "normal jammed", 0.0, 1e-10),
    "tangent backlash": (FLAT, tangent_backlash, "normal status", 0.0, 1e-10),
    "that of bent flanks": (FLAT.with_parabola(-5e-4, -5e-4), tangent_backlash, "normal status", 0.0, 1e-10),
}


def alone(design: Design, index: tuple[int, ...]) -> Design:
    """Return a case of a batch as a single design."""

    def of(value: Any) -> float:
        return float(np.broadcast_to(value, design.batch_shape)[index])

    errors = unchecked(Errors(), **{name: of(value) for name, value in vars(design.errors).items()})
    return Design(mapped(of, design.pinion), mapped(of, design.gear), design.pair, errors)


@pytest.mark.parametrize("name", ANSWERS)
def test_a_batch_equals_its_single_designs(name: str) -> None:
    design, of, names, relative, absolute = ANSWERS[name]
    batch, shape = of(design), design.batch_shape
    cases = list(np.ndindex(shape))
    for index in cases if len(cases) < 9 else [cases[k] for k in (0, 255, 256, -4, -3, -1)]:
        single = of(alone(design, index))
        for field in names.split():
            ours, expected = np.asarray(getattr(batch, field))[index], np.asarray(getattr(single, field))
            if expected.size:
                scale = absolute * (np.abs(np.nan_to_num(expected)).max() if relative else 1.0)
                np.testing.assert_allclose(ours, expected, rtol=relative, atol=scale, err_msg=field)
            elif ours.dtype.kind == "f":
                assert np.isnan(ours).all(), field
