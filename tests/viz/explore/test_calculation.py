"""Results of the window: equal to the commands, jammed and lost pairs."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, builtin_design, contact_pattern, design_text
from beveloid_geom.operation.cycle.cycle_segments import SAMPLES_PER_PITCH
from beveloid_viz.explore import panels
from beveloid_viz.explore.calculation import Calculation
from beveloid_viz.explore.values import Start
from tests.cli.running import json_of, run, strict_json

ARCSEC = 180.0 * 3600.0 / math.pi


def figures(*stages: dict[str, Any]) -> dict[str, str]:
    return {figure["name"]: figure["text"] for stage in stages for figure in stage["figures"]}


def calculation(design: Design, **values: Any) -> Calculation:
    return Calculation(*Start(design).read(values))


def positions() -> list[Any]:
    """Return ten positions of the sliders, the first for the quick tests."""
    random = np.random.default_rng(33)
    found = []
    for k in range(10):
        values = {
            "offset_error": round(float(random.uniform(0.0, 0.15)), 3),
            "shaft_angle_error_deg": round(float(random.uniform(-0.01, 0.01)), 4),
            "pinion_axial_error": round(float(random.uniform(0.0, 0.3)), 2),
            "pinion.right.parabola": round(float(random.uniform(-0.001, 0.001)), 5),
            "gear.left.parabola": round(float(random.uniform(-0.001, 0.001)), 5),
            "gear.right.helix_crowning_um": float(random.integers(0, 10)),
            "flank": ("right", "left")[k % 2],
            "film": (0.00635, 0.004)[k // 5],
            "torque": 500.0,
        }
        found.append(pytest.param(values, id=str(k), marks=[pytest.mark.slow] if k else []))
    return found


@pytest.mark.parametrize("values", positions())
def test_figures_are_those_of_the_commands(modified: Design, tmp_path: Path, values: dict[str, Any]) -> None:
    shown = calculation(modified, **values)
    found = figures(shown.motion(), shown.pattern(), shown.remarks())
    file = tmp_path / "saved.toml"
    file.write_text(design_text(shown.design))
    given, film = (file, "--flank", values["flank"]), str(values["film"])
    done = run("operation", *given, "--film", film, "--json")
    operation = strict_json(done.stdout)
    pattern = json_of("pattern", *given, "--separation", film)
    path = json_of("tca", *given, "--torque", "500", "--no-certify")
    ratios = operation["operating_contact_ratio"], operation["operating_contact_ratio_within_film"]
    assert done.exit_code == (4 if None in ratios else 0)
    operating, within = ("not known" if ratio is None else f"{ratio:.4f}" for ratio in ratios)
    assert found == {
        "ratio": f"{operation['contact_ratio']:.4f}",
        "operating": operating,
        "film_ratio": within,
        "error": f"{ARCSEC * operation['peak_to_peak']:.3f}",
        "edges": f"{100.0 * operation['edge_share']:.1f}",
        "pinion_pattern": f"{100.0 * pattern['pinion']['area_share']:.1f}",
        "gear_pattern": f"{100.0 * pattern['gear']['area_share']:.1f}",
        "backlash": f"{path['mounted_backlash']['normal']:.4f}",
        "pressure": f"{max(path['hertz']['pressure']):.1f}",
    }


@pytest.mark.parametrize(
    ("values", "status", "words"),
    [
        ({"offset_error": -0.2}, "jammed", "the pair cannot be assembled"),
        ({"offset_error": 12.0, "shaft_angle_error_deg": 3.0}, "no contact", "flanks"),
    ],
)
def test_a_pair_without_picture_has_status_and_reason(
    values: dict[str, Any], status: str, words: str
) -> None:
    found = calculation(builtin_design(), **values).motion()
    assert found["status"] == status
    assert words in found["reason"]


def test_jamming_is_found_even_if_the_backlash_seems_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last stage finds that a pair jams, although the first stage, which checks small backlashes only,
    did not check it."""
    monkeypatch.setattr("beveloid_viz.explore.calculation.SMALL_BACKLASH_MM", -1.0)
    found = calculation(builtin_design(), offset_error=-0.2)
    assert found.motion()["status"] == "solved"
    assert found.remarks()["status"] == "jammed"


def test_a_film_of_zero_has_no_pattern(modified: Design) -> None:
    found = calculation(modified, film=0.0)
    pattern = found.pattern()
    assert (pattern["patterns"], pattern["figures"]) == (None, [])
    assert pattern["view"] == calculation(modified).pattern()["view"]  # the teeth are drawn nevertheless
    assert found.remarks()["status"] == "solved"


@pytest.mark.parametrize("name", ["ni-2017", pytest.param("anti-backlash", marks=pytest.mark.slow)])
def test_curves_and_areas_fit_the_results(name: str) -> None:
    design = builtin_design(name)
    design = design.with_parabola(0.001, -0.001) if name == "ni-2017" else design
    found = calculation(design)
    motion, pattern = found.motion(), found.pattern()
    json.dumps([motion, pattern, found.remarks()], allow_nan=False)
    assert len(motion["graph"]["pitches"]) == len(motion["graph"]["alone"])
    # In operation the pair with the gear furthest ahead is in contact: no curve of a single pair is above it.
    alone = np.array(motion["graph"]["alone"], dtype=float)
    shift, at = SAMPLES_PER_PITCH, np.linspace(0.0, 1.0, SAMPLES_PER_PITCH + 1)
    pairs = np.stack([alone[k * shift : k * shift + shift + 1] for k in range(2 * motion["graph"]["reach"])])
    carried = np.interp(at, np.linspace(0.0, 1.0, 121), motion["graph"]["operation"])
    assert np.nanmax(pairs, axis=0) == pytest.approx(carried, abs=0.02)
    for number, (flank, side) in enumerate(zip(motion["flanks"], pattern["patterns"], strict=True)):
        share = polygons_area(side["bands"][-1]) / polygons_area([flank["outline"]])
        shown = figures(pattern)[("pinion_pattern", "gear_pattern")[number]]
        assert 100.0 * share == pytest.approx(float(shown), abs=1.5)  # of the projected flank
        points = np.reshape(side["patch"]["points"], (*side["patch"]["size"], 3))
        radius = np.hypot(points[..., 0], points[..., 1])
        assert (np.diff(radius, axis=0) > 0.0).all() or (np.diff(radius, axis=0) < 0.0).all()


def polygons_area(rings: list[Any]) -> float:
    """Return the area of polygons with holes; the points of holes are in the opposite order."""
    total = 0.0
    for ring in rings:
        x, y = np.array(ring).T
        total += 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return abs(total)


def test_the_patch_lies_just_outside_the_tooth(modified: Design, flank: str) -> None:
    found = contact_pattern(modified, flank, resolution=1.0)
    shown = panels.pattern_panels(modified, flank, found)
    for member, side, panel in zip(modified.members, (found.pinion, found.gear), shown, strict=True):
        size = panel["patch"]["size"]
        points = np.reshape(panel["patch"]["points"], (*size, 3))[size[0] // 2, size[1] // 2]
        picked = [round((n - 1) * (k // 2) / (k - 1)) for n, k in zip(side.l.shape, size, strict=True)]
        on_flank = side.points[tuple(picked)]
        away = points - on_flank
        lift = panels.LIFT_MODULES * float(member.tool.normal_module)
        assert np.linalg.norm(away) == pytest.approx(lift, rel=0.05)
        # The middle of the tooth is on the x axis at mid-face, so that |y| grows out of the tooth.
        assert on_flank[2] == pytest.approx(0.0, abs=0.6)
        assert away[1] * on_flank[1] > 0.0
