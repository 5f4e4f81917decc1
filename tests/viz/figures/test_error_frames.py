"""Fig. 5: the frames of the paper agree with the mounting of the library."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, Errors, builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import Frame
from beveloid_viz.components import posed
from beveloid_viz.figures.paper import fig_05_errors as fig
from beveloid_viz.rendering.layout import of_size

from ...symmetry import mirrored
from ..pages import recipe_of

ERRORS = Errors(offset=1.7, shaft_angle=0.03, pinion_axial=0.9, gear_axial=-1.3)
DESIGNS = [builtin_design(), mirrored(builtin_design())]


def matrix(frame: Frame) -> FloatArray:
    """Return a frame as a matrix (4, 4)."""
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = frame
    return whole


@pytest.mark.parametrize("design", DESIGNS)
def test_the_pair_is_the_librarys(design: Design) -> None:
    """Under all four errors, the gear relative to the pinion is that of `pair.frames`, which turns the gear
    axis instead of the pinion axis."""
    plain, moved = replace(design, errors=Errors()), design.with_errors(ERRORS)
    distance = posed.placed(plain, np.zeros(2)).position
    own = fig.paper_frames(moved, distance)
    first, second = (matrix(frame) for frame in posed.placed(moved, np.zeros(2)).frames)
    found = np.linalg.inv(matrix(own["d1"])) @ matrix(own["d2"])
    np.testing.assert_allclose(found, np.linalg.inv(first) @ second, rtol=0.0, atol=1e-11)
    np.testing.assert_array_equal(matrix(own["f"]), np.eye(4))


def test_each_error_lies_between_its_two_frames() -> None:
    data = fig.compute(builtin_design())
    for panel, size, moved in zip(fig.PANELS, data.drawn, data.displaced, strict=True):
        (turn, start), (turned, end) = data.nominal[panel.before], moved[panel.after]
        if panel.key == "shaft_angle":
            np.testing.assert_array_equal(start, end)
            assert turn[:, 2] @ turned[:, 2] == pytest.approx(np.cos(size), abs=1e-14)
            np.testing.assert_array_equal(turn[:, 0], turned[:, 0])
            gear = data.nominal["g"][0][:, 2]
            assert turned[:, 2] @ gear < turn[:, 2] @ gear  # the shaft angle grows
            continue
        np.testing.assert_array_equal(turn, turned)
        way = turn[:, 2] if panel.key != "offset" else np.array([1.0, 0.0, 0.0])
        np.testing.assert_allclose(end - start, size * way, rtol=0.0, atol=1e-12)


def test_all_panels_have_one_direction_and_one_scale() -> None:
    """All panels have the same direction of view and scale. Each shows both members completely, and the
    largest picture fills its panel."""
    drawing = recipe_of("fig-05").drawn(fig.compute(builtin_design()), of_size((400, 300)))
    pictures = list(drawing.pictures.values())
    assert len(pictures) == 4
    free = []
    for picture in pictures:
        for name in ("direction", "up", "half_height"):
            first, own = (getattr(one.camera, name) for one in (pictures[0], picture))
            np.testing.assert_array_equal(own, first)
        seen = (picture.image != 255).any(axis=-1)
        room = np.concatenate([np.flatnonzero(seen.any(axis=axis))[[0, -1]] for axis in (0, 1)])
        assert (np.array([room[0], room[2]]) > 0).all()
        assert (np.array([room[1], room[3]]) < np.array(seen.shape)[::-1] - 1).all()
        free.append(1.0 - (room[[1, 3]] - room[[0, 2]] + 1.0) / np.array(seen.shape)[::-1])
    assert 0.05 < np.min(free) < 0.1  # a margin of 0.04 on either side
