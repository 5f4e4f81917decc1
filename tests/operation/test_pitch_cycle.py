"""Transmission error with deviations of single teeth: steps, mating teeth, and design files."""

from __future__ import annotations

from collections.abc import Callable
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
    PitchCycle,
    builtin_design,
    design_text,
    first_contact,
    mean_deviations,
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


def table_of(member: Member) -> FlankDeviations:
    given = member.modification_right
    assert given is not None
    assert given.deviations is not None
    return given.deviations


@pytest.mark.parametrize("name", ["pinion", "gear"])
def test_the_error_steps_by_the_deviation_of_a_tooth(name: str, flank: str) -> None:
    design, count, amount = table1(), {"pinion": 29, "gear": 45}[name], 6.0
    cycle = pitch_cycle(with_pitch(design, **{name: one_tooth(count, 3, amount)}), flank)
    base = base_cylinder(design.gear, flank)
    step = 1e-3 * amount / float(base.radius * np.cos(base.helix_angle))
    assert cycle.transmission_error.shape == (count, 24)
    assert cycle.peak_to_peak == pytest.approx(step, abs=1e-9)
    # The tooth alone is in contact over the contact ratio of a pair, and edges of its mate before and after.
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


def assert_furthest_pair(cycle: PitchCycle, pitch: int, designs: Callable[[int, int], Design]) -> None:
    """Check that the tooth pair that is furthest ahead is in contact, with its first contact in the design of
    its two teeth."""
    roll, errors = cycle.pinion_roll[pitch, 0], {}
    for pair in range(-pitch - 1, -pitch + 2):
        teeth = pair % 29, -pair % 45
        first = first_contact(designs(*teeth), cycle.flank, [roll], (pair,))
        errors[teeth] = float(np.nan_to_num(first.transmission_error[0], nan=-np.inf))
    best = max(errors, key=errors.__getitem__)
    assert cycle.transmission_error[pitch, 0] == pytest.approx(errors[best], abs=1e-11)
    assert (cycle.pinion_tooth[pitch, 0], cycle.gear_tooth[pitch, 0]) == best


@pytest.mark.parametrize(("pitch", "flank"), [(0, "right"), (700, "left")])
def test_the_mating_teeth_are_displaced_flanks(pitch: int, flank: str) -> None:
    """The error of each tooth pair equals the first contact of single tooth pairs of designs whose flanks
    have the deviations."""
    plain, rng = table1((0.001, -0.001)), np.random.default_rng(pitch)
    amounts = rng.uniform(-9.0, 9.0, 29), rng.uniform(-9.0, 9.0, 45)
    cycle = pitch_cycle(with_pitch(plain, *amounts), flank, 1)
    assert cycle.pitches == 29 * 45

    def with_teeth(*teeth: int) -> Design:
        members = [displaced(m, a[k]) for m, a, k in zip(plain.members, amounts, teeth, strict=True)]
        return replace(plain, pinion=members[0], gear=members[1])

    assert_furthest_pair(cycle, pitch, with_teeth)


def test_equal_displacements_of_measured_teeth_are_pitch_deviations(flank: str) -> None:
    """Tables of three measured teeth with one value each give the same cycle as pitch deviations with these
    values."""
    design, amounts = table1((0.001, -0.001)), np.array([4.0, -3.0, 0.0])
    tables = [table_of(displaced(design.gear, amount)) for amount in amounts]
    gear = design.gear.modified(Modification(deviations=mean_deviations(tables)))
    pinion = design.pinion.modified(Modification(pitch_deviations_um=tuple(one_tooth(29, 2, -5.0))))
    measured = pitch_cycle(replace(design, pinion=pinion, gear=gear), flank, 3)
    # The tables repeat after three teeth, and 45 is a multiple of it.
    assert measured.pitches == 29 * 3
    expected = pitch_cycle(with_pitch(design, one_tooth(29, 2, -5.0), np.resize(amounts, 45)), flank, 3)
    assert np.abs(np.tile(measured.transmission_error, (15, 1)) - expected.transmission_error).max() < 1e-11
    assert np.array_equal(measured.gear_tooth, expected.gear_tooth[:87])


def test_each_tooth_has_its_table() -> None:
    """Each tooth pair has the first contact of a design with the tables of its two teeth, and the pair that
    is furthest ahead is in contact."""
    plain, rng = table1((0.001, -0.001)), np.random.default_rng(4)
    tables = [
        [
            replace(table_of(displaced(member, 0.0)), deviation_um=rng.uniform(-3.0, 3.0, (2, 2, 2)))
            for _ in range(count)
        ]
        for member, count in zip(plain.members, (2, 3), strict=True)
    ]
    members = [
        member.modified(Modification(deviations=mean_deviations(own)))
        for member, own in zip(plain.members, tables, strict=True)
    ]
    mean = 0.5 * (tables[0][0].deviation_um + tables[0][1].deviation_um)
    assert np.allclose(table_of(members[0]).deviation_um, mean)
    cycle = pitch_cycle(replace(plain, pinion=members[0], gear=members[1]), "right", 1)
    assert cycle.pitches == 29 * 3

    def with_teeth(pinion: int, gear: int) -> Design:
        own = (tables[0][pinion % 2], tables[1][gear % 3])
        parts = [m.modified(Modification(deviations=x)) for m, x in zip(plain.members, own, strict=True)]
        return replace(plain, pinion=parts[0], gear=parts[1])

    assert_furthest_pair(cycle, 80, with_teeth)


def test_files_of_single_teeth(tmp_path: Path) -> None:
    """A design file may list the files of several teeth. Commands that compute the mean tooth print a note,
    and faulty lists are rejected."""
    grid, text = measuring_grid(builtin_design().pinion, 2, 2), design_text(builtin_design())
    for k in range(2):
        points = (grid.point + 0.002 * k * grid.normal).reshape(-1, 3).tolist()
        (tmp_path / f"{k}.txt").write_text("\n".join(" ".join(map(repr, row)) for row in points))
    path = tmp_path / "pair.toml"
    table = '[pinion.modification.left]\ndeviations = {file = ["0.txt", "1.txt"], rows = 2, columns = 2}\n'
    path.write_text(f"{text}{table}[gear.modification.right]\npitch_deviations_um = {list(range(45))}\n")
    design = read_design(path)
    first, second = design.pinion.tooth_deviations("left")
    assert first.empty
    assert np.abs(second.deviation_um - 2.0).max() < 1e-9
    assert design.pinion.tooth_deviations("right") == ()
    assert pitch_cycle(design, "left", 1).pitches == 29
    path.write_text(design_text(design))
    assert read_design(path) == design
    result = run("mesh", path, "--frames")
    assert result.stderr.splitlines() == [
        "Note: [gear.modification] right flanks are computed with no pitch_deviations_um; operation and "
        "render-report compute the transmission error of all teeth",
        "Note: [pinion.modification] left flanks are computed with the mean of 2 measured teeth; operation"
        " and render-report compute the transmission error of all teeth",
    ]
    path_of_mean = run("tca", path, "--flank", "left", "--no-certify")
    assert path_of_mean.stderr == result.stderr
    assert "deviations of 2 teeth, 2 x 2 points" in " ".join(path_of_mean.stdout.split())
    for value, message in (
        ("[]", "deviations must name a file of measured points, got []: write"),
        ('["0.txt", 3]', "deviations must name a file of measured points, got"),
        ('["0.txt", "none.txt"]', "deviations names 'none.txt', which cannot be read (No such file"),
        (f"{30 * ['0.txt']}", "deviations must name at most 29 files, one for each tooth, got 30: remove"),
    ):
        key = f"{{file = {value}, rows = 2, columns = 2}}" if "[]" not in value else value
        path.write_text(f"{text}[pinion.modification]\ndeviations = {key}\n")
        assert f"Error: {path}: [pinion.modification] {message}" in refused("operation", path)


def test_tables_of_single_teeth_have_one_grid() -> None:
    coarse, fine = (
        FlankDeviations(grid.l, np.broadcast_to(grid.point[..., 2], grid.l.shape), 0.0 * grid.l)
        for grid in (measuring_grid(table1().gear, 2, columns) for columns in (2, 3))
    )
    with pytest.raises(DesignError, match="teeth must be one or more tables of the same grid"):
        mean_deviations((coarse, fine))
    with pytest.raises(DesignError, match="one or more tables"):
        mean_deviations(())
    members = [table1().gear.modified(Modification(deviations=mean_deviations(21 * [fine]))) for _ in "12"]
    design = replace(table1(), gear=members[0])
    wide = replace(design, pinion=replace(design.pinion, modification_right=members[1].modification_right))
    with pytest.raises(ValueError, match="measured teeth must form at most 400 pairs, got 441"):
        pitch_cycle(wide)


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
    with pytest.raises(ValueError, match="within 20000 pitches, got 41989: give the deviations of"):
        pitch_cycle(wide)
    with pytest.raises(ValueError, match="points must be a whole number of at least 1, got 0"):
        pitch_cycle(design, points=0)
    with pytest.raises(ValueError, match=r"design must be a single design, got arrays of shape \(2,\)"):
        pitch_cycle(design.with_parabola(np.zeros(2)))
    for values, message in (
        (
            (1.0, 2.0),
            "modification_right.pitch_deviations_um must have one value for each of the 29 teeth, got 2",
        ),
        (
            one_tooth(29, 4, -1500.0),
            r"must be at most 1200 um \(a fifth of the module\) in magnitude, got 1500.0: give it",
        ),
    ):
        with pytest.raises(DesignError, match=message):
            design.pinion.modified(Modification(pitch_deviations_um=tuple(values)))
    with pytest.raises(DesignError, match="pitch_deviations_um must be a finite number, got nan"):
        Modification(pitch_deviations_um=(1.0, np.nan))


def test_design_files(tmp_path: Path) -> None:
    """Pitch deviations are given as a list or as a file in the folder of the design; faulty ones are
    rejected."""
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
        ('"none.txt"', "pitch_deviations_um names 'none.txt', which cannot be read (No such"),
        ('"words.txt"', "pitch_deviations_um 'words.txt' line 2 is not a number: write one number in um in"),
        ("[1.0]", "pitch_deviations_um must have one value for each of the 29 teeth, got 1"),
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
    # The page shows the remarks as well.
    assert any("over 29 pitches" in note for note in found["notes"])
    words = " ".join(run("operation", path).stdout.split())
    assert "pinion: pitch deviations of 29 teeth from -1 to 1.8 um" in words
    assert "arcsec peak to peak over 29 pitches; the gear is furthest ahead at pinion tooth 28" in words
