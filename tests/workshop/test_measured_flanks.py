"""Measured flanks in contact analysis: surfaces through measured points, design files, and
parabolas given as deviations."""

from __future__ import annotations

import pickle
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
    path_of_contact,
    path_sliding,
    read_design,
)
from beveloid_geom.arrays import FLANK_SIGN, FloatArray
from beveloid_geom.gear.closest_point import feet
from beveloid_geom.gear.flank import flank_point, modification_of, trace_parameter
from beveloid_geom.operation.engagement import engagement_of, pitch_point_roll
from beveloid_geom.operation.search.local_clearance import clearance_at, limits_at
from beveloid_geom.workshop.grid import MeasuringGrid
from beveloid_geom.workshop.measured import deviations_of
from tests.cli.running import json_of, refused, run, words_of
from tests.oracle.table1 import table1

FILE = design_text(builtin_design())


def measured(
    member: Member, amount: float = 0.02, lateral: float = 0.001, shape: tuple[int, int] = (5, 9)
) -> tuple[MeasuringGrid, FloatArray]:
    """Return a grid and points with random deviations and lateral offsets, mm."""
    rng = np.random.default_rng(shape[0])
    grid = measuring_grid(member, *shape, 0.05)
    along = rng.uniform(-amount, amount, grid.l.shape)[..., None] * grid.normal
    return grid, grid.point + along + rng.uniform(-lateral, lateral, grid.point.shape)


def with_points(member: Member, grid: MeasuringGrid, point: FloatArray) -> Member:
    return member.modified(Modification(deviations=deviations_of(grid, point).on_flanks))


@pytest.mark.parametrize("parabola", [0.0, 0.001])
@pytest.mark.parametrize("shape", [(5, 9), (2, 2), (3, 12)])
def test_the_flank_passes_through_the_measured_points(parabola: float, shape: tuple[int, int]) -> None:
    """The feet of perpendiculars from the points are the points themselves."""
    for member in table1((parabola, -parabola)).members:
        grid, point = measured(member, shape=shape)
        found = with_points(member, grid, point)
        for side, flank in enumerate(FLANK_SIGN):
            foot = feet(found, flank, point[side], (grid.l[side], grid.u[side]))
            assert np.abs(foot.distance).max() < 1e-12
            assert np.abs(feet(member, flank, point[side]).distance).max() > 1e-3


def test_other_modifications_are_added() -> None:
    """Deviations are added to other modifications: measured points of a flank without crowning undo the
    crowning of the design."""
    plain = table1().pinion
    given = Modification(helix_crowning_um=10.0, tip_relief_um=8.0, tip_relief_length_mm=5.0)
    grid, nominal = measuring_grid(plain.modified(given), 9, 9, 0.0), measuring_grid(plain, 9, 9, 0.0)
    undone = plain.modified(replace(given, deviations=deviations_of(grid, nominal.point).on_flanks))
    for side, flank in enumerate(FLANK_SIGN):
        points = flank_point(undone, flank, nominal.l[side], nominal.u[side])
        assert np.abs(points - nominal.point[side]).max() < 1e-12


def test_derivatives_within_and_beyond_the_grid(flank: str) -> None:
    member = with_points(table1().gear, *measured(table1().gear))
    rows, step = modification_of(member, flank), 1e-4
    assert rows is not None
    l, z = np.meshgrid(np.linspace(-8.0, 8.0, 21), np.linspace(-36.0, 36.0, 17))
    exact = rows.rows(l, z)
    by_l = (rows.rows(l + step, z) - rows.rows(l - step, z)) / (2.0 * step)
    by_z = (rows.rows(l, z + step) - rows.rows(l, z - step)) / (2.0 * step)
    assert np.abs(exact[[1, 3, 4]] - by_l[[0, 1, 2]]).max() < 1e-8
    assert np.abs(exact[[2, 4, 5]] - by_z[[0, 1, 2]]).max() < 1e-8
    assert np.abs(exact[3:]).min(axis=(1, 2)).max() < 1e-6 < np.abs(exact[3:]).max()


def test_zero_deviations_change_nothing(tmp_path: Path, flank: str) -> None:
    """The nominal grid as the command prints it, rounded to 1e-9 mm, gives no deviations."""
    (tmp_path / "points.txt").write_text(run("grid", "ni-2017").stdout)
    (tmp_path / "pair.toml").write_text(FILE + '[pinion.modification]\ndeviations = "points.txt"\n')
    design = read_design(tmp_path / "pair.toml")
    assert design.pinion.modification_left is not None
    found, expected = (path_of_contact(one, flank).point for one in (design, builtin_design()))
    assert np.array_equal(found, expected)


def test_stacked_members_have_their_own_deviations(flank: str) -> None:
    """Points of stacked members, which the calculation of sliding uses, equal those of single members with
    their deviations."""
    members = [
        with_points(m, *measured(m, 0.003, shape=shape))
        for m, shape in zip(table1().members, ((4, 5), (3, 6)), strict=True)
    ]
    random = np.random.default_rng(3)
    l, z = random.uniform(-5.0, 5.0, (2, 1, 40)), random.uniform(-24.0, 24.0, (2, 1, 40))
    for pair in (members, (members[0], table1().gear), (table1().pinion, members[1])):
        design = replace(table1(), pinion=pair[0], gear=pair[1])
        u = np.array([trace_parameter(m, flank, a, b) for m, a, b in zip(pair, l, z, strict=True)])
        single = [flank_point(m, flank, a, b) for m, a, b in zip(pair, l, u, strict=True)]
        assert np.abs(flank_point(design.stacked_members(), flank, l, u) - single).max() < 1e-12


def test_batches_of_members_are_single_members() -> None:
    members = [with_points(member, *measured(member, 0.001)) for member in table1().members]
    design, parabolas = replace(table1(), pinion=members[0], gear=members[1]), (0.0, 0.0004)
    batch = path_of_contact(design.with_parabola(np.array(parabolas), 0.0), "left", 3)
    for k, parabola in enumerate(parabolas):
        single = path_of_contact(design.with_parabola(parabola, 0.0), "left", 3)
        assert np.isfinite(single.point).all()
        assert np.abs(batch.point[k] - single.point).max() < 1e-12


def test_designs_with_deviations_are_values(tmp_path: Path) -> None:
    """Hash, comparison, pickle, and the text of a design file."""
    member = table1().pinion
    one, other = (with_points(member, *measured(member)) for _ in range(2))
    assert one == other == pickle.loads(pickle.dumps(one))
    assert hash(one) == hash(pickle.loads(pickle.dumps(one)))
    assert one != with_points(member, *measured(member, 0.01))
    with pytest.raises(ValueError, match="deviations must come from a file"):
        design_text(replace(table1(), pinion=one))
    _, point = measured(builtin_design().pinion, shape=(3, 4))
    lines = (" ".join(map(repr, row)) for row in point.reshape(-1, 3).tolist())
    (tmp_path / "points \U0001f642.txt").write_text("\n".join(lines))
    key = 'deviations = {file = "points \U0001f642.txt", rows = 3, columns = 4, border = "5%"}'
    text = f"{FILE}[pinion.modification.left]\n{key}\ntwist_um = 1\n"
    (tmp_path / "pair.toml").write_text(text, encoding="utf-8")
    design = read_design(tmp_path / "pair.toml")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "copy.toml").write_text(design_text(design), encoding="utf-8")
    assert read_design(elsewhere / "copy.toml") == design
    given = design.pinion.modification_left
    assert given is not None
    changed = design.pinion.modified(replace(given, twist_um=2.0), "left")
    with pytest.raises(ValueError, match="deviations belong to the flanks with which"):
        design_text(replace(design, pinion=changed))
    assert given.deviations is not None
    # The twist of the design is part of the flank from which deviations are counted.
    twisted = builtin_design().pinion.modified(Modification(twist_um=1.0), "left")
    found = deviations_of(measuring_grid(twisted, 3, 4, 0.05), point).on_flanks
    assert np.abs(given.deviations.deviation_um - found.deviation_um).max() < 1e-9


FAULTS = {
    'deviations = "none.csv"': "deviations names 'none.csv', which cannot be read (No such file",
    "deviations = 3.0": "deviations must name a file of measured points, got 3.0: write",
    "deviations = {rows = 5}": "deviations must name a file of measured points",
    'deviations = {file = "all.txt", row = 5}': "deviations.row is unknown: known are file, rows, columns",
    'deviations = {file = "all.txt", rows = 1}': "deviations.rows must be between 2 and 999, got 1",
    'deviations = {file = "all.txt", border = 0.1}': "deviations.border must be a text, got 0.1",
    'deviations = {file = "all.txt", border = "10"}': "border must be a percentage such as 10%",
    'deviations = {file = "all.txt", border = "60%"}': "border must be at least 0 and below 50 %, got 60 %",
    'deviations = {file = "all.txt", columns = 4}': "row 1, column 5), expected (right, row 2, column 1)",
    'deviations = "hole.txt"': "line 8 is (right, row 1, column 2), expected (right, row 1, column 1)",
    'deviations = "gear.txt"': "from its nominal position, the limit is 3 mm: do design, member, grid",
    'deviation = "all.txt"': "deviation is unknown: did you mean deviations?",
    'right.deviations = "none.csv"': "[pinion.modification.right] deviations names 'none.csv', which",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a correct file of points of each member, and one with a missing point."""
    folder = tmp_path_factory.mktemp("points")
    lines = run("grid", "ni-2017").stdout.splitlines()
    (folder / "all.txt").write_text("\n".join(lines))
    (folder / "hole.txt").write_text("\n".join((*lines[:7], *lines[8:])))
    (folder / "gear.txt").write_text(run("grid", "ni-2017", "--member", "gear").stdout)
    return folder


@pytest.mark.parametrize("line", FAULTS)
def test_faulty_files_are_one_line(line: str, folder: Path) -> None:
    (folder / "pair.toml").write_text(f"{FILE}[pinion.modification]\n{line}\n")
    with pytest.raises(DesignError) as caught:
        read_design(folder / "pair.toml")
    assert len(caught.value.faults) == 1
    assert FAULTS[line] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_commands_name_the_file(folder: Path) -> None:
    path = folder / "pair.toml"
    path.write_text(f'{FILE}[gear.modification]\ndeviations = "gear.txt"\nhelix_crowning_um = 5.0\n')
    assert "gear: deviations of gear.txt, 5 x 9 points, helix crowning 5 um" in words_of("tca", path)
    path.write_text(f'{FILE}[gear.modification]\ndeviations = "all.txt"\n')
    assert "[gear.modification] deviations 'all.txt' has the point of" in refused("tca", path)


def test_pattern_beside_that_of_nominal_flanks(folder: Path) -> None:
    """The pattern of measured flanks is printed with that of the nominal flanks. The measured flanks have 10
    um of helix crowning; the nominal pattern is that of the design."""
    crowned = run("grid", "ni-2017", "--pinion-modification", "helix_crowning=10").stdout
    (folder / "crowned.txt").write_text(crowned)
    path = folder / "pair.toml"
    path.write_text(f'{FILE}[pinion.modification]\ndeviations = "crowned.txt"\n')
    measured, plain = (json_of("pattern", name) for name in (path, "ni-2017"))
    assert "nominal" not in plain
    for member in ("pinion", "gear"):
        nominal = measured["nominal"][member]
        assert nominal["area"] == plain[member]["area"]
        assert measured[member]["area_share"] < 0.8 * nominal["area_share"]
    share = 100.0 * plain["pinion"]["area_share"]
    assert f"nominal flanks pinion {share:.1f} %" in words_of("pattern", path)


def test_other_amounts_on_measured_flanks_are_not_written(tmp_path: Path) -> None:
    """A design whose amounts changed after its deviations were read is not written, because the points would
    undo the change when the file is read."""
    (tmp_path / "points.txt").write_text(run("grid", "ni-2017", "--parabola-pinion", "0.0005").stdout)
    (tmp_path / "pair.toml").write_text(FILE + '[pinion.modification]\ndeviations = "points.txt"\n')
    out = "--out", str(tmp_path / "out.toml")
    message = "--out: [pinion.modification] has measured deviations, which would undo the change"
    for command in (
        "optimise --vary pinion.helix_crowning 0 9",
        "modify --transmission-error-arcsec 2 --length 20",
    ):
        assert message in refused(*command.split(), tmp_path / "pair.toml", *out)
    assert not (tmp_path / "out.toml").exists()


def test_values_from_python() -> None:
    grid = measuring_grid(table1().pinion, 3, 4)
    z = np.broadcast_to(grid.point[..., 2], grid.l.shape)
    none = np.zeros_like(grid.l)
    for deviation, message in (
        (np.full_like(none, np.nan), "deviation_um must contain finite numbers only"),
        (none + 2e5, "deviation_um must be at most 100000 um in magnitude, got 200000: give it in um"),
        (none[0], "deviation_um must have the shape of l, .2, rows, columns."),
    ):
        with pytest.raises(DesignError, match=message):
            FlankDeviations(grid.l, z, deviation)
    with pytest.raises(DesignError, match="rows from root to tip and the columns towards"):
        FlankDeviations(grid.l[:, ::-1], z, none)
    with pytest.raises(DesignError, match="columns towards"):
        FlankDeviations(grid.l, z[..., ::-1], none)
    with pytest.raises(DesignError, match="deviations must be of the class FlankDeviations"):
        Modification(deviations=none)  # type: ignore[arg-type]
    with pytest.raises(DesignError, match="at most 20000 points"):
        FlankDeviations(*np.zeros((3, 2, 150, 150)))


def test_waves_between_the_scanned_points_are_found() -> None:
    """First contact of flanks with scatter of 3 um, against points of the complete flank."""
    rng, members = np.random.default_rng(0), []
    for member in table1().members:
        grid = measuring_grid(member)
        scatter = 0.003 * rng.normal(size=grid.l.shape)
        members.append(with_points(member, grid, grid.point + scatter[..., None] * grid.normal))
    design = replace(table1(), pinion=members[0], gear=members[1])
    roll = pitch_point_roll(design, "left") + 1.5 * np.pi / 29.0
    engagement, _ = engagement_of(design, "left", np.array([roll]))
    l, z = np.meshgrid(np.linspace(-5.9, 6.6, 81), np.linspace(-25.0, 25.0, 81))
    first = np.zeros(l.size, dtype=int)
    task = engagement.task(first, first)  # tooth pair 0 is in contact
    with np.errstate(invalid="ignore"):
        margins, _ = limits_at(task, l.ravel(), z.ravel())
        gaps = clearance_at(task, l.ravel(), z.ravel())[0]
    best = gaps[(margins > 0.0).all(axis=0)].min()
    found = -first_contact(design, "left", [roll]).transmission_error[0] * engagement.lever
    assert -1e-12 < best - found < 1e-4


def parabolas_as_deviations() -> Design:
    """Return Table 1 with the parabolas 0.001 and -0.001 given as 17 x 33 deviations of straight flanks."""
    plain, bent = table1(), table1((0.001, -0.001))
    members = []
    for member, curved in zip(plain.members, bent.members, strict=True):
        grid, points = measuring_grid(member, 17, 33, 0.0), []
        for side, flank in enumerate(FLANK_SIGN):
            foot = feet(curved, flank, grid.point[side])
            points.append(grid.point[side] - foot.distance[..., None] * foot.normal)
        members.append(with_points(member, grid, np.array(points)))
    return replace(plain, pinion=members[0], gear=members[1])


@pytest.mark.slow
def test_parabolas_given_as_deviations() -> None:
    """The mesh cycle of the pair whose flanks were measured is that of the pair with parabolas."""
    design, bent = parabolas_as_deviations(), table1((0.001, -0.001))
    cycle = mesh_cycle(design)
    assert np.degrees(cycle.peak_to_peak) * 3600.0 == pytest.approx(1.81, abs=0.05)
    assert 100.0 * cycle.edge_share == pytest.approx(18.1, abs=0.5)
    roll = cycle.start + cycle.pitch * np.linspace(0.0, 1.0, 40)
    for flank, lever in (("right", 137.0), ("left", 137.0)):
        first, true = (first_contact(one, flank, roll) for one in (design, bent))
        assert np.abs(first.gear_roll - true.gear_roll).max() * lever < 1e-6
    sliding = path_sliding(path_of_contact(design)), path_sliding(path_of_contact(bent))
    assert np.abs(sliding[0].speed - sliding[1].speed).max() < 1e-2 * np.abs(sliding[1].speed).max()
