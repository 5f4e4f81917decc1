"""Transmission error with pitch deviations: steps, mating teeth, and design files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    DesignError,
    FlankDeviations,
    Member,
    Modification,
    builtin_design,
    design_text,
    first_contact,
    measuring_grid,
    mesh_cycle,
    pitch_cycle,
    read_design,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import base_cylinder
from tests.cli.running import refused, run, strict_json
from tests.oracle.table1 import table1


def with_pitch(design: Design, pinion: FloatArray | None = None, gear: FloatArray | None = None) -> Design:
    members = {
        name: getattr(design, name).modified(Modification(pitch_deviations_um=tuple(values.tolist())))
        for name, values in (("pinion", pinion), ("gear", gear))
        if values is not None
    }
    return replace(design, **members)


def one_tooth(count: int, tooth: int, amount: float) -> FloatArray:
    values = np.zeros(count)
    values[tooth] = amount
    return values


def displaced(member: Member, amount: float) -> Member:
    """Return a member with the excess material `amount`, um, on all its flanks."""
    grid = measuring_grid(member, 2, 2)
    z = np.broadcast_to(grid.point[..., 2], grid.l.shape)
    return member.modified(Modification(deviations=FlankDeviations(grid.l, z, np.full_like(grid.l, amount))))


@pytest.mark.parametrize("name", ["pinion", "gear"])
def test_the_error_steps_by_the_deviation_of_a_tooth(name: str, flank: str) -> None:
    design, count, amount = table1(), {"pinion": 29, "gear": 45}[name], 6.0
    cycle = pitch_cycle(with_pitch(design, **{name: one_tooth(count, 3, amount)}), flank)
    base = base_cylinder(design.gear, flank)
    step = 1e-3 * amount / float(base.radius * np.cos(base.helix_angle))
    assert cycle.transmission_error.shape == (count, 24)
    assert cycle.peak_to_peak == pytest.approx(step, abs=1e-9)
    # The tooth carries alone over the contact ratio of a pair, and edges of its mate before and after.
    carries = (cycle.pinion_tooth if name == "pinion" else cycle.gear_tooth) == 3
    whole = np.abs(cycle.transmission_error - step) < 1e-9
    assert 1.6 < whole.mean() * count < 1.7
    assert carries[whole].all()
    rest = np.abs(cycle.transmission_error) < 1e-9
    assert rest.mean() * count > count - 2.5
    assert carries[~rest].all()


def test_without_deviations_it_is_the_mesh_cycle(flank: str) -> None:
    design = table1((0.001, -0.001))
    cycle = pitch_cycle(design, flank, 7)
    assert cycle.pitches == 1
    expected = mesh_cycle(design, flank).at(cycle.pinion_roll[0]).transmission_error
    assert np.abs(cycle.transmission_error - expected).max() < 1e-11


@pytest.mark.parametrize(("pitch", "flank"), [(0, "right"), (700, "left")])
def test_the_mating_teeth_are_displaced_flanks(pitch: int, flank: str) -> None:
    """Compare with first contacts of single tooth pairs of designs whose flanks have the deviations."""
    plain, rng = table1((0.001, -0.001)), np.random.default_rng(pitch)
    amounts = rng.uniform(-9.0, 9.0, 29), rng.uniform(-9.0, 9.0, 45)
    cycle = pitch_cycle(with_pitch(plain, *amounts), flank, 1)
    assert cycle.pitches == 29 * 45
    roll = cycle.pinion_roll[pitch, 0]
    errors = {}
    for pair in range(-pitch - 1, -pitch + 2):
        teeth = pair % 29, -pair % 45
        members = [displaced(m, a[k]) for m, a, k in zip(plain.members, amounts, teeth, strict=True)]
        design = replace(plain, pinion=members[0], gear=members[1])
        first = first_contact(design, flank, [roll], (pair,))
        errors[teeth] = float(np.nan_to_num(first.transmission_error[0], nan=-np.inf))
    best = max(errors, key=errors.__getitem__)
    assert cycle.transmission_error[pitch, 0] == pytest.approx(errors[best], abs=1e-11)
    assert (cycle.pinion_tooth[pitch, 0], cycle.gear_tooth[pitch, 0]) == best


def test_periods_and_limits() -> None:
    design, amounts = table1(), (np.arange(29.0), np.arange(45.0))
    assert pitch_cycle(with_pitch(design, None, amounts[1]), points=1).pitches == 45
    assert pitch_cycle(with_pitch(design, 0.0 * amounts[0], amounts[1]), points=1).pitches == 45
    equal = builtin_design("awd-transfer")
    assert pitch_cycle(with_pitch(equal, np.arange(37.0), np.arange(37.0)), points=1).pitches == 37
    wide = with_pitch(
        replace(design, pinion=replace(design.pinion, teeth=199), gear=replace(design.gear, teeth=211)),
        np.ones(199),
        np.ones(211),
    )
    with pytest.raises(ValueError, match="within 20000 pitches, got 41989: give the pitch deviations of"):
        pitch_cycle(wide)
    with pytest.raises(ValueError, match="points must be at least 1, got 0"):
        pitch_cycle(design, points=0)
    with pytest.raises(ValueError, match=r"design must be a single one, got arrays of shape \(2,\)"):
        pitch_cycle(design.with_parabola(np.zeros(2)))
    for values, message in (
        ((1.0, 2.0), "modification_right.pitch_deviations_um must have one value for each tooth, 29, got 2"),
        (
            one_tooth(29, 4, -1500.0),
            "must be within 1200 um, a fifth of the module, got 1500.0: give it",
        ),
    ):
        with pytest.raises(DesignError, match=message):
            design.pinion.modified(Modification(pitch_deviations_um=tuple(values)))
    with pytest.raises(DesignError, match="pitch_deviations_um must be a finite number, got nan"):
        Modification(pitch_deviations_um=(1.0, np.nan))


def test_design_files(tmp_path: Path) -> None:
    """A list, and a file in the folder of the design."""
    amounts = [round(0.1 * k - 1.0, 3) for k in range(29)]
    lines = "\n".join(f"{value} # tooth {k}" for k, value in enumerate(amounts))
    (tmp_path / "pitch.txt").write_text(f"# um, right flanks\n\n{lines}\n")
    path, text = tmp_path / "pair.toml", design_text(builtin_design())
    path.write_text(f'{text}[pinion.modification.right]\npitch_deviations_um = "pitch.txt"\n')
    design = read_design(path)
    assert design.pinion.pitch_deviations("right") == tuple(amounts)
    assert design.pinion.pitch_deviations("left") is None
    assert design.pinion.modification("right") is None
    path.write_text(design_text(design))
    assert read_design(path) == design
    (tmp_path / "words.txt").write_text("1.0\ntwo\n")
    for value, message in (
        ('"none.txt"', "pitch_deviations_um cannot read 'none.txt' (No such file or directory): paths are"),
        ('"words.txt"', "pitch_deviations_um 'words.txt' line 2 is no number: write one number in um in"),
        ("[1.0]", "pitch_deviations_um must have one value for each tooth, 29, got 1"),
        ("3.0", "pitch_deviations_um must be a list of numbers in um, got 3.0"),
        ('["1"]', "pitch_deviations_um must be a number"),
        (f"{[[k, 1.0] for k in range(29)]}", "pitch_deviations_um must be a number"),
        ('"/dev/zero"', "pitch_deviations_um '/dev/zero' is longer than 100,000 bytes"),
    ):
        path.write_text(f"{text}[pinion.modification]\npitch_deviations_um = {value}\n")
        assert f"Error: {path}: [pinion.modification] {message}" in refused("operation", path)


@pytest.mark.slow
def test_the_command_operation(tmp_path: Path) -> None:
    amounts = np.linspace(-1.0, 1.8, 29)
    path = tmp_path / "pair.toml"
    path.write_text(design_text(with_pitch(builtin_design(), amounts)))
    found = strict_json(run("operation", path, "--json").stdout)
    assert found["pitch_cycle"]["pitches"] == 29
    assert found["modification"]["pinion"]["left"]["pitch_deviations_um"] == amounts.tolist()
    words = " ".join(run("operation", path).stdout.split())
    assert "pinion: pitch deviations of 29 teeth from -1 to 1.8 um" in words
    assert "arcsec peak to peak over 29 pitches; the gear is furthest ahead at pinion tooth 28" in words
