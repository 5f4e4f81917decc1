"""Designs that a random search found hard, by explicit numbers, with what once went wrong.

Each is solved now, held against the five equations at 60 digits, and against a search of other code
for contacts that the path might leave out.
"""

from __future__ import annotations

from math import radians
from typing import NamedTuple

import numpy as np
import pytest

from beveloid_geom.arrays import Flank
from beveloid_geom.contact.path import contact_ratio, path_of_contact
from beveloid_geom.design.model import Design, Errors, Member, Pair, Tool
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.reference.five_equations_mp import solve_mp
from beveloid_geom.status import Status

from .five_residuals import batch_of_one, joined, margins, off_path, residuals, search

Numbers = tuple[float, ...]


class Case(NamedTuple):
    """Tool (module, pressure angle, addendum, dedendum, tip radius, parabola) and member (teeth,
    helix, cone, shift, face width); offset, shaft angle, mountings; errors. mm and deg."""

    flank: Flank
    pinion: Numbers
    gear: Numbers
    pair: tuple[float, float, float | None, float | None]
    errors: Numbers

    @property
    def design(self) -> Design:
        def member(module: float, alpha: float, *rest: float) -> Member:
            addendum, dedendum, tip_radius, parabola, teeth, helix, cone, shift, width = rest
            tool = Tool(module, radians(alpha), addendum, dedendum, tip_radius, parabola)
            return Member(tool, teeth, radians(helix), radians(cone), shift, width)

        offset, shaft, *mounting = self.pair
        turned, *axial = self.errors[1:]
        return Design(
            member(*self.pinion),
            member(*self.gear),
            Pair(offset, radians(shaft), *mounting),
            Errors(self.errors[0], radians(turned), *axial),
        )


CASES = {
    "crosses n_x = 0": Case(  # lost
        "right",
        (2.482, 28.2369, 1.0, 1.25, 0.38, 0.00114, 68.0, 18.6373, -1.5569, 0.0, 45.428),
        (2.482, 28.2369, 0.9354, 1.25, 0.38, -0.00309, 55.0, 1.0961, -0.919, -0.271, 21.381),
        (137.237, 16.08848, 279.532, 263.527),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "crosses n_x = 0 while l1 turns back": Case(  # lost
        "right",
        (2.328, 29.3317, 1.0, 1.25, 0.1212, -9.59e-05, 48.0, 33.9498, -0.0447, 0.0, 50.768),
        (2.328, 29.3317, 1.0, 1.25, 0.38, -0.0192, 43.0, 5.0645, 3.1825, 0.0, 30.998),
        (98.815, 35.04632, 103.189, 95.357),
        (0.0, 0.0423, 0.761, 0.0),
    ),
    "two contacts at one l1": Case(  # several contacts
        "right",
        (5.831, 24.2647, 1.0, 1.25, 0.38, -0.000114, 65.0, -8.8714, 1.28, 0.5256, 92.286),
        (5.831, 24.2647, 0.7047, 1.25, 0.38, 0.0154, 37.0, -14.1798, -7.4845, -0.6362, 81.871),
        (291.679, 23.76727, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "l1 turns back, n_x 0.41": Case(  # lost
        "right",
        (2.938, 27.3865, 0.9105, 1.25, 0.38, -1.11e-06, 12.0, 27.81, 0.0, 0.3527, 44.224),
        (2.938, 27.3865, 1.0, 1.25, 0.38, -0.0359, 27.0, 0.0, 0.0, -0.8751, 36.309),
        (57.979, 27.06075, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "l1 turns back, n_x -0.03": Case(  # several contacts
        "right",
        (2.938, 24.0017, 1.0, 1.25, 0.1493, 2.57e-06, 72.0, -4.164, 5.3764, 0.539, 43.17),
        (2.938, 24.0017, 1.0, 1.165, 0.38, 0.000354, 46.0, -23.6886, -19.2577, 0.3024, 45.484),
        (164.429, 30.34639, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "l1 turns back, n_x -0.17": Case(  # several contacts
        "right",
        (7.216, 20.4294, 1.0, 1.25, 0.38, -0.000178, 21.0, 13.9853, -6.6025, 0.08735, 135.17),
        (7.216, 20.4294, 1.0, 1.25, 0.38, 0.00667, 49.0, -33.1288, -4.6369, -0.395, 60.82),
        (244.451, 22.32436, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "l1 turns back under errors": Case(  # several contacts
        "right",
        (2.811, 20.0, 1.304, 1.25, 0.38, 0.000583, 52.0, -28.6276, -0.2892, 0.1655, 54.671),
        (2.811, 20.0, 1.0, 1.258, 0.38, 0.0163, 21.0, 31.8179, 5.917, -0.5976, 33.368),
        (54.5, 6.8, None, None),
        (0.0, 0.0, -2.883, 0.0),
    ),
    "l1 turns back over three pitches": Case(  # several contacts
        "left",
        (4.21, 22.3409, 1.0, 1.25, 0.38, 0.00688, 60.0, 21.473, 0.2506, 0.5022, 45.664),
        (4.21, 22.3409, 1.0, 1.404, 0.38, -0.0303, 63.0, 13.0989, 2.0426, -0.7004, 4.8403),
        (270.469, 34.54378, None, None),
        (-0.421, 0.0, 0.149, 0.0),
    ),
    "close to n_x = 0 all along": Case(  # lost
        "right",
        (4.175, 23.5339, 1.0, 1.121, 0.01137, -0.000736, 36.0, -63.4634, -23.0175, 0.0, 48.299),
        (4.175, 23.5339, 1.0, 1.25, 0.38, 0.0, 17.0, -14.5573, 0.4396, -0.2123, 35.497),
        (200.2, 78.8, None, None),
        (0.144, 0.0, 0.0, 0.182),
    ),
    "two pieces": Case(  # lost
        "left",
        (1.883, 20.0, 0.601, 1.25, 0.38, 0.0291, 72.0, 17.6749, -9.0982, 0.1698, 46.324),
        (1.883, 20.0, 1.0, 1.769, 0.05846, 0.00106, 17.0, 19.813, -7.0974, 0.3879, 11.637),
        (114.491, 40.69329, -48.799, -31.36),
        (-32.144, 0.0495, 0.0, 0.069),
    ),
    "a path of 0.005 pitches": Case(  # lost
        "right",
        (1.943, 20.0, 1.0, 1.25, 0.1256, 0.0, 26.0, -34.382, 6.1065, 0.1469, 5.9078),
        (1.943, 20.0, 0.8344, 1.25, 0.38, 0.012, 62.0, 0.0, -0.0835, -0.1102, 33.346),
        (84.6, 29.44908, -108.274, -76.546),
        (0.0, 0.0, 40.602, 7.456),
    ),
    "a path of 0.0014 pitches under errors": Case(  # lost
        "left",
        (5.18, 20.0, 1.0, 1.797, 0.4463, 0.00053, 21.0, -6.5411, 2.7961, 0.565, 20.063),
        (5.18, 20.0, 1.0, 1.25, 0.38, 4.89e-05, 47.0, -1.6264, -0.3814, -0.9871, 7.9066),
        (165.17, 8.49873, None, None),
        (0.004, 0.0006, -0.667, 0.001),
    ),
    "ends beside a normal that vanishes": Case(  # lost
        "right",
        (6.857, 23.591, 0.5527, 1.25, 0.38, 0.0, 11.0, -8.6338, -0.5665, 0.5344, 10.269),
        (6.857, 23.591, 1.0, 1.25, 0.38, 7.26e-05, 69.0, 6.9083, 0.0155, 0.4952, 46.442),
        (272.635, 1.83504, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "four pitches, not smooth beyond the flank": Case(  # lost
        "right",
        (1.144, 20.0, 1.0, 1.014, 0.38, -0.00235, 74.0, -58.7926, -1.1104, 0.2433, 15.518),
        (1.144, 20.0, 1.051, 1.25, 0.38, 0.0, 16.0, 63.4133, 0.0, -2.374, 20.402),
        (96.485, 4.64553, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "n_x -0.02": Case(  # lost
        "right",
        (3.392, 20.9778, 0.9292, 1.25, 0.38, -7.97e-05, 37.0, 15.1384, -2.5968, 0.5404, 12.546),
        (3.392, 20.9778, 1.0, 1.695, 0.38, -0.00096, 29.0, -34.5135, -2.9524, -1.497, 11.822),
        (114.2, 20.00832, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "next to n_x = 0": Case(  # solved, but to 1.4e-8 mm only
        "right",
        (2.752, 20.0, 0.6224, 1.25, 0.38, -0.00296, 30.0, 0.0, -1.6144, 0.0, 54.62),
        (2.752, 20.0, 1.0, 1.25, 0.38, 8.78e-05, 3.0, 16.5279, 0.1279, -0.3964, 9.7781),
        (42.858, 15.0032, 53.639, 47.652),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "crosses n_x = 0 on most of a pitch": Case(  # solved, but to 1.0e-8 mm only
        "left",
        (3.982, 20.0, 1.274, 1.25, 0.4036, -0.000216, 50.0, -33.9662, 0.1801, 0.0, 63.863),
        (3.982, 20.0, 1.0, 1.25, 0.38, -0.00281, 68.0, -12.0367, 0.0, 0.2746, 88.556),
        (240.192, 43.06826, 150.281, 148.174),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "the other sign of n_x": Case(  # called off the flanks
        "right",
        (0.8458, 20.0, 1.0, 1.077, 0.38, -0.0006, 43.0, 9.7949, 7.6178, -0.2536, 5.0918),
        (0.8323, 17.2622, 1.0, 1.25, 0.38, 0.00157, 56.0, -32.9642, -0.0717, 0.0, 5.6127),
        (43.501, 19.5631, -49.258, -44.381),
        (-0.005, 0.0, 0.0, 0.0),
    ),
    "crosses to the other sign of n_x": Case(  # called without a common normal
        "right",
        (1.512, 15.7846, 0.794, 1.25, 0.38, 0.00315, 20.0, -3.8473, -0.0105, 0.0, 2.6602),
        (1.512, 15.7846, 1.0, 1.25, 0.38, -0.000375, 25.0, 28.9601, 0.1637, -0.2219, 17.491),
        (35.162, 24.10753, 34.475, 25.164),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "the other sign of n_x on a long path": Case(  # called off the flanks
        "left",
        (1.027, 14.5572, 1.0, 1.211, 0.3763, 0.000678, 15.0, 16.3138, -0.6402, -0.3189, 21.174),
        (1.027, 14.5572, 1.0, 1.27, 0.4421, 0.0, 28.0, 24.2085, 0.1192, -0.3386, 27.031),
        (22.946, 39.29728, -9.984, -0.605),
        (0.0, 0.0, 0.0, -3.482),
    ),
    "0.014 mm of the flank, n_x 0.03": Case(  # called without a common normal
        "left",
        (2.58652, 24.9296853, 1.0, 1.25, 0.38, -0.0304065, 35.0, -2.846741, 0.055269, -0.157111, 10.409),
        (2.58652, 24.9296853, 1.0, 1.25, 0.38, -0.000478669, 27.0, 19.743765, -6.734459, 0.00385045, 6.0057),
        (76.02711, 18.11665679, None, None),
        (0.000697, -0.00081038, 0.000839, -0.000118),
    ),
    "n_x 0.000005, pinion unmodified": Case(  # called without a common normal
        "right",
        (5.184516, 23.9426146, 1.0, 1.25, 0.38, 0.0, 29.0, 19.149521, 0.044312, 0.244817, 5.4244),
        (5.184516, 23.9426146, 1.074, 1.25, 0.38, 3.25496e-05, 75.0, 17.873769, 0.647212, 0.0, 17.454),
        (257.41989, 34.03537765, 218.5076, 199.73582),
        (0.0, -0.00626775, 0.0, 0.930317),
    ),
    "n_x -0.00002, pinion unmodified": Case(  # called without a common normal
        "right",
        (5.465027, 20.0, 1.0, 1.25, 0.38, 0.0, 66.0, -32.848033, 2.042186, 0.373756, 28.204),
        (5.465027, 20.0, 1.0, 1.115, 0.3136, 0.000635704, 49.0, 21.748787, -0.098552, 0.0, 35.998),
        (329.47213, 9.47804653, -832.531, -847.89404),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "n_x -0.0002, gear unmodified": Case(  # called without a common normal
        "right",
        (4.963048, 24.2189702, 1.0, 1.25, 0.38, -0.00378816, 69.0, -23.937132, -0.351414, 0.0, 10.877),
        (4.963048, 24.2189702, 0.6001, 1.25, 0.17, 0.0, 75.0, -8.637086, 0.0, -0.305121, 7.9775),
        (338.21209, 29.58764593, -304.66259, -308.12088),
        (0.0, 0.0, 0.53218, 0.000337),
    ),
    "n_x 0.00001, a coefficient of 3e-9": Case(  # called without a common normal
        "right",
        (1.708972, 20.0, 1.0, 1.365, 0.18, 3.31251e-09, 30.0, 0.215854, 0.020071, -0.368765, 3.4568),
        (
            1.715775,
            20.6150687,
            0.5161,
            1.25,
            0.2965,
            0.000104167,
            78.0,
            -20.137064,
            1.270473,
            0.110393,
            2.6389,
        ),
        (85.69279, 18.18312797, -113.1382, -110.62069),
        (4.37338, -0.07133, 0.0, 0.0),
    ),
    "n_x 0.0002": Case(  # called without a common normal
        "right",
        (4.626172, 20.0, 1.0, 1.25, 0.38, 0.0, 61.0, 3.109111, -0.083945, 0.484229, 40.861),
        (4.626172, 20.0, 1.0, 1.25, 0.38, -0.0165237, 74.0, -17.092469, 0.0, 0.0, 27.532),
        (292.05134, 13.41373698, -461.23969, -462.83712),
        (11.0938, 0.0, 0.0, 0.0),
    ),
    "n_x -0.0008": Case(  # called without a common normal
        "left",
        (2.782395, 20.0, 1.0, 1.25, 0.38, -0.0104889, 63.0, 28.423633, 0.034209, 0.0834002, 9.3127),
        (2.782395, 20.0, 1.0, 1.25, 0.38, 0.0, 46.0, -26.739391, 1.05728, 0.441033, 17.979),
        (159.71753, 1.43004192, -2680.62828, -2681.86307),
        (-0.005458, 0.0, 0.0, 0.0),
    ),
    "n_x -0.00002, a coefficient of 2e-6": Case(  # called without a common normal
        "right",
        (1.144192, 20.0, 1.0, 1.25, 0.38, 0.0180879, 79.0, 28.918991, -0.157257, 0.33375, 8.8664),
        (1.144192, 20.0, 0.7168, 1.25, 0.38, 2.03313e-06, 43.0, 1.33504, -0.01425, 0.473515, 23.034),
        (71.03594, 28.35011122, 61.27019, 62.25806),
        (0.0, -0.00428956, 0.0, 0.0),
    ),
}
"""What the designs were said to be stands beside them: lost, off the flanks, or solved too roughly."""

SECOND_PATHS = {
    "far from the first": Case(
        "right",
        (1.444, 20.0, 1.0, 1.25, 0.38, -0.0131, 9.0, -15.5089, 0.2349, -0.1202, 28.486),
        (1.444, 20.0, 1.0, 1.25, 0.38, 0.00248, 5.0, -18.7742, 0.4122, 0.1763, 5.5341),
        (10.631, 34.53086, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
    "of two teeth": Case(
        "left",
        (3.03, 21.2083, 1.292, 1.421, 0.38, 0.0, 2.0, -24.1486, 0.0842, 0.3721, 5.4505),
        (3.03, 21.2083, 1.0, 1.25, 0.2716, -0.000242, 8.0, 3.2234, 0.3625, -0.3752, 21.733),
        (15.448, 20.91664, None, None),
        (0.0, 0.0, 0.0, 0.0),
    ),
}
"""Designs with a second path on the flanks, under normals of the other sign of n_x; it went unseen."""

NO_LAYOUT = Case(
    "right",
    (6.456, 20.0, 1.0, 1.25, 0.38, 0.00332, 13.0, -3.3064, -1.094, 0.06421, 41.827),
    (6.456, 20.0, 1.0, 1.221, 0.38, -0.00043, 15.0, -31.4923, -1.1577, 0.0, 22.677),
    (415.186, 6.96094, None, None),
    (-0.161, 0.0, -2.304, 0.0),
)
"""The unmodified flanks share no normal, so that the mounting asked for does not exist."""


@pytest.mark.parametrize("name", CASES)
def test_is_solved(name: str) -> None:
    case = CASES[name]
    path = path_of_contact(case.design, case.flank, 21)
    assert path.ends.status == Status.SOLVED
    apart, crossed = residuals(case.design, path, mounting_of(case.design).distance)
    assert apart.max() <= 1e-9
    assert crossed.max() <= 1e-12
    assert margins(case.design, path).min() >= -1e-9


@pytest.mark.parametrize("name", CASES)
def test_agrees_with_60_digits(name: str) -> None:
    case = CASES[name]
    design, path = case.design, path_of_contact(case.design, case.flank, 7)
    first, second = mounting_of(design).distance
    for k in (1, 4):
        guess = [float(x[k]) for x in (path.l1, path.u1, path.l2, path.u2, path.pinion_roll, path.gear_roll)]
        # A path across the face in 0.0001 rad of roll: there l1 fixes a contact, and roll does not.
        held = ("l1", guess[0]) if path.ends.contact_ratio < 0.01 else ("phi1", guess[4])
        true = solve_mp(design, case.flank, guess, held, (first, second))
        np.testing.assert_allclose(path.point[k], np.array(true.point, dtype=float), rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(path.normal[k], np.array(true.normal, dtype=float), rtol=0.0, atol=1e-12)
        assert abs(guess[4] - float(true.phi1)) <= 1e-12
        assert abs(guess[5] - float(true.phi2)) <= 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_nothing_is_left_out(name: str) -> None:
    """A search of other code finds contacts on the flanks, and none that is not on the path."""
    case = CASES[name]
    design = batch_of_one(case.design)
    path, distance = path_of_contact(design, case.flank, 401), mounting_of(design).distance
    module = float(case.design.pinion.tool.normal_module)
    found = joined([search(design, case.flank, distance, 96, turned) for turned in (False, True)])
    found = found.beyond(1e-6 * module)
    if path.ends.pieces[0] == 1:
        assert off_path(path, found).max(initial=0.0) <= 2e-3 * module
    if path.ends.contact_ratio[0] > 0.1:
        assert found.case.size > 0


@pytest.mark.parametrize("name", SECOND_PATHS)
def test_a_second_path_of_the_other_sign_is_counted(name: str) -> None:
    """The one that covers most roll is taken, the other is a piece of it."""
    case = SECOND_PATHS[name]
    design = batch_of_one(case.design)
    path, distance = path_of_contact(design, case.flank, 401), mounting_of(design).distance
    found = joined([search(design, case.flank, distance, 96, turned) for turned in (False, True)])
    assert path.ends.status[0] == Status.SOLVED
    assert path.ends.pieces[0] == 2
    assert off_path(path, found).max() > 0.01 * float(case.design.pinion.tool.normal_module)


@pytest.mark.parametrize("flank", ["right", "left"])
def test_without_a_layout_nothing_is_said(flank: Flank) -> None:
    path = path_of_contact(NO_LAYOUT.design, flank)
    assert path.ends.status == Status.UNDEFINED
    assert np.isnan(contact_ratio(NO_LAYOUT.design, flank))
    assert path.point.size == 0
