"""Contract of bad input for all commands: exit status 2, one line with the cause, no file."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from beveloid_geom.cli.main import main
from tests.cli.running import refused, run

NARROW = "--pinion-bounds 0 0.0005 --gear-bounds -0.0005 0"
PAIR = "--module 4 --teeth 25 31 --shaft-angle-deg 20"
SOME = "--offset-tolerance 1"
CROWNED = "modify --transmission-error-arcsec 2 --length 20"
GEAR = "propose --gear ni-2017 --teeth 30 45 --shaft-angle-deg 15 --offset 235"
OVER_ANGLE = "map --over offset,shaft_angle --pinion-bounds"
BAD = {
    "": ("turn",),
    "design": ("ni-2017 ni-2017",),
    "tca": (
        *(
            "--points 1",
            "--points 100001",
            "--method six-equation",
            "--force 0",
            "--force nan",
            "--torque -1",
        ),
        *("--torque inf", "--force 1 --poisson 0.6", "--force 1 --youngs-modulus-mpa 0"),
    ),
    "operation": ("--film -1", "--film nan", "--harmonics 0", "--points 1"),
    "sliding": ("--points 1",),
    "pattern": ("--separation 0", "--over E", "--over E,P --cells 4"),
    "tolerance": (
        *("--offset-tolerance -1", "--offset-tolerance nan", "--shaft-angle-tolerance-deg 6", "--sigmas 0"),
        *("--sigmas nan", "--cases 0", "--jobs 0", "--seed -1"),
    ),
    "map": (
        *("--steps 1", "--pinion-bounds 0", "--pinion-bounds 1 0", "--gear-bounds nan 0.1"),
        "--over shift --gear-bounds 0 4",
    ),
    "optimise": (
        *("--offset-tolerance nan", f"{SOME} --pinion-bounds 1 0", f"{SOME} --contact-ratio 4 {NARROW}"),
        *(f"{SOME} --vary {more}" for more in ("pinion.crowning 0 5", "pinion.twist 5 0", "pinion.twist 0")),
        f"{SOME} --vary pinion.twist 0 1 --vary pinion.twist_um 0 2",
        f"{SOME} --vary pinion.twist 0 1 --pinion-bounds 0 0.001",
    ),
    "modify": (
        *("", "--length 20", "--transmission-error-arcsec 2 --length 50"),
        *("--transmission-error-arcsec 0 --length 20", "--transmission-error-arcsec 2 --length nan"),
        "--transmission-error-arcsec 2 --length 20 --out missing/pair.toml",
    ),
    "propose": (
        *("", "--teeth 25 31 --module 4", f"{PAIR} --cones-deg 3", f"{PAIR} --cones-deg 3 5 --least-cones"),
        *(f"{PAIR} --cones-deg {more}" for more in ("nan 5", "3 5 --backlash -1", "3 5 --count 6")),
        "--teeth 25 -31 --module 4 --shaft-angle-deg 20 --cones-deg 3 5",
        *(f"{PAIR} --gear missing.toml", f"{PAIR} --cones-deg 3 5 --out missing/a.toml"),
    ),
    "place": ("--at 0", "--at 100", "--at nan", "--by E"),
    "ease-off": ("--grid 2 5", "--grid 5 2", "--grid 5", "--flank right"),
    "statements": (),
    "shim": (
        *("", "--backlash -0.1", "--backlash nan", "--backlash 0.1 --at 100"),
        *("--backlash 0.1 --offset nan", "--backlash 0.1 --shaft-angle-deg 0"),
    ),
    "grid": (
        *("--member shaft", "--rows 1", "--columns 1000", "--border 50%", "--border nan%", "--border 40mm"),
        *("--border -1mm", "--border .mm"),
    ),
    "gear-data": (
        *("--pinion-ball 0", "--gear-ball nan", "--pinion-allowances -0.1", "--gear-allowances nan nan"),
        "--gear-allowances 0 inf",
    ),
    "check": ("--parabola-pinion nan", "ni-2017 ni-2017"),
    "sensitivity": ("--twist 1",),
    "mesh": (
        *("--part pinion", "--out a.stl", "--part shaft --out a.stl"),
        *("--part pinion-tooth --out a.stl --teeth 0", "--part pinion-tooth --out a.inp --element C3D4"),
        "--part pinion-flank --out a.vtu --field heat",
    ),
}
REQUIRING = "mesh", "modify", "propose", "shim"
"""Commands with required options, which are checked before the file."""
FOR_ALL = "--flank up", "--json --csv"
MESSAGES = {
    "tca --flan": "No such option '--flan'. Did you mean '--flank'? (see main tca --help)",
    "tca --flank": "Option '--flank' requires an argument.",
    "mesh": "Missing option '--part'. Choose from: pinion, gear, pair,",
    "mesh --part pair": "Missing option '--out'",
    "tca --json --csv": "--json and --csv exclude each other: give one of them (see main tca --help)",
    "shim --backlash 0.1 missing.toml": "missing.toml: cannot be read",
    f"{CROWNED} missing.toml": "missing.toml: cannot be read",
    "nope": "No such command 'nope'. (see main --help)",
    "tca --offset-error 0,05": (
        "--offset-error must be a number, got '0,05': write it with a decimal point, 0.05\n"
    ),
    "tca --offset-error 0.002in": (
        "--offset-error must be a number, got '0.002in': give it in mm without a unit, 0.0508\n"
    ),
    "tca --shaft-angle-error-deg 0.01rad": (
        "--shaft-angle-error-deg must be a number, got '0.01rad': give it in deg without"
    ),
    "tca --force 1,5": "--force must be a number, got '1,5': write it with a decimal point, 1.5\n",
    "gear-data --pinion-allowances -0,05 -0.1": "--pinion-allowances must be a number, got '-0,05': write it",
    "tca --offset-error nan": "--offset-error must be a finite number, got nan",
    "tca --shaft-angle-error-deg 90": "--shaft-angle-error-deg must be between -5 and 5 deg, got 90",
    "tca --pinion-axial-error 1e9": "--pinion-axial-error must be",
    "tca --force 1 --torque 1": "--force and --torque exclude each other: give one of them\n",
    "tca --poisson 0.3": "--youngs-modulus-mpa and --poisson need a load: give --force or --torque\n",
    "gear-data --pinion-allowances -50 -100": (
        "--pinion-allowances must be between -1.8 and 1.8 mm, got -50 -100: were they given in um?\n"
    ),
    "gear-data --gear-allowances -0.1 -0.05": (
        "--gear-allowances must be the upper and then the lower allowance, got -0.1 -0.05: swap them\n"
    ),
    "grid --border 10": "--border must be a percentage such as 10% or a length such as 2mm, got '10'\n",
    "grid --measured missing.csv": "cannot read missing.csv (No such file or directory): give the path",
    "tca --offset-error 61": "--offset-error must be between -60 and 60 mm (10 modules), got 61.0",
    "pattern --over offset": "--over must be two different errors, separated by a comma, got 'offset': ",
    "pattern --over E,E": "--over must be two different errors, separated by a comma, got 'E,E': ",
    "pattern --offset-tolerance 1": "--offset-tolerance is for patterns under two errors",
    "pattern --over E,P --offset-tolerance 1": "give the tolerances of both errors",
    "pattern --over E,P --shaft-angle-tolerance-deg 0.01": (
        "--shaft-angle-tolerance-deg is for an error that is not in --over"
    ),
    "place --by E,H": "--by must be two different errors",
    "place --l1 30": "--l1 must be on the pinion profile",
    "place --l1 nan": "--l1 must be on the pinion profile",
    "place --at 10,20": (
        "--at must be a number, got '10,20': write it with a decimal point, 10.2, or repeat the option, "
        "--at 10 --at 20\n"
    ),
    "place --at 10,20,5": "--at must be a number, got '10,20,5': repeat the option, --at 10 --at 20 --at 5",
    "place --at 50%": "Invalid value for '--at': '50%' is not a number. (see",
    "tca --force '1 kN'": "Invalid value for '--force': '1 kN' is not a number. (see",
    "tca --points 2.5": "Invalid value for '--points': '2.5' is not a whole number. (see",
    "ease-off --grid 3.5 4": "Invalid value for '--grid': '3.5' is not a whole number. (see",
    "tca --force 1,000": (
        "--force must be a number, got '1,000': write it with a decimal point, 1.000, or without the comma, "
        "1000\n"
    ),
    **{
        f"{command} --offset-tolerance 0": (
            f"at least one tolerance must be above 0, got 0 for --offset-tolerance{others}: "
            "omit all of them for the usual tolerances\n"
        )
        for command, others in {
            "tolerance": "",
            "tolerance --shaft-angle-tolerance-deg 0": ", --shaft-angle-tolerance-deg",
            "pattern --over E,G --gear-axial-tolerance 0": ", --gear-axial-tolerance",
            "map": "",
            "optimise": "",
        }.items()
    },
    "pattern --over E,G --offset-tolerance 0 --gear-axial-tolerance 0.1": (
        "--offset-tolerance must be positive and less than 60 mm on this pair, got 0 mm\n"
    ),
    "tolerance --offset-tolerance 100": "--offset-tolerance must be less than 60 mm on this pair, got 100 mm",
    "map --offset-tolerance 100": "--offset-tolerance must be less than 60 mm on this pair, got 100 mm",
    "tolerance --cases 10 --operation 100": (
        "--operation must be 0 to 10, the number of mountings, got 100: reduce it, or increase cases\n"
    ),
    "tolerance --distribution uniform --sigmas 2": (
        "--sigmas has no effect without --distribution normal: add --distribution normal, or omit --sigmas\n"
    ),
    "pattern --resolution 0.01": (
        "--resolution 0.01 mm needs more than 1,000,000 points: give at least 0.0247 mm\n"
    ),
    "design nope --list": "--list is for all designs and has no NAME, got 'nope': omit one of them\n",
    "design ni-2017 --list": "--list is for all designs and has no NAME, got 'ni-2017': omit one of them\n",
    f"propose {PAIR} --shifts 0.1 0.1 --shift-limits -0.1 0": (
        "--shift-limits has no effect with --shifts: omit one of them\n"
    ),
    f"propose {PAIR} --cones-deg 3 5 --cone-limits-deg 0 1": (
        "--cone-limits-deg has no effect with --cones-deg: omit one of them\n"
    ),
    f"propose {PAIR} --count 3 --pick 2": "--pick has no effect without --out: add --out, or omit --pick\n",
    **{
        f"{command} --overwrite{more}": words
        for command in (f"propose {PAIR}", "optimise", CROWNED)
        for more, words in {
            "": "--overwrite has no effect without --out: add --out, or omit --overwrite\n",
            " --out ''": "--out: . is a folder: give the name of a file\n",
            " --out .": "--out: . is a folder: give the name of a file\n",
            " --out -": "--out: - is standard output, which is for the result: give the name of a file\n",
        }.items()
    },
    "check ''": "'': cannot be read",
    f"{GEAR} --pressure-angle-deg 25": (
        "--pressure-angle-deg must be 20, the pressure angle of --gear, got 25: omit the option, or give"
    ),
    f"{GEAR} --face-widths 30 20": (
        "second value of --face-widths must be 60, the face width of --gear, got 20: omit the option"
    ),
    f"{GEAR} --module 3": "--module must be 6, the module of --gear, got 3: omit the option",
    **{
        f"check --pinion-modification '{amounts}'": f"--pinion-modification {words}"
        for amounts, words in {
            "": "cannot be read at ''",
            "helix_crowning": "cannot be read at 'helix_crowning'",
            "helix_crowning=1,5": (
                "cannot be read at '5': write amounts such as "
                '"helix_crowning=10, tip_relief=15, tip_relief_length=2.5", with decimal points, or none\n'
            ),
            "twist=1; left.twist=5": 'must have commas between the amounts, not ";": write them such as',
            "twist=1, twist_um=2": "has twist_um twice",
            "twist=1e6": "twist_um must be between -100000 and 100000 um, got 1000000.0",
            "right.twist=5um": "right.twist_um must be a number, got '5um': give it in um without a unit, 5",
            "helix_crownin=5": "helix_crownin is unknown: did you mean helix_crowning_um?",
            "tip_relief=5": "tip_relief_um needs tip_relief_length_mm",
            "both.twist=5": "both is unknown: tables for one flank are right and left",
            "right.deviations=points.csv": (
                "right.deviations can only be given in a design file: write it in [pinion.modification.right]"
            ),
        }.items()
    },
    "modify --transmission-error-arcsec 3 --length 100": (
        "--length must be below the face width of the pinion, 50 mm, got 100: reduce it\n"
    ),
    "modify --transmission-error-arcsec 3 --length 1e-6": (
        "no crownings within their limits give both values: the length is too small, or the separation or "
        "transmission error is too large\n"
    ),
    **{
        f"optimise {name} {value}": f"Invalid value for '{name}': {float(value)} is not in the range"
        for name, value in {
            "--transmission-error-arcsec": "-1",
            "--contact-ratio": "-1",
            "--off-centre": "0",
            "--shift": "0",
        }.items()
    },
    **{
        f"optimise --{member}-bounds {values}": f"--{member}-bounds {text}"
        for member in ("pinion", "gear")
        for values, text in {
            "-1 1": f"cannot be used: [{member}] parabola must be between -0.02",
            "0 0": "must be two finite bounds, the first below the second, got 0.0, 0.0\n",
        }.items()
    },
    "optimise --vary foo 0 20": "--vary foo is not an amount that can vary: known are pinion.helix_slope",
    "optimise --vary pinion.lead_crowning 9 0": "--vary pinion.lead_crowning must be two numbers, lower one",
    "optimise --vary pinion.tip_relief 0 9": "--vary pinion.tip_relief can vary only if its length is given",
    "propose --teeth -25 31": "--teeth must be at least 1, got -25: internal gears are not supported",
    "propose --module 3 --teeth 25 31": "--shaft-angle-deg is",
    "shim --backlash 0.1 --offset 300": "--offset minus that of the design must be between",
    "tca --parabola-pinion 1": "--parabola-pinion must be",
    "pattern --cells 5": "--cells has no effect without --over: add --over, or omit --cells\n",
    "map --over colour": "--over must be one of parabola, mounting, shift, or two different inputs of ",
    "map --over offset,shaft_angle": (
        "--pinion-bounds of offset must be given, because it has no usual range: give the lower and the "
        "upper limit in mm\n"
    ),
    f"{OVER_ANGLE} 228.9 229.1 --gear-bounds 14.9 15.1": (
        "--gear-bounds of shaft_angle must be between -3.14159 and 3.14159 rad, got 14.9: was it given in "
        "degrees?\n"
    ),
    f"{OVER_ANGLE} -5 229 --gear-bounds 0.2 0.3": (
        "--pinion-bounds of offset must be between 0 and 1e+09 mm, got -5.0: give the distance"
    ),
    f"{OVER_ANGLE} 229 228 --gear-bounds 0.2 0.3": (
        "--pinion-bounds of offset must be two finite values, lower one first, got 229.0, 228.0\n"
    ),
    "map --over helix_angle_gear,offset --pinion-bounds -6 0 --gear-bounds 228 229": (
        "--pinion-bounds of helix_angle_gear must be between -1.39626 and 1.39626 rad, got -6.0: was it given"
    ),
    "map --gear-bounds -0.1 0.1": (
        "--gear-bounds of parabola_gear cannot be used: [gear] parabola must be between -0.02"
    ),
    **{
        f"map --steps 2 --parabola-{member} 0.001": (
            f"--parabola-{member} cannot be given, as the map is over the parabola coefficients: "
            f"give --{member}-bounds, or another --over\n"
        )
        for member in ("pinion", "gear")
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


CONTRACT = {
    **{
        f"{command} {one}": ""
        for command, cases in BAD.items()
        for one in (*cases, *(FOR_ALL if command not in ("", "design", "mesh") else ()))
    },
    **{
        f"{name} {option.opts[0]} {' '.join(option.nargs * ['many'])}": f"'{option.opts[0]}': 'many' is not"
        for name, command in main.commands.items()
        for option in command.params
        if option.type.name in ("float", "float range", "integer", "integer range")
    },
    **{f"{name} missing.toml": "missing.toml" for name in main.commands if name not in REQUIRING},
    **MESSAGES,
}
"""Part of the expected line by arguments."""


def test_all_commands_are_covered() -> None:
    assert set(BAD) == {"", *main.commands}


@pytest.mark.parametrize(("arguments", "words"), CONTRACT.items(), ids=CONTRACT)
def test_bad_input(arguments: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bad input has the exit status 2, nothing on standard output, one line on standard error, and leaves no
    file."""
    monkeypatch.chdir(tmp_path)
    assert words in refused(*shlex.split(arguments))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", FILES)
def test_a_faulty_file_has_one_line(design_file: Callable[..., Path], command: str) -> None:
    """A fault in a file gives one line, which begins with the name of the file. The texts are tested in
    `tests/design`."""
    old, new, named = FILES[command]
    path = design_file({old: new})
    line = refused(command, path)
    assert line.startswith(f"Error: {path}: ")
    assert named in line


def test_several_faults_of_a_file(design_file: Callable[..., Path]) -> None:
    path = design_file({"teeth = 29": "teeth = 0"})
    path.write_text(path.read_text(encoding="utf-8").replace("face_width = 60.0", "face_width = -1.0"))
    lines = run("check", path).stderr.splitlines()
    keys = [line.split(": ")[2].split(" must")[0] for line in lines]
    assert keys == ["[pinion] teeth", "[gear] face_width"]


def test_tolerances_have_no_default() -> None:
    """A tolerance of 0 is used as such, so that the help must not show 0 as the default."""
    for command in ("tolerance", "map", "optimise", "pattern"):
        assert "default: 0.0;" not in run(command, "--help").stdout


@pytest.mark.parametrize("old", RENAMED)
def test_old_names_of_options(old: str) -> None:
    command, new = RENAMED[old]
    assert refused(command, old, "0.01") == f"Error: {old} has been renamed: use {new}\n"
    shown = run(command, "--help").stdout
    assert f"{old} " not in shown
    assert f"{new} " in shown
