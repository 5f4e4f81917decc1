"""The command `render-report`: one page that needs nothing else, with the numbers of the commands."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from beveloid_geom import Design, Errors, Pair, Tolerances, builtin_design, tolerance_study
from beveloid_geom.analysis.tolerance import UNIT, USUAL
from beveloid_geom.cli.main import main as beveloid_geom
from beveloid_geom.design.file import BUILTINS, builtin_text
from beveloid_geom.findings.advice import findings_on
from beveloid_geom.report.tolerance import ToleranceReport, tolerance_remarks
from beveloid_viz.report import svg
from beveloid_viz.report.cells import UNITS
from beveloid_viz.report.cli import _written, main
from beveloid_viz.report.data import CLOUD, Settings, _cloud, _tolerances, compute, failed_mountings
from beveloid_viz.report.page import looked_up, number_of, parted, script_json, with_code
from tests.symmetry import scaled

COMMAND = [str(Path(sys.executable).with_name("render-report"))]
WITHOUT_VTK = [
    *(sys.executable, "-c"),
    "import sys; from beveloid_viz.report.cli import main; main(standalone_mode=False);"
    "sys.exit(9 if {'vtkmodules', 'vtk', 'pyvista'} & set(sys.modules) else 0)",
]
NAME = Path("x<", "script><img src=x onerror=alert(1)> & \"'.toml")
"""A path that closes a script element and opens others."""
TOLERANCES = ("--offset-tolerance", "0.04", "--gear-axial-tolerance", "0.2", "--seed", "7", "--cases", "300")
MOST_BYTES = 4_000_000


class Page(HTMLParser):
    """Tags with attributes, texts of script elements, and the texts of cells with their attributes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.scripts: list[tuple[dict[str, str], str]] = []
        self.cells: list[tuple[dict[str, str], str]] = []
        self.words = ""
        self.inside = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {name: value or "" for name, value in attrs}))
        self.inside = True

    def handle_endtag(self, tag: str) -> None:
        self.inside = False

    def handle_data(self, data: str) -> None:
        tag, attributes = self.tags[-1] if self.inside else ("", {})
        if tag == "script":
            self.scripts.append((attributes, data))
        elif tag != "style":
            self.words += f" {' '.join(data.split())}"
            if "data-key" in attributes:
                self.cells.append((attributes, data))

    def json(self, name: str) -> Any:
        return json.loads(next(text for attributes, text in self.scripts if attributes.get("id") == name))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With the paper's pair, modified, under a name that is not to be trusted."""
    folder = tmp_path_factory.mktemp("report")
    source = folder / NAME
    source.parent.mkdir()
    text = builtin_text().replace("parabola = 0.0  ", "parabola = 0.001  ", 1)
    source.write_text(text.replace("parabola = 0.0\n", "parabola = -0.001\n"), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def text(folder: Path) -> str:
    """The page, made without a trace of VTK."""
    run = subprocess.run(
        [*WITHOUT_VTK, str(NAME), "--out", "page.html", *TOLERANCES],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert re.fullmatch(r".*page\.html: \d\.\d\d MB, made in \d+\.\d s\n", run.stdout)
    assert 100_000 < (folder / "page.html").stat().st_size < MOST_BYTES
    return (folder / "page.html").read_bytes().decode()


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


@pytest.mark.slow
def test_nothing_is_fetched(page: Page, text: str) -> None:
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


def test_it_says_which_file_when_and_which_version(page: Page, folder: Path) -> None:
    """Near the top, before the contents; and the numbers that are saved carry it too."""
    data, head = page.json("data"), page.words[: page.words.index("Summary")]
    assert (data["name"], data["version"]) == (str(NAME), version("beveloid-geom"))
    made, written = (datetime.fromisoformat(data[name]) for name in ("made", "written"))
    assert abs(datetime.now(UTC) - made) < timedelta(hours=2)
    assert abs(written.timestamp() - (folder / NAME).stat().st_mtime) <= 1.0
    assert f"Design file {NAME} of {written:%Y-%m-%d %H:%M}" in head
    assert f"page made {made:%Y-%m-%d %H:%M}" in head
    assert f"by beveloid-geom {data['version']}" in head
    assert page.words.count(f"Numbers of {NAME}") >= 6


def test_the_time_of_a_copied_file_is_not_later_than_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SOURCE_DATE_EPOCH bounds it, so that a page made of a fresh copy is the same to the byte."""
    file = tmp_path / "pair.toml"
    file.write_text(builtin_text(), encoding="utf-8")
    os.utime(file, (1e9, 1e9))
    assert [_written(name) for name in BUILTINS] == [None] * len(BUILTINS)
    for epoch, expected in ((None, 1e9), ("1000000007", 1e9), ("999999999", 999999999.0)):
        if epoch:
            monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
        found = _written(str(file))
        assert found is not None
        assert found.timestamp() == expected


def test_the_verdict_leads_with_errors_and_warnings(page: Page) -> None:
    """All that `check` and `tca` say and the share of lost mountings: what matters before the contents, the
    rest in the summary."""
    data, words = page.json("data"), " ".join(page.words.split())
    contents = words.index("Summary In mesh")
    assert words.index("Works with reservations") < contents
    sections = [data["check"], *data["tca"].values(), *data["tolerance"].values()]
    for level, before in (("errors", True), ("warnings", True), ("notes", False)):
        for text in (text for section in sections for text in section[level]):
            assert (words.index(" ".join(text.replace("`", " ").split())) < contents) is before
    assert any("an edge touches earlier" in text for text in data["check"]["warnings"])
    assert re.search(r"mountings fails? under the tolerances given", words[:contents])


@pytest.mark.parametrize(
    ("options", "verdict", "level"),
    [
        ((), "Nothing found against it", "note"),
        (("--offset-error", "-0.2"), "Does not work as it stands : 1 error, 1 warning", "error"),
    ],
)
def test_verdicts(options: tuple[str, ...], verdict: str, level: str, tmp_path: Path) -> None:
    """Without modification what is zero takes a line: neither charts nor rows."""
    run = CliRunner().invoke(main, [*options, "--cases", "40", "--out", str(tmp_path / "page.html")])
    assert run.exit_code == 0, run.stderr
    page = Page((tmp_path / "page.html").read_text(encoding="utf-8"))
    words, data = " ".join(page.words.split()), page.json("data")
    assert words.index(verdict) < words.index("Summary In mesh")
    assert ("div", {"class": f"verdict {level}"}) in page.tags
    assert ("svg", "pair-picture") in [(tag, attributes.get("class")) for tag, attributes in page.tags]
    failed = 40 if options else 0
    assert data["mountings"]["failed"] == data["mountings"]["jammed"] == failed
    share = (
        "100 % of 40 mountings fail under usual tolerances: 100 % jammed."
        if failed
        else "None of 40 mountings"
    )
    assert "".join(share.split()) in "".join(words.split())
    assert "zero but for rounding, under 0.000001 arcsec, on both flanks." in words
    titles = {attributes.get("id", "") for tag, attributes in page.tags if tag == "title"}
    assert {
        "path-left-title",
        "sensitivity-right-title",
        "ease-off-left-title",
        "pressure-right-title",
    } <= titles
    assert not {"error-right-title", "error-left-title", "spectrum-right-title"} & titles
    keys = {attributes["data-key"] for attributes, _ in page.cells}
    zero = [key for key in keys if re.search("peak_to_peak|amplitudes|edge_share", key)]
    assert zero == []
    assert "Zero throughout: transmission error in operation, peak to peak; part of the cycle" in words
    assert words.count("Transmission error, and what edges carry: zero in all.") == (0 if options else 2)
    assert words.count("no cell of the matrix has a pattern") == (2 if options else 0)
    assert words.count("Zero throughout: transmission error along the path.") == 4  # two of each flank


def test_pressures_are_those_of_the_torque_given(tmp_path: Path) -> None:
    options, out = ("--torque", "500"), tmp_path / "page.html"
    run = CliRunner().invoke(main, [*options, "--cases", "20", "--out", str(out)])
    assert run.exit_code == 0, run.stderr
    page = Page(out.read_text(encoding="utf-8"))
    printed = CliRunner().invoke(beveloid_geom, ["tca", "--flank", "left", *options, "--json"]).stdout
    assert page.json("data")["hertz"]["left"] == json.loads(printed)["hertz"]
    words = " ".join(page.words.split())
    assert "steel on steel, under 500 N m on the pinion: pressures grow" in words
    assert "beveloid-geom tca --torque 500" in words
    texts = [text for at, text in page.cells if at["data-key"].startswith("hertz.left.pressure.")]
    assert texts == [f"{max(json.loads(printed)['hertz']['pressure']):.1f}"]


def test_a_row_of_zeros_takes_a_line_and_others_do_not() -> None:
    numbers = {"right": {"a": 0.0, "b": 1e-12, "c": None, "d": 2.0}, "left": {"a": 0, "b": 2e-4, "c": 0.0}}
    rows = [
        ("fifth", "*.e", 2),
        ("first", "*.a", 3),
        ("second", "*.b", 3),
        ("third", "*.c", 1, "mm"),
        ("fourth", "*.d", 0, "", 3.0),
    ]
    shown, left = parted(numbers, {}, rows, [("right", "right", 1.0), ("left", "left", 2.0)])
    assert left == {"Zero": ["first"], "Not known": ["fifth"]}
    assert [(label, unit) for label, unit, _ in shown] == [("second", ""), ("third", "mm"), ("fourth", "")]
    texts = [[re.sub("<.*?>", "", str(cell)) for cell in cells] for *_, cells in shown]
    assert texts == [["0.000", "0.000"], ["\u2013", "0.0"], ["6", "\u2013"]]


def test_mountings_fail_without_contact_below_one_and_jammed() -> None:
    """Counted one by one, of a pair that is close to all three; each mounting once."""
    design = builtin_design().with_errors(Errors(offset=-0.11))
    wide = Tolerances(0.1, math.radians(0.5), 0.1, 0.1)
    studies = [tolerance_study(design, wide, flank, 300) for flank in ("right", "left")]
    found, lost, short, jammed = failed_mountings(list(studies)), set(), set(), set()
    for one in (study.mountings for study in studies):
        for case in range(300):
            if not one.solved[case]:
                lost.add(case)
            elif one.contact_ratio[case] < 1.0:
                short.add(case)
            if one.jammed[case]:
                jammed.add(case)
    counts = {"without_contact": len(lost), "contact_ratio_below_1": len(short), "jammed": len(jammed)}
    assert found == {"cases": 300, "failed": len(lost | short | jammed), **counts}
    assert 0 < len(lost) < 300
    assert 0 < len(jammed) < 300
    assert failed_mountings([None, None]) == {}


def test_lost_mountings_are_a_warning() -> None:
    """A pair of its own, whose right flanks lose contact in some 15 % of the mountings."""
    table1 = builtin_design()
    tool = replace(table1.pinion.tool, normal_module=4.0)
    pinion = replace(table1.pinion, tool=tool, teeth=25)
    gear = replace(
        table1.gear, tool=tool, teeth=31, cone_angle=math.radians(5.0), helix_angle=math.radians(-6.64)
    )
    design = Design(pinion, gear, Pair(111.6066, math.radians(20.0)))
    study = tolerance_study(design, USUAL, "right", 100)
    (remark,) = tolerance_remarks(study)
    share = 1.0 - np.count_nonzero(study.mountings.solved) / study.cases
    assert 0.08 < share < 0.25
    assert remark.level == "warning"
    assert remark.text.startswith(f"right flanks: {100.0 * share:.3g} % of mountings have no contact")
    assert ToleranceReport("own", design, study).data()["warnings"] == [remark.text]
    told = [found.text for found in findings_on(design) if found.level == "warning"]
    assert told[0].startswith("right flanks: sensitive to errors")
    assert "0.01 deg of shaft angle shifts the path on the pinion by 57.3 mm along its face" in told[0]
    assert told[1].endswith("at an error of shaft angle +0.01 deg or shaft angle -0.01 deg")
    assert tolerance_remarks(tolerance_study(design, USUAL, "left", 100)) == ()


def test_a_name_cannot_become_code(page: Page, text: str) -> None:
    assert str(NAME) in page.words
    assert page.json("data")["tca"]["left"]["design"] == str(NAME)
    assert "<img src=x" not in text
    assert sum(tag == "script" for tag, _ in page.tags) == len(page.scripts) == 6


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
        (("statements",), "statements"),
        (("ease-off", "--grid", "9", "13"), "ease_off"),
        (("tca", "--flank", "left", "--force", "1000"), "hertz.left"),
        (("gear-data",), "gear_data"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_its_data_are_those_of_the_command(
    page: Page, folder: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], keys: str
) -> None:
    monkeypatch.chdir(folder)
    name, *options = command
    result = CliRunner().invoke(beveloid_geom, [name, str(NAME), *options, "--json"])
    assert (result.exit_code, result.stderr) == (0, "")
    printed = json.loads(result.stdout)
    section = keys.partition(".")[0]
    assert (printed["hertz"] if section == "hertz" else printed) == looked_up(page.json("data"), keys)


def test_every_number_shown_is_that_of_the_data(page: Page) -> None:
    data = page.json("data")
    assert len(page.cells) > 250
    for attributes, text in page.cells:
        found: Any = data
        for part in attributes["data-key"].split("."):
            found = found[int(part)] if isinstance(found, list) else found[part]
        value, digits = found * float(attributes["data-scale"]), int(attributes["data-digits"])
        shown = float(text.replace("\u2212", "-"))
        if attributes.get("data-format") == "g":
            assert shown == pytest.approx(value, rel=10.0 ** (1 - digits), abs=1e-300)
        else:
            assert len(text.partition(".")[2]) == digits
            assert abs(shown - value) <= 0.5000001 * 10.0**-digits, attributes
    keys = {attributes["data-key"].partition(".")[0] for attributes, _ in page.cells}
    sections = {"check", "tca", "operation", "sliding", "sensitivity", "tolerance", "pattern", "design"}
    assert keys == sections | {"ease_off", "hertz", "mountings", "matrix", "gear_data"}


def test_every_chart_has_a_title_and_the_pages_colours(page: Page, text: str) -> None:
    charts = re.findall(r'<svg class="drawing".*?</svg>', text, flags=re.S)
    assert len(charts) == 20
    titles = {re.search(r"<title[^>]*>(.*?)</title>", chart)[1] for chart in charts}  # type: ignore[index]
    assert len(titles) == 20
    for chart in charts:
        assert not re.search(r"#[0-9a-fA-F]{6}\b|rgb\(|<style|font-family", chart)
        assert 'role="img"' in chart


def test_patterns_under_errors_are_drawn_as_the_numbers_say(page: Page, text: str) -> None:
    """The middle of what is shaded is the centre of the ellipse, which has the half axes told; a cell
    that cannot be assembled says so."""
    cells = re.findall(r'<td>(?:<svg class="cell".*?</svg>|<span class="none">jammed<)', text, flags=re.S)
    known = [cell for flank in ("right", "left") for cell in page.json("data")["matrix"][flank]["cells"]]
    assert len(cells) == len(known) == 18
    assert 0 < sum(cell["status"] == "jammed" for cell in known) < 9
    shown = [(drawn, own["pinion"]) for drawn, own in zip(cells, known, strict=True) if own["pinion"]]
    assert sum("<svg" in drawn for drawn in cells) == len(shown)
    places = []
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
        places.append((x / UNITS - ellipse["z"], y / UNITS + ellipse["r"]))
    assert np.ptp(places, axis=0).max() < 0.1  # the same flank, to where a path has fractions of a unit


def amount_of(line: str) -> tuple[float, NDArray[np.float64]]:
    """Area and centroid of a polygon written from point to point."""
    steps = np.array(re.findall(r"-?\d+", line), dtype=float).reshape(-1, 2)
    (x, y), (u, v) = (points := steps.cumsum(axis=0)).T, np.roll(points, -1, axis=0).T
    cross = x * v - y * u
    return 0.5 * cross.sum(), np.array(((x + u) @ cross, (y + v) @ cross)) / (3.0 * cross.sum())


def test_without_contact_there_is_a_page_that_says_so(tmp_path: Path) -> None:
    options = ["--shaft-angle-error-deg", "-3", "--cases", "20", "--out", "none.html"]
    run = subprocess.run([*COMMAND, *options], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr.count("\n") == 2
    assert run.stderr.startswith("No contact, right flanks: the right flanks have no common normal")
    page = Page((tmp_path / "none.html").read_text(encoding="utf-8"))
    assert "There is no path of contact on either flank of this pair." in page.words
    data = page.json("data")
    for flank in ("right", "left"):
        assert data["tca"][flank]["reason"] in page.words
        assert data["operation"][flank]["reason"] in page.words
        assert data["pattern"][flank]["reason"] == data["operation"][flank]["reason"]
        assert data["tolerance"][flank]["status"]["no_common_normal"] == 20
    assert "Not known throughout: contact ratio in operation; " in page.words
    assert "nan" not in page.words.lower().split()


@pytest.mark.slow
def test_a_section_that_fails_leaves_the_others_and_two_runs_give_the_same_bytes(tmp_path: Path) -> None:
    """Here the tool's rounds overlap: there are paths of contact, but no fillets to look for others."""
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
    for run in runs:
        _, errors = run.communicate(timeout=300)
        assert (run.returncode, errors) == (0, "")
    one, two = ((tmp_path / f"{seed}.html").read_bytes() for seed in "12")
    assert one == two
    page = Page(one.decode())
    assert page.json("data")["made"] == "1970-01-02T00:00:00+00:00"
    data, shown = page.json("data"), {attributes["data-key"]: text for attributes, text in page.cells}
    for flank in ("right", "left"):
        assert data["operation"][flank]["reason"].startswith("no first contact: pinion: tip_radius 0.38")
        assert data["pattern"][flank]["reason"] == data["operation"][flank]["reason"]
        assert page.words.count(data["operation"][flank]["reason"]) >= 2
        assert f"operation.{flank}.peak_to_peak" not in shown
        assert float(shown[f"tca.{flank}.contact_ratio"]) > 0.0
    assert re.search("Not known throughout: [^.]*transmission error in operation, peak to peak;", page.words)
    titles = {attributes.get("id", "") for tag, attributes in page.tags if tag == "title"}
    assert {"path-left-title", "sliding-left-title", "cloud-right-title"} <= titles
    assert "error-left-title" not in titles


def test_the_cloud_shows_the_first_mountings_of_the_study() -> None:
    """Their errors add to those of the design, each to its own."""
    design = builtin_design().with_parabola(0.001, -0.001)
    design = design.with_errors(Errors(0.1, 1e-4, 0.2, -0.1))
    study = tolerance_study(design, Tolerances(0.05, 1e-4, 0.3, 0.1), "right", 2 * CLOUD)
    cloud = _cloud(design, study)
    ratio = study.mountings.contact_ratio[:CLOUD]  # solved together with others: to rounding
    np.testing.assert_allclose(cloud.ends.contact_ratio, ratio, rtol=1e-12)


def test_usual_tolerances_too_wide_for_a_pair_are_a_reason_and_given_ones_a_refusal() -> None:
    design = scaled(builtin_design(), 0.004 / 6.0)  # 0.05 mm are more than ten of its modules
    done = list[str]()
    for result, text, reason in _tolerances("small", design, Settings(cases=5), done.append, None).values():
        assert result is None
        assert json.loads(text)["reason"] == reason
        assert "tolerance of offset must be less" in str(reason)
    with pytest.raises(ValueError, match="tolerance of offset must be less"):
        _tolerances("small", design, Settings(Tolerances(offset=1.0), True, 5), done.append, None)


def test_pieces_of_text() -> None:
    numbers = {"a": {"b": [1.0, -2e-9, None]}, "c": 0.5}
    assert ">\u22120.25<" in number_of({"x": -0.25}, "x", 2)
    assert ">0.000<" in number_of(numbers, "a.b.1", 3)
    assert [">\u2013<" in number_of(numbers, key, 3) for key in ("a.b.2", "a.b.9", "a.z.1", "c.d")] == [
        True
    ] * 4
    assert ">28.65<" in number_of(numbers, "c", 2, 57.29577951308232)
    assert "</" not in script_json({"<": "</script>&"})
    assert json.loads(script_json({"<": "</script>&"})) == {"<": "</script>&"}
    assert with_code("see `<a>` & b") == "see <code>&lt;a&gt;</code> &amp; b"


def test_charts_keep_their_numbers_and_share_no_ids() -> None:
    with svg.style():
        chart = svg.new_chart(100.0)
        axes = chart.add_subplot()
        axes.plot([0.0, 1.0], [0.0, 1.0])
        axes.text(0.1234567, 0.5, "0.0006 & 1.23456 <b>")
        axes.set_title("heading", fontweight="bold")
        one, two = (svg.svg_of(chart, name, "<&>") for name in ("one", "two"))
    assert "0.0006 &amp; 1.23456 &lt;b&gt;" in one
    assert ">&lt;&amp;&gt;</title>" in one
    assert len(re.findall("font-weight: (?:bold|700)", one)) == 1
    ids = re.findall(r'\bid="([^"]*)"', one)
    assert ids
    assert not set(ids) & set(re.findall(r'\bid="([^"]*)"', two))
    assert set(re.findall(r'(?:href="|url\()#([^")]*)', one)) <= set(ids)
    assert not re.search(r'd="[^"]*\d\.\d{3}', one)


@pytest.mark.slow
def test_progress_counts_the_mountings() -> None:
    calls: list[str] = []
    settings = Settings(cases=2 * UNIT + 1)
    compute("ni-2017", builtin_design(), settings, calls.append)
    assert len(calls) == settings.steps
    assert calls.count("tolerance") == 1 + 3
