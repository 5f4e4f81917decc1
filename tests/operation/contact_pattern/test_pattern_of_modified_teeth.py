"""The separation of modified flanks in a contact pattern equals the minimum of the distance, computed
independently."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from beveloid_geom import Modification, contact_pattern
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.operation.angular_clearance import axes_of, seen_by_other
from beveloid_geom.operation.contact_pattern.motion import first_contact_operation
from tests.oracle.table1 import table1


def test_least_separation_is_the_distance_from_the_modified_mate(flank: str) -> None:
    design = table1()
    relieved = Modification(helix_crowning_um=10.0, tip_relief_um=15.0, tip_relief_length_mm=2.5)
    pinion, gear = (
        design.pinion.modified(relieved),
        design.gear.modified(Modification(profile_crowning_um=6.0)),
    )
    design = replace(design, pinion=pinion, gear=gear)
    operation, axes = first_contact_operation(design, flank), axes_of(design)
    side = contact_pattern(design, flank, operation=operation).pinion
    assert np.nanmin(side.least) > -1e-9
    for at in ((10, 10), (14, 20), (18, 12)):
        roll = side.pinion_roll[at]
        gear_roll = float(operation.gear_roll(np.array([roll]))[0])
        x, y, z = side.points[at]
        x, y = np.cos(roll) * x - np.sin(roll) * y, np.sin(roll) * x + np.cos(roll) * y
        x, y, z = (float(value) for value in seen_by_other(axes, 0, x, y, z))
        turned = np.array(
            (
                np.cos(gear_roll) * x + np.sin(gear_roll) * y,
                np.cos(gear_roll) * y - np.sin(gear_roll) * x,
                z,
            )
        )

        def apart(place: FloatArray, point: FloatArray = turned) -> FloatArray:
            l, z = place
            return flank_point(gear, flank, l, z=z) - point

        start = (-side.l[at], side.z[at])
        best = least_squares(apart, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        assert abs(np.linalg.norm(best.fun) - side.least[at]) < 1e-9
