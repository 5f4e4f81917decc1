"""The picture of the pair, compared with a depth buffer of the true tooth surfaces."""

from __future__ import annotations

import re
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from beveloid_geom import Design, Pair, builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import frames_at
from beveloid_geom.operation.engagement import conjugate_phase
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.surface_mesh import gear_mesh
from beveloid_viz.report.picture import EYE, SHADE_COUNT, pair_picture

PIXELS = 240
"""Width of the compared pictures."""
FINE = 12
"""Points along a side of a triangle."""
TABLE = builtin_design()
MEMBERS = [replace(member, helix_angle=radians(45.0), cone_angle=0.0) for member in TABLE.members]
STEEP = Design(MEMBERS[0], MEMBERS[1], Pair(320.0, radians(90.0)))
"""Perpendicular axes: one gear is in front of the end face of the other."""


def painted(svg: str) -> NDArray[np.int8]:
    """Return the member (1, 2) at each pixel, 0 for none, with later polygons in front."""
    width, height = (int(size) for size in re.findall(r'viewBox="0 0 (\d+) (\d+)"', svg)[0])
    assert width == 3000
    board = Image.new("L", (PIXELS, round(PIXELS * height / width)))
    pen = ImageDraw.Draw(board)
    for letter, way in re.findall(r'<path class="([pg])\d" d="([^"]*)"/>', svg):
        for polygon in way.split("z")[:-1]:
            steps = np.array([int(number) for number in re.findall(r"-?\d+", polygon)]).reshape(-1, 2)
            corners = np.cumsum(steps, axis=0) * PIXELS / width
            pen.polygon([tuple(corner) for corner in corners.tolist()], fill=1 + "pg".index(letter))
    return np.asarray(board).astype(np.int8)


def seen(design: Design) -> NDArray[np.int8]:
    """Return the member (1, 2) at each pixel, 0 for none, from points on the true surfaces; the nearest point
    counts."""
    phase = float(np.nan_to_num(conjugate_phase(design, "right")))
    share = np.array([(i, j, FINE - i - j) for i in range(FINE + 1) for j in range(FINE + 1 - i)]) / FINE
    clouds, corners = [], []
    for member, frame in zip(design.members, frames_at(design, 0.0, phase), strict=True):
        mesh = gear_mesh(member, 0.1 * float(member.tool.normal_module))
        points: FloatArray = to_fixed(frame, mesh.points) @ EYE.T
        corners.append(points[:, :2])
        clouds.append((share @ points[mesh.faces]).reshape(-1, 3))
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    scale = PIXELS / (high - low)[0]
    rows = round(scale * (high - low)[1])
    board, depth = np.zeros(rows * PIXELS, np.int8), np.full(rows * PIXELS, -np.inf)
    for number, cloud in enumerate(clouds):
        column, row = np.floor((cloud[:, :2] - (low[0], high[1])) * (scale, -scale)).astype(int).T
        place = np.clip(row, 0, rows - 1) * PIXELS + np.clip(column, 0, PIXELS - 1)
        nearest = np.full_like(depth, -np.inf)
        np.maximum.at(nearest, place, cloud[:, 2])
        board[nearest > depth] = number + 1
        depth = np.maximum(depth, nearest)
    return board.reshape(rows, PIXELS)


@pytest.mark.parametrize("design", [TABLE, STEEP], ids=["table 1", "right angle"])
def test_picture_agrees_with_a_depth_buffer(design: Design) -> None:
    """The picture agrees with a depth buffer, except at outlines and in a small part where the teeth mesh."""
    found, true = painted(pair_picture(design)), seen(design)
    rows = min(len(found), len(true))
    assert abs(len(found) - len(true)) <= 1
    inner = np.zeros((rows, PIXELS), bool)  # away from outlines, which are a pixel wide
    same = [true[i : rows - 2 + i, j : PIXELS - 2 + j] for i in range(3) for j in range(3)]
    inner[1:-1, 1:-1] = (np.stack(same) == true[1 : rows - 1, 1:-1]).all(axis=0)
    assert inner.mean() > 0.8
    assert (found[:rows] == true[:rows])[inner].mean() > 0.995
    for member in (1, 2):
        assert (true == member).mean() > 0.1


def test_a_member_without_teeth_is_a_blank_and_no_layout_no_picture() -> None:
    pointed = replace(TABLE.pinion, profile_shift=1.5, tool=replace(TABLE.pinion.tool, addendum=1.6))
    blank, whole = (pair_picture(design) for design in (replace(TABLE, pinion=pointed), TABLE))
    assert 20_000 < len(blank) < len(whole)
    assert all(int(shade) < SHADE_COUNT for shade in re.findall('class="[pg](.)"', whole))
    assert pair_picture(replace(TABLE, pair=Pair(229.0, radians(1.0)))) == ""
