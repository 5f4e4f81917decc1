"""The angle between the generators of two flanks, a measure of the distance from line contact.

An unmodified flank is swept by straight generators, perpendicular to its normal n and parallel to the plane
that is tangent to the base cylinder. With the axial component v_j of the normal of member j, the generators
of two flanks in contact have the directions k_1 - v_1 n and k_2 + v_2 n, and their angle is

    sin(angle) = n_x sin(d) / sqrt((1 - v_1^2) (1 - v_2^2)).

It has the sign of n_x and is 0 in line contact. For crossed helical gears of small shaft angle it is about
d sin(a_n) / cos^2(b_b), with the base helix angle b_b. The literature calls it the angle of first principal
directions (FPD).
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, flank_sign
from ..design.model import Design
from .frames import layout_of
from .mounting import mounting_of, normal_of_flanks
from .zero_backlash import ZeroBacklashLayout


def generator_angle_as_mounted(design: Design, flank: str) -> FloatArray:
    """Return the angle between the generators of the unmodified flanks in the layout without errors.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}

    Returns
    -------
    ndarray
        rad, of the batch shape; 0 on parallel axes, NaN without a common normal.
    """
    normal_x, axial = normal_x_as_mounted(design, flank)
    sine = np.abs(layout_of(design, with_errors=False).sin_angle)
    return _crossing(normal_x * sine, axial[0], axial[1])


def normal_x_as_mounted(design: Design, flank: str) -> tuple[FloatArray, FloatArray]:
    """Return n_x (batch shape) of the common normal of the unmodified flanks in the layout without errors,
    and the axial components (2, ...) of the normals of both members. NaN without a common normal.
    """
    plain = design.unmodified()
    layout = layout_of(plain, with_errors=False)
    # The sign of n_x is a property of the layout.
    branch = mounting_of(plain).branch[0 if flank == "right" else 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        normal, axial = normal_of_flanks(layout, plain.members, flank)
        return np.asarray(branch * np.sqrt(normal.x_squared)), axial


def closed_normal(layout: ZeroBacklashLayout, flank: str, sense: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return n_x of the common normal and the angle between the generators, in a closed layout.

    Closed layouts, N and the working angles a_w, b_j = b_w and g_j = g_w are explained in `zero_backlash`. In
    the working pitch plane, by components across the tooth trace, along it and along N, the axes are
    k_1 = (-sin b_1 cos g_1, cos b_1 cos g_1, -sin g_1), k_2 = (sin b_2 cos g_2, cos b_2 cos g_2, sin g_2) and
    the normal is n = (s cos a_w, 0, sin a_w) with s = 1 on the right flank; n_x = -n.(k_1 x k_2)/sin d. On
    parallel axes x points from the axis to the pitch point, x = (N + k_1 sin g_1)/cos g_1.

    Parameters
    ----------
    layout : ZeroBacklashLayout
        Closed layout, with or without backlash, single or a batch.
    flank : {'right', 'left'}
    sense : ndarray
        Sense of the axes, 1 or -1.

    Returns
    -------
    n_x : ndarray
        Component of the common normal along the common perpendicular, shape of the layout.
    angle : ndarray
        Angle between the generators, rad.
    """
    side, aw = flank_sign(flank) * np.cos(layout.pressure_angle), np.sin(layout.pressure_angle)
    sine, cosine = np.sin(layout.cone_angle), np.cos(layout.cone_angle)
    across, along = np.sin(layout.helix_angle) * cosine, np.cos(layout.helix_angle) * cosine
    # Cross product of the axes in a form that keeps its digits if the helix angles nearly cancel.
    turned = cosine[0] * cosine[1] * np.sin(layout.helix_angle[0] + layout.helix_angle[1])
    product = aw * turned - side * (sine[0] * along[1] + sine[1] * along[0])
    axial = [-side * across[j] - aw * sine[j] for j in (0, 1)]
    square = (aw + axial[0] * sine[0]) / cosine[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        normal_x = np.where(layout.shaft_angle > 0.0, sense * product / np.sin(layout.shaft_angle), square)
    return normal_x, _crossing(sense * product, axial[0], axial[1])


def _crossing(product: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the angle from n_x sin(d) and the axial components of both normals."""
    with np.errstate(invalid="ignore"):
        return np.arcsin(product / np.sqrt((1.0 - first * first) * (1.0 - second * second)))
