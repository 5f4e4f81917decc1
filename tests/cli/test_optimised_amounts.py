"""Designs that `optimise --vary` and `modify` write: run again, they have the reported contact."""

from __future__ import annotations

from pathlib import Path

import pytest

from beveloid_geom import mesh_cycle, read_design
from beveloid_geom.report.columns import ARCSEC
from tests.cli.running import csv_of, json_of, refused, run, words_of

AIM = ("--shaft-angle-tolerance-deg", "0.01", "--contact-ratio", "1.4")


@pytest.mark.slow
def test_optimum_on_a_bound(tmp_path: Path) -> None:
    out = tmp_path / "optimum.toml"
    arguments = "optimise", *AIM, "--vary", "pinion.helix_crowning", "0", "6", "--out", str(out)
    data = json_of(*arguments)
    assert data["at_limits"] == ["pinion.helix_crowning_um"]
    found = read_design(out)
    assert found.pinion.modification_left is None
    assert found.pinion.modification_right is not None
    assert found.pinion.modification_right.helix_crowning_um == data["amounts"]["pinion.helix_crowning_um"]
    swing = data["found"]["cycle_peak_to_peak"]  # of a batch, whose rounding differs from that of one design
    assert float(mesh_cycle(found, "right", 1).peak_to_peak) == pytest.approx(swing, rel=1e-12)
    assert refused(*arguments).startswith(f"Error: {out} exists already")
    text = run(*arguments, "--overwrite").stdout
    assert "at a bound         pinion helix crowning: wider bounds may give a better optimum" in text
    row, given = csv_of(*arguments, "--overwrite")
    assert float(row["pinion_helix_crowning_um"]) == data["amounts"]["pinion.helix_crowning_um"]
    assert float(given["pinion_helix_crowning_um"]) == 0.0


@pytest.mark.parametrize("vary", [(), ("--vary", "pinion.helix_crowning", "0", "20")])
def test_the_given_design_is_a_candidate(vary: tuple[str, ...]) -> None:
    """Conjugate flanks have no transmission error, so that no parabolas and no amounts are better."""
    aim = ("--least", "transmission-error", "--no-edges", "--shaft-angle-tolerance-deg", "0.01")
    words = words_of("optimise", "marine-gearbox", *aim, *vary)
    assert "as designed: no better values were found" in words
    assert "transmission error, under errors, arcsec 0.0000 0.0000" in words


@pytest.mark.slow
def test_crownings_are_written(tmp_path: Path) -> None:
    out = tmp_path / "crowned.toml"
    done = run("modify", "--transmission-error-arcsec", "3", "--length", "30", "--out", str(out))
    assert done.exit_code == 0, done.output
    swing = ARCSEC * float(mesh_cycle(read_design(out), "right", 1).peak_to_peak)
    assert swing == pytest.approx(3.0, rel=2e-3)
