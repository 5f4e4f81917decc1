"""What commands refuse, by one contract: status 2, nothing on standard output, one line with the cause."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from beveloid_geom.cli.main import main
from tests.cli.running import refused, run

NARROW = "--pinion-bounds 0 0.0005 --gear-bounds -0.0005 0"
PAIR = "--module 4 --teeth 25 31 --shaft-angle-deg 20"
SOME = "--offset-tolerance 1"
BAD = {
    "": ("turn",),
    "design": ("missing.toml", "ni-2017 ni-2017"),
    "tca": (
        *("--points 1", "--points 100001", "--points ten", "--method six-equation", "--offset-error much"),
        *("--force 0", "--force nan", "--force heavy", "--torque -1", "--torque inf"),
        *("--force 1 --poisson 0.6", "--force 1 --youngs-modulus-mpa 0"),
    ),
    "operation": ("--film -1", "--film nan", "--film thick", "--harmonics 0", "--points 1"),
    "sliding": ("--points 1",),
    "pattern": (
        *("--separation 0", "--resolution 0.01", "--over E", "--over E,E", "--over E,P --cells 4"),
        "--offset-tolerance 1",
    ),
    "tolerance": (
        *("", "--offset-tolerance -1", "--offset-tolerance nan", "--offset-tolerance 229"),
        *(f"{SOME} missing.toml", "--shaft-angle-tolerance-deg 6"),
        *(f"{SOME} {more}" for more in ("--sigmas 0", "--sigmas nan", "--cases 0", "--jobs 0", "--seed -1")),
    ),
    "map": (
        *("--over colour", "--steps 1", "--pinion-bounds 0", "--pinion-bounds 1 0", "--gear-bounds -0.1 0.1"),
        *(
            "--gear-bounds nan 0.1",
            "--over shift --gear-bounds 0 4",
            "--offset-tolerance 300",
            "missing.toml",
        ),
    ),
    "optimise": (
        *("", "--offset-tolerance nan", "--offset-tolerance wide", f"{SOME} missing.toml"),
        *(f"{SOME} --off-centre 0", f"{SOME} --pinion-bounds 1 0", f"{SOME} --contact-ratio 4 {NARROW}"),
        f"{SOME} --no-edges yes",
    ),
    "propose": (
        *(
            "",
            "--teeth 25 31 --module 4",
            f"{PAIR}",
            f"{PAIR} --cones-deg 3",
            f"{PAIR} --cones-deg 3 5 --least-cones",
        ),
        *(f"{PAIR} --cones-deg {more}" for more in ("nan 5", "3 5 --backlash -1", "3 5 --count 6")),
        *("--teeth 25 -31 --module 4 --shaft-angle-deg 20 --cones-deg 3 5", f"{PAIR} --gear missing.toml"),
        f"{PAIR} --cones-deg 3 5 --out missing/a.toml",
    ),
    "place": ("--at 0", "--at 100", "--at nan", "--by E", "--l1 30", "missing.toml"),
    "ease-off": ("--grid 2 5", "--grid 5 2", "--grid 5", "--grid a b", "missing.toml", "--flank right"),
    "statements": ("missing.toml",),
    "shim": (
        *("", "--backlash -0.1", "--backlash nan", "--backlash 0.1 --at 100", "--backlash 0.1 missing.toml"),
        *("--backlash 0.1 --offset nan", "--backlash 0.1 --shaft-angle-deg 0"),
    ),
    "grid": (
        *("--member shaft", "--rows 1", "--columns 1000", "--border 10", "--border 50%", "--border nan%"),
        *("--border 40mm", "--border -1mm", "--border .mm", "--measured missing.csv", "missing.toml"),
    ),
    "gear-data": (
        *(
            "--pinion-ball 0",
            "--gear-ball nan",
            "--pinion-ball big",
            "--pinion-allowances -0.1",
            "missing.toml",
        ),
        *("--gear-allowances nan nan", "--gear-allowances 0 inf"),
    ),
    "check": ("missing.toml", "--parabola-pinion nan", "ni-2017 ni-2017"),
    "sensitivity": ("--twist 1",),
    "mesh": (
        *("--part pinion", "--out a.stl", "--part shaft --out a.stl"),
        *("--part pinion --out a.stl --tolerance fine", "--part pinion-tooth --out a.stl --teeth 0"),
        *("--part pinion-tooth --out a.inp --element C3D4", "--part pinion-flank --out a.vtu --field heat"),
    ),
}
OF_ALL = "--flank up", "--json --csv"
TOLD = {
    "tca --offset-error nan": "--offset-error must be a finite number, got nan",
    "tca --shaft-angle-error-deg 90": "--shaft-angle-error-deg must be between -5 and 5 deg, got 90",
    "tca --pinion-axial-error 1e9": "--pinion-axial-error must be",
    "tca --force 1 --torque 1": "--force and --torque exclude each other: give one of them\n",
    "tca --poisson 0.3": (
        "--youngs-modulus-mpa and --poisson are of a loaded pair: give --force or --torque\n"
    ),
    "gear-data --pinion-allowances -50 -100": (
        "--pinion-allowances must be between -1.8 and 1.8 mm, got -50 -100: were they given in um?\n"
    ),
    "gear-data --gear-allowances -0.1 -0.05": (
        "--gear-allowances must be the upper and then the lower one, got -0.1 -0.05: swap them\n"
    ),
    "grid --border 10": "--border must be a share as 10% or a length as 2mm, got '10'\n",
    "grid --measured missing.csv": "cannot read missing.csv (No such file or directory)\n",
    "shim --backlash 0.1 --offset 300": "as measured less the design's: --offset-error must be between",
    "tca --parabola-pinion 1": "--parabola-pinion must be",
    **{
        f"map --steps 2 --parabola-{member} 0.001": (
            f"--parabola-{member}: the map itself is over the parabola coefficients: "
            f"give --{member}-bounds, or another --over\n"
        )
        for member in ("pinion", "gear")
    },
    **{
        command: f"{what}: give --offset-tolerance, --shaft-angle-tolerance-deg, --pinion-axial-tolerance, "
        "--gear-axial-tolerance, --centre-distance-tolerance, --in-plane-tolerance-deg or "
        "--out-of-plane-tolerance-deg\n"
        for command, what in {
            "optimise": "no errors that shift the path",
            "tolerance": "no tolerances",
        }.items()
    },
}
FILES = {
    "tca": ("teeth = 29", "", "[pinion] teeth"),
    "check": ("normal_module = 6.0", "normal_module = nan", "[tool] normal_module"),
    "map": ("\n[gear]", "\n[gear", "not valid TOML"),
}
RENAMED = {
    "--shaft-angle-error": ("tca", "--shaft-angle-error-deg"),
    "--transmission-error": ("optimise", "--transmission-error-arcsec"),
    "--offset": ("tolerance", "--offset-tolerance"),
    "--shaft-angle-deg": ("map", "--shaft-angle-tolerance-deg"),
    "--pinion-axial": ("optimise", "--pinion-axial-tolerance"),
    "--gear-axial": ("tolerance", "--gear-axial-tolerance"),
}


def test_no_command_is_left_out() -> None:
    assert set(BAD) == {"", *main.commands}


@pytest.mark.parametrize(
    "arguments",
    [
        f"{command} {one}"
        for command, own in BAD.items()
        for one in (*own, *(OF_ALL if command not in ("", "design", "mesh") else ()))
    ],
)
def test_bad_input_has_one_error(arguments: str) -> None:
    result = run(*arguments.split())
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("Error: ") == 1
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("arguments", TOLD)
def test_the_option_and_its_limits_are_named(arguments: str) -> None:
    assert refused(*arguments.split()).startswith(f"Error: {TOLD[arguments]}")


@pytest.mark.parametrize("command", FILES)
def test_a_faulty_file_has_one_line(design_file: Callable[..., Path], command: str) -> None:
    """In which words is tested where they are written, in `tests/design`."""
    old, new, named = FILES[command]
    path = design_file(old, new)
    line = refused(command, path)
    assert line.startswith(f"Error: {path}: ")
    assert named in line


def test_every_fault_has_its_line(design_file: Callable[..., Path]) -> None:
    path = design_file("teeth = 29", "teeth = 0")
    path.write_text(path.read_text(encoding="utf-8").replace("face_width = 60.0", "face_width = -1.0"))
    lines = run("check", path).stderr.splitlines()
    keys = [line.split(": ")[2].split(" must")[0] for line in lines]
    assert keys == ["[pinion] teeth", "[gear] face_width"]


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00\x01", b""], ids=["folder", "binary", "empty"])
def test_unreadable_file(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path
    if content is not None:
        path = tmp_path / "odd.toml"
        path.write_bytes(content)
    result = run("tca", path)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"Error: {path}: ")


@pytest.mark.parametrize("old", RENAMED)
def test_an_old_name_of_an_option_leads_to_the_new_one(old: str) -> None:
    command, new = RENAMED[old]
    assert refused(command, old, "0.01") == f"Error: {old} has a new name: write {new}\n"
    shown = run(command, "--help").stdout
    assert f"{old} " not in shown
    assert f"{new} " in shown
