"""The command `render-report`: one page without external files, with the numbers of the commands."""

from __future__ import annotations

import math
import os
import re
import shlex
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from html import unescape
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from beveloid_geom import builtin_design, pattern_matrix
from beveloid_geom.design.file import builtin_text
from beveloid_viz.report.cells import cell_pictures, size_decimals
from beveloid_viz.report.cli import main
from beveloid_viz.report.page import looked_up
from tests.cli.running import json_of, run
from tests.symmetry import scaled

from .report_page import ReportPage

COMMAND = [str(Path(sys.executable).with_name("render-report"))]
WITHOUT_VTK = [
    *(sys.executable, "-c"),
    "import sys; from beveloid_viz.report.cli import main; main(standalone_mode=False);"
    "sys.exit(9 if {'vtkmodules', 'vtk', 'pyvista'} & set(sys.modules) else 0)",
]
NAME = Path("x<", "script><img src=x onerror=alert(1)> & \"'.toml")
"""A file name that tries to close a script element and to open others."""
TOLERANCES = ("--offset-tolerance", "0.04", "--gear-axial-tolerance", "0.2", "--seed", "7", "--cases", "100")
MOST_BYTES = 4_000_000
UNITS = 240.0 / 6.0
"""Units of the patterns of this pair per mm."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that contains the modified pair of the paper as NAME."""
    folder = tmp_path_factory.mktemp("report")
    source = folder / NAME
    source.parent.mkdir()
    text = builtin_text().replace("parabola = 0.0  ", "parabola = 0.001  ", 1)
    source.write_text(text.replace("parabola = 0.0\n", "parabola = -0.001\n"), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def text(folder: Path) -> str:
    """Return the page, written by a process that cannot import VTK."""
    command = [*WITHOUT_VTK, str(NAME), "--out", "page.html", *TOLERANCES]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(r".*page\.html: \d\.\d\d MB, made in \d+\.\d s\n", done.stdout)
    assert 100_000 < (folder / "page.html").stat().st_size < MOST_BYTES
    return (folder / "page.html").read_bytes().decode()


@pytest.fixture(scope="module")
def page(text: str) -> ReportPage:
    return ReportPage(text)


def written(folder: Path, *options: str, status: int = 0) -> ReportPage:
    """Return the page that the command writes; it ends with this exit status."""
    done = CliRunner().invoke(main, [*options, "--out", str(folder / "page.html")])
    assert done.exit_code == status, done.stderr
    return ReportPage((folder / "page.html").read_text(encoding="utf-8"))


def test_patterns_under_errors_do_not_depend_on_the_module() -> None:
    """The drawn patterns under errors, their frame and the centre of the ellipse are equal for similar
    pairs."""
    drawn = []
    for factor in (1.0, 0.05):
        design = scaled(builtin_design().with_parabola(0.001, -0.001), factor)
        sizes, separation = (0.02 * factor, 0.0001), 0.006 * factor
        matrix = pattern_matrix(design, ("offset", "shaft_angle"), sizes=sizes, separation=separation)
        drawn.append([re.findall(r"-?[\d.]+", cell) for cell in cell_pictures(matrix)[:1]])
    assert np.allclose(np.array(drawn[0], dtype=float), np.array(drawn[1], dtype=float), rtol=0.0, atol=1.01)
    assert [size_decimals(module) for module in (20.0, 6.0, 1.0, 0.3, 0.1, 0.01)] == [1, 1, 1, 2, 2, 3]


@pytest.mark.slow
def test_nothing_is_fetched(page: ReportPage, text: str) -> None:
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(set(ids)) == len(ids)
    for tag, attributes in page.tags:
        assert tag not in ("link", "base", "iframe", "object", "embed", "img", "image", "form")
        for name in ("src", "srcset", "data", "poster", "action", "background"):
            assert name not in attributes, (tag, attributes)
        for name in ("href", "xlink:href"):
            assert name not in attributes or attributes[name].removeprefix("#") in ids, (tag, attributes)
        for target in re.findall(r"url\(([^)]*)\)", " ".join(attributes.values())):
            assert target.removeprefix("#") in ids
    style = text[text.index("<style>") : text.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style
    policy = next(a["content"] for _, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline';")
    assert "http" not in policy


def test_page_names_file_dates_and_version(page: ReportPage, folder: Path) -> None:
    """Name, dates and version come before the contents, and are saved with the numbers."""
    data, head = page.json("data"), page.words[: page.words.index("Summary")]
    assert (data["name"], data["version"]) == (str(NAME), version("beveloid-geom"))
    made, written = (datetime.fromisoformat(data[name]) for name in ("made", "written"))
    assert abs(datetime.now(UTC) - made) < timedelta(hours=2)
    assert abs(written.timestamp() - (folder / NAME).stat().st_mtime) <= 1.0
    assert f"Design file {NAME} of {written:%Y-%m-%d %H:%M}" in head
    assert f"page written {made:%Y-%m-%d %H:%M}" in head
    assert f"by beveloid-geom {data['version']}" in head
    assert page.words.count(f" {shlex.quote(str(NAME))} ") >= 6  # in commands


def test_verdict_lists_errors_and_warnings_first(page: ReportPage) -> None:
    """Errors and warnings of `check`, `tca` and `tolerance`, and the share of failing mountings, come before
    the contents; notes come after it."""
    data, words = page.json("data"), " ".join(page.words.split())
    contents = words.index("Summary Paths")
    assert words.index("Works with restrictions") < contents
    sections = [data["check"], *data["tca"].values(), *data["tolerance"].values()]
    for level, before in (("errors", True), ("warnings", True), ("notes", False)):
        for text in (text for section in sections for text in section[level]):
            named = text.replace("geom operation`", f"geom operation {shlex.quote(str(NAME))}`")
            assert (words.index(" ".join(named.replace("`", " ").split())) < contents) is before
    assert any("an edge touches earlier" in text for text in data["check"]["warnings"])
    assert re.search(r"random mountings fails? under the tolerances given", words[:contents])


@pytest.mark.parametrize(
    ("options", "verdict", "level"),
    [
        ((), "No objections found", "note"),
        (("--offset-error", "-0.2"), "Does not work in this form : 1 error, 1 warning", "error"),
    ],
)
def test_verdicts(options: tuple[str, ...], verdict: str, level: str, tmp_path: Path) -> None:
    """The verdict has the level and the numbers of the remarks. Results of unmodified flanks that are zero
    have one line instead of charts and rows. If the pair jams, the exit status is 1."""
    page = written(tmp_path, *options, "--cases", "40", status=1 if options else 0)
    words, data = " ".join(page.words.split()), page.json("data")
    assert words.index(verdict) < words.index("Summary Paths")
    assert ("div", {"class": f"verdict {level}"}) in page.tags
    assert ("svg", "pair-picture") in [(tag, attributes.get("class")) for tag, attributes in page.tags]
    failed = 40 if options else 0
    assert data["mountings"]["failed"] == data["mountings"]["jammed"] == failed
    share = (
        "100 % of 40 random mountings fail under usual tolerances: 100 % jammed."
        if failed
        else "None of 40 random mountings"
    )
    assert "".join(share.split()) in "".join(words.split())
    assert "amplitudes are zero within rounding (below 0.000001 arcsec), on both flanks." in words
    titles = {attributes.get("id", "") for tag, attributes in page.tags if tag == "title"}
    assert {
        f"{name}-title" for name in ("path-left", "sensitivity-right", "ease-off-left", "pressure-right")
    } <= titles
    assert not {"error-right-title", "error-left-title", "spectrum-right-title"} & titles
    keys = " ".join(attributes["data-key"] for attributes, _ in page.cells)
    assert not re.search("peak_to_peak|amplitudes|edge_share", keys)
    assert "Zero throughout: transmission error in operation, peak to peak; share of the cycle" in words
    assert words.count("Transmission error and edge contact are zero in all cells.") == (0 if options else 2)
    missing = "No patterns under errors, left flanks: no cell of the matrix"
    assert (missing in words[: words.index("Summary Paths")]) == bool(options)
    assert words.count("no cell of the matrix has a pattern") == (4 if options else 0)
    assert words.count("Zero throughout: transmission error along the path.") == 4  # two on each flank


def test_pressures_and_commands_are_those_of_the_options_given(tmp_path: Path) -> None:
    error = ("--gear-axial-error", "0.00012344")
    options = (*error, "--torque", "500")
    page = written(tmp_path, *options, "--cases", "20")
    printed = json_of("tca", "--flank", "left", *options)["hertz"]
    assert page.json("data")["hertz"]["left"] == printed
    words = " ".join(page.words.split())
    assert "steel on steel, under 500 N m on the pinion. The pressure grows" in words
    assert "beveloid-geom tca ni-2017 --gear-axial-error 0.00012344 --torque 500" in words
    study = "beveloid-geom tolerance ni-2017 --cases 20 --seed 0"
    assert f"{study} , for a design file with the errors of this page" in words
    for command in re.findall(
        r"<code>(beveloid-geom .*?)</code>", (tmp_path / "page.html").read_text("utf-8")
    ):
        assert run(*shlex.split(unescape(command))[1:]).exit_code == 0, command
    shown = [(at, text) for at, text in page.cells if at["data-key"] == "design.errors.gear_axial"]
    assert {(at["data-full"], text) for at, text in shown} == {("0.00012344", "0.0001234")}
    texts = [text for at, text in page.cells if at["data-key"].startswith("hertz.left.pressure.")]
    assert set(texts) == {f"{max(printed['pressure']):.1f}"}


def test_a_name_cannot_become_code(page: ReportPage, text: str) -> None:
    assert str(NAME) in page.words
    assert page.json("data")["tca"]["left"]["design"] == str(NAME)
    assert "<img src=x" not in text
    assert sum(tag == "script" for tag, _ in page.tags) == len(page.scripts) == 7


@pytest.mark.parametrize(
    ("command", "keys"),
    [
        (("check",), "check"),
        (("tca", "--flank", "right"), "tca.right"),
        (("tca", "--flank", "left"), "tca.left"),
        (("operation", "--flank", "right"), "operation.right"),
        (("operation", "--flank", "left"), "operation.left"),
        (("sliding", "--flank", "left", "--points", "101"), "sliding.left"),
        (("pattern",), "pattern.right"),
        (("pattern", "--over", "E,Sigma", "--flank", "right"), "matrix.right"),
        (("pattern", "--over", "offset,shaft-angle", "--flank", "left"), "matrix.left"),
        (("sensitivity", "--flank", "right"), "sensitivity.right"),
        (("sensitivity", "--flank", "left"), "sensitivity.left"),
        (("tolerance", "--flank", "left", *TOLERANCES), "tolerance.left"),
        (("statements", "--flank", "both"), "statements"),
        (("ease-off", "--grid", "9", "13"), "ease_off"),
        (("tca", "--flank", "left", "--force", "1000"), "hertz.left"),
        (("gear-data",), "gear_data"),
    ],
)
def test_its_data_are_those_of_the_command(
    page: ReportPage, folder: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], keys: str
) -> None:
    monkeypatch.chdir(folder)
    printed = json_of(*command, NAME)
    shown = printed["hertz"] if keys.startswith("hertz") else printed
    assert shown == looked_up(page.json("data"), keys)


def test_every_number_shown_is_that_of_the_data(page: ReportPage) -> None:
    data = page.json("data")
    assert len(page.cells) > 250
    for attributes, text in page.cells:
        found: Any = looked_up(data, attributes["data-key"])
        value, digits = found * float(attributes["data-scale"]), int(attributes["data-digits"])
        shown, decimals = float(text.replace("\u2212", "-")), len(text.partition(".")[2])
        if "data-full" in attributes:
            full = float(attributes["data-full"].replace("\u2212", "-"))
            assert full == pytest.approx(value, rel=10.0 ** (1 - digits))
            assert decimals <= 4 or abs(value) < 1.0
            assert abs(shown - value) <= min(0.5000001e-4, 1e-3 * abs(value)), attributes
        elif decimals == digits:
            assert abs(shown - value) <= 0.5000001 * 10.0**-digits, attributes
        else:
            assert shown == pytest.approx(value, rel=10.0 ** (1 - digits), abs=1e-300)
    keys = {attributes["data-key"].partition(".")[0] for attributes, _ in page.cells}
    sections = {"check", "tca", "operation", "sliding", "sensitivity", "tolerance", "pattern", "design"}
    assert keys == sections | {"ease_off", "hertz", "mountings", "matrix", "gear_data"}


def test_every_chart_has_a_title_and_the_pages_colours(page: ReportPage, text: str) -> None:
    charts = re.findall(r'<svg class="drawing".*?</svg>', text, flags=re.S)
    assert len(charts) == 20
    titles = {re.search(r"<title[^>]*>(.*?)</title>", chart)[1] for chart in charts}  # type: ignore[index]
    assert len(titles) == 20
    for chart in charts:
        assert not re.search(r"#[0-9a-fA-F]{6}\b|rgb\(|<style|font-family", chart)
        assert 'role="img"' in chart


def test_patterns_under_errors_agree_with_the_numbers(page: ReportPage, text: str) -> None:
    """The centre of the shaded area is the centre of the ellipse, which has the printed semi-axes. Cells that
    cannot be assembled are marked as jammed."""
    cells = re.findall(r'<td>(?:<svg class="cell".*?</svg>|<span class="none">jammed<)', text, flags=re.S)
    known = [cell for flank in ("right", "left") for cell in page.json("data")["matrix"][flank]["cells"]]
    assert len(cells) == len(known) == 18
    assert 0 < sum(cell["status"] == "jammed" for cell in known) < 9
    shown = [(drawn, own["pinion"]) for drawn, own in zip(cells, known, strict=True) if own["pinion"]]
    assert sum("<svg" in drawn for drawn in cells) == len(shown)
    places: dict[str, list[tuple[float, float]]] = {}
    for drawn, own in shown:
        ellipse, outlines = own["ellipse"], re.findall(r'class="area" d="([^"]*)"', drawn)
        assert len(outlines) == 3
        major, minor, x, y, turn = map(
            float, re.findall(r'<ellipse rx="(.*?)" ry="(.*?)" .*?\((\S*) (\S*)\) rotate\((.*?)\)', drawn)[0]
        )
        assert (major, minor) == pytest.approx((UNITS * ellipse["major"], UNITS * ellipse["minor"]), abs=0.5)
        assert math.radians(-turn) == pytest.approx(ellipse["angle"], abs=1e-3)
        amounts, middles = zip(*(amount_of(line) for line in outlines[0].split("M")[1:]), strict=True)
        middle = np.average(middles, axis=0, weights=amounts)
        assert np.abs(middle - (x, y)).max() < 0.5 * UNITS  # of a flank of 50 mm
        region = re.findall(r'viewBox="0 0 (\d+) (\d+)"', drawn)[0]
        places.setdefault(region, []).append((x / UNITS - ellipse["z"], y / UNITS + ellipse["r"]))
        cosine, sine = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        reach = math.hypot(major * cosine, minor * sine), math.hypot(major * sine, minor * cosine)
        for middle_of, extent, size in zip((x, y), reach, map(float, region), strict=True):
            assert 0.0 < middle_of - extent < middle_of + extent < size  # the ellipse is not cut
    assert len(places) == 2  # one region for each flank
    for of_flank in places.values():  # the same flank, within the rounding of path coordinates
        assert np.ptp(of_flank, axis=0).max() < 0.1


def amount_of(line: str) -> tuple[float, NDArray[np.float64]]:
    """Return area and centroid of a polygon with relative coordinates."""
    steps = np.array(re.findall(r"-?\d+", line), dtype=float).reshape(-1, 2)
    (x, y), (u, v) = (points := steps.cumsum(axis=0)).T, np.roll(points, -1, axis=0).T
    cross = x * v - y * u
    return 0.5 * cross.sum(), np.array(((x + u) @ cross, (y + v) @ cross)) / (3.0 * cross.sum())


def test_without_contact_there_is_a_page_that_says_so(tmp_path: Path) -> None:
    options = ["--shaft-angle-error-deg", "-3", "--cases", "20", "--out", "none.html"]
    done = subprocess.run([*COMMAND, *options], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 2
    assert done.stderr.startswith("No contact: the right flanks have no common normal")
    page = ReportPage((tmp_path / "none.html").read_text(encoding="utf-8"))
    assert "No path of contact was found on either flank of this pair." in page.words
    data = page.json("data")
    for flank in ("right", "left"):
        assert data["tca"][flank]["reason"] in page.words
        assert data["operation"][flank]["reason"] in page.words
        assert data["pattern"][flank]["reason"] == data["operation"][flank]["reason"]
        assert data["tolerance"][flank]["status"]["no_common_normal"] == 20
    assert "Not known throughout: contact ratio in operation; " in page.words
    assert "nan" not in page.words.lower().split()


@pytest.mark.slow
def test_measured_flanks_beside_nominal_ones(page: ReportPage, tmp_path: Path) -> None:
    (tmp_path / "points.txt").write_text(run("grid", "--pinion-modification", "helix_crowning=10").stdout)
    design = f'{builtin_text()}\n[pinion.modification]\ndeviations = "points.txt"\n'
    (tmp_path / "measured.toml").write_text(design)
    measured = written(tmp_path, str(tmp_path / "measured.toml"), "--cases", "20")
    assert "nominal flanks" in measured.words
    assert "nominal flanks" not in page.words
    shown = {attributes["data-key"]: text for attributes, text in measured.cells}
    numbers = measured.json("data")
    for flank in ("right", "left"):
        operation, pattern = (json_of(name, "--flank", flank) for name in ("operation", "pattern"))
        ratio = looked_up(numbers, f"operation.nominal.{flank}.operating_contact_ratio")
        assert ratio == operation["operating_contact_ratio"]
        assert shown[f"operation.nominal.{flank}.operating_contact_ratio"] == f"{ratio:.4f}"
        assert looked_up(numbers, f"operation.{flank}.operating_contact_ratio") != ratio
        area = looked_up(numbers, f"pattern.nominal.{flank}.pinion.area_share")
        assert area == looked_up(pattern, "pinion.area_share")


@pytest.mark.slow
def test_failed_section_and_reproducible_page(tmp_path: Path) -> None:
    """If the rounds of the tool overlap, the page has paths of contact and the reason for missing first
    contacts. Two runs write the same page."""
    options = ["--parabola-pinion", "0.01", "--cases", "20", "--out"]
    runs = [
        subprocess.Popen(
            [*COMMAND, *options, f"{seed}.html"],
            cwd=tmp_path,
            env={**os.environ, "PYTHONHASHSEED": seed, "SOURCE_DATE_EPOCH": "86400"},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for seed in "12"
    ]
    for process in runs:
        _, errors = process.communicate(timeout=300)
        assert (process.returncode, errors.count("\n")) == (4, 2)
        assert errors.startswith("Not computed: the first contact could not be computed: pinion: tip_radius")
    one, two = ((tmp_path / f"{seed}.html").read_bytes() for seed in "12")
    assert one == two
    page = ReportPage(one.decode())
    assert page.json("data")["made"] == "1970-01-02T00:00:00+00:00"
    data, shown = page.json("data"), {attributes["data-key"]: text for attributes, text in page.cells}
    for flank in ("right", "left"):
        reason = data["operation"][flank]["reason"]
        assert reason.startswith("the first contact could not be computed: pinion: tip_radius 0.38")
        assert f"Unknown {flank} flanks: {reason}" in " ".join(page.words.split())
        assert data["pattern"][flank]["reason"] == data["operation"][flank]["reason"]
        assert page.words.count(data["operation"][flank]["reason"]) >= 2
        assert f"operation.{flank}.peak_to_peak" not in shown
        assert float(shown[f"tca.{flank}.contact_ratio"]) > 0.0
    assert re.search("Not known throughout: [^.]*transmission error in operation, peak to peak;", page.words)
    assert "Not assessed: a calculation failed" in page.words
    titles = {attributes.get("id", "") for tag, attributes in page.tags if tag == "title"}
    assert {"path-left-title", "sliding-left-title", "cloud-right-title"} <= titles
    assert "error-left-title" not in titles
