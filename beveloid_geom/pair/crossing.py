"""The angle at which the generators of two flanks cross: how near a flank pair is to line contact.

An unmodified flank is swept by its straight generators, square to its normal n and parallel to the plane
that touches the base cylinder. With v_j the axial component of member j's own normal, the generators of a
pair that is tangent lie along n x (k_1 - ...) and n x (k_2 - ...), so that they cross at

    sin(angle) = n_x sin(d) / sqrt((1 - v_1^2) (1 - v_2^2)),

positive or negative with n_x. 0 is line contact; for crossed helical gears of small shaft angle it is
about d sin(a_n). Literature calls it the angle of first principal directions.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, flank_sign
from ..design.model import Design
from ..gear.rack import rack_of
from .closing import ClosedLayout
from .frames import layout_of, normal_of_unmodified
from .mounting import mounting_of


def crossing_as_mounted(design: Design, flank: str) -> FloatArray:
    """Find the crossing angle (rad, batch shape) of the unmodified flanks of a design as laid out, without
    errors; 0 on parallel axes, NaN without common normal."""
    plain = design.with_parabola(0.0, 0.0)
    layout = layout_of(plain, with_errors=False)
    racks = [rack_of(member, flank) for member in plain.members]
    axial = np.array([rack.normal[2] for rack in racks])
    moment = np.array([rack.pitch_radius * rack.normal[1] for rack in racks])
    branch = mounting_of(plain).branch[0 if flank == "right" else 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        normal_x = branch * np.sqrt(normal_of_unmodified(layout, axial, moment).x_squared)
    return _crossing(normal_x * np.abs(layout.sin_angle), axial[0], axial[1])


def closed_normal(layout: ClosedLayout, flank: str, sense: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find n_x of the common normal and the crossing angle (rad) of a flank pair in a closed layout, whose
    axes lean in the `sense` 1 or -1; arrays of the layout's shape.

    In the working pitch plane, by components across the tooth trace, along it and along N, the axes are
    k_1 = (-sin b_1 cos g_1, cos b_1 cos g_1, -sin g_1), k_2 = (sin b_2 cos g_2, cos b_2 cos g_2, sin g_2)
    and the normal n = (s cos a_w, 0, sin a_w) with s = 1 on the right flank; n_x = -n.(k_1 x k_2)/sin d. On
    parallel axes, where nothing crosses, x leads from axis to pitch point, (N + k_1 sin g_1)/cos g_1."""
    side, aw = flank_sign(flank) * np.cos(layout.pressure_angle), np.sin(layout.pressure_angle)
    sine, cosine = np.sin(layout.cone_angle), np.cos(layout.cone_angle)
    across, along = np.sin(layout.helix_angle) * cosine, np.cos(layout.helix_angle) * cosine
    # Of the cross product, so that it keeps its digits where the helix angles nearly cancel.
    turned = cosine[0] * cosine[1] * np.sin(layout.helix_angle[0] + layout.helix_angle[1])
    product = aw * turned - side * (sine[0] * along[1] + sine[1] * along[0])
    axial = [-side * across[j] - aw * sine[j] for j in (0, 1)]
    square = (aw + axial[0] * sine[0]) / cosine[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        normal_x = np.where(layout.shaft_angle > 0.0, sense * product / np.sin(layout.shaft_angle), square)
    return normal_x, _crossing(sense * product, axial[0], axial[1])


def _crossing(product: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Find the angle from n_x sin(d) and the axial components of both normals."""
    with np.errstate(invalid="ignore"):
        return np.arcsin(product / np.sqrt((1.0 - first * first) * (1.0 - second * second)))
