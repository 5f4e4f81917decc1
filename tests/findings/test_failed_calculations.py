"""Failed calculations have exit status 4 and are never reported as "no contact"."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Tolerances, builtin_design, design_map, tolerance_study
from beveloid_geom.operation.mesh_cycle import MeshCycle
from beveloid_geom.operation.operating_ratio import OperatingRatios, operating_ratios
from beveloid_geom.report import operation
from beveloid_geom.report.map import MapReport
from beveloid_geom.report.tolerance import ToleranceReport
from beveloid_geom.status import FirstStatus, RatioStatus, Status
from tests.cli.running import run, strict_json

OVERLAPPING = builtin_design().with_parabola(pinion=0.03)  # the tool leaves no flank
OFF_FLANK = builtin_design().with_errors(Errors(offset=20.0))
UNSOLVED = "the first contact of the right teeth could not be computed: the search did not converge"


def failing(monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
    """Replace statuses of the mesh cycle of `operation`, or of its contact ratios, by those of searches that
    have not converged."""

    def changed(*given: Any) -> OperatingRatios:
        ratios = operating_ratios(*given)
        cycle: MeshCycle = replace(ratios.cycle, **changes.get("cycle", {}))
        return replace(ratios, cycle=cycle, **changes.get("ratios", {}))

    monkeypatch.setattr(operation, "operating_ratios", changed)
    # The cache of reports in tests of the commands must not contain these reports.
    report = operation.operation_report
    monkeypatch.setattr(operation, "operation_report", getattr(report, "__wrapped__", report))


def test_failed_cycle(monkeypatch: pytest.MonkeyPatch) -> None:
    failing(
        monkeypatch,
        cycle={"status": np.asarray(np.int8(FirstStatus.NOT_CONVERGED)), "lost": np.asarray(True)},
    )
    text, data = run("operation", "--points", "3"), run("operation", "--points", "3", "--json")
    assert (text.exit_code, data.exit_code) == (4, 4)
    assert text.stderr == f"Not computed: {UNSOLVED}\n"
    found = strict_json(data.stdout)
    assert found["reason"] == UNSOLVED
    assert found["unknowns"] == [f"right flanks, in operation: Not computed: {UNSOLVED}"]
    assert "o contact" not in text.output


def test_failed_contact_ratio(monkeypatch: pytest.MonkeyPatch) -> None:
    """If a contact ratio could not be computed, the other results are printed. A film that is too thick is
    not a failed calculation."""
    for status, expected in ((RatioStatus.UNSTEADY, 4), (RatioStatus.TOO_THICK, 0)):
        ratios = {"ratio": np.full(2, np.nan), "status": np.full(2, status, dtype=np.int8)}
        failing(monkeypatch, ratios=ratios)
        result = run("operation", "--points", "3")
        assert result.exit_code == expected
        assert ("could not be computed" in result.stdout) is (expected == 4)
        assert "arcsec peak to peak" in result.stdout


def test_keys_of_the_peak_to_peak_transmission_error() -> None:
    """`cycle_peak_to_peak` is the error of all teeth in operation, `path_peak_to_peak` that of one tooth pair
    along its path. Both are equal to the older key `peak_to_peak` of their command."""
    given = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001", "--json")
    teeth = strict_json(run("operation", "--points", "3", *given).stdout)
    one_pair = strict_json(run("sensitivity", *given).stdout)
    assert teeth["cycle_peak_to_peak"] == teeth["peak_to_peak"]
    assert one_pair["path_peak_to_peak"] == one_pair["peak_to_peak"]
    assert one_pair["path_peak_to_peak_by"] == one_pair["peak_to_peak_by"]
    assert one_pair["path_peak_to_peak"] > 1.5 * teeth["cycle_peak_to_peak"]


@pytest.mark.parametrize(("command", "more"), [("tolerance", ("--cases", "50")), ("optimise", ())])
def test_usual_tolerances_are_the_default(command: str, more: tuple[str, ...]) -> None:
    usual = {
        "--offset-tolerance": "0.05",
        "--shaft-angle-tolerance-deg": "0.01",
        "--pinion-axial-tolerance": "0.1",
        "--gear-axial-tolerance": "0.1",
    }
    given = [word for pair in usual.items() for word in pair]
    plain, same = (run(command, "--json", *more, *words) for words in ((), given))
    assert (plain.exit_code, plain.stderr) == (0, "")
    assert plain.stdout == same.stdout


def test_edge_contact_is_a_warning_of_operation() -> None:
    given = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001", "--points", "61", "--json")
    data = strict_json(run("operation", *given).stdout)
    (warning,) = data["warnings"]
    assert warning == "right flanks, in operation: edges touch during 18.1 % of the mesh cycle (gear tip)"
    (note,) = strict_json(run("operation", "--points", "3", "--json").stdout)["notes"]
    assert note.endswith("reaches pinion tip, gear tip, pinion toe, pinion heel")


@pytest.mark.parametrize(
    ("design", "path", "status"),
    [(OVERLAPPING, Status.NOT_CONVERGED, 4), (OFF_FLANK, Status.OFF_FLANK, 1)],
    ids=["not computed", "no path"],
)
def test_batches_without_a_path(design: Design, path: Status, status: int) -> None:
    """A batch with a failed calculation is not reported as one without a path, because the failed mounting or
    cell may have a path."""
    found = design_map(builtin_design(), "parabola", steps=2)
    found = replace(found, status=np.array([[Status.OFF_FLANK, path]] * 2, dtype=np.int8))
    study = tolerance_study(design, Tolerances(offset=0.01), cases=20)
    for failure in (ToleranceReport("x", design, study).failure, MapReport("x", found.design, found).failure):
        assert failure is not None
        assert failure.status == status
        assert ("could be computed" in failure.text) is (status == 4)
