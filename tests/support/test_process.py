"""Interrupts of the commands, output that cannot be written, and exit statuses.

An interrupted command has an exit status of its own, prints one line and leaves no file. Status 1 is reserved
for "no contact"."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

import beveloid_geom

BIN = Path(sys.executable).parent
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="no signals between processes here")
LONG = {
    "figures": ("render-figures", "--out", "{}", "--size", "400x300"),
    "film": ("render-animation", "--out", "{}/mesh.gif", "--size", "300x200", "--pitches", "20"),
    "report": ("render-report", "--out", "{}/page.html", "--cases", "500000"),
    "jobs": ("beveloid-geom", "tolerance", "--offset-tolerance", "0.05", "--cases", "1000000", "--jobs", "2"),
    "map": ("beveloid-geom", "map", "--steps", "201"),
    "mesh": ("beveloid-geom", "mesh", "--part", "pair", "--tolerance", "1e-4", "--out", "{}/pair.stl"),
}
COMMANDS = ("beveloid-geom", "render-figures", "render-animation", "render-report")


def python(code: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Return the result of a Python program."""
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **options)


def as_command(main: str) -> str:
    """Return a program that runs the function `main`, which the text defines, as a command."""
    return (
        "import os, signal, sys, types\nfrom beveloid_geom.support import process\n"
        f"{main}\n"
        "if __name__ == '__main__':\n"
        "    process.import_module = lambda _: types.SimpleNamespace(main=main)\n"
        "    process.run('')\n"
    )


def restore_ctrl_c() -> None:
    """Restore the usual effect of Ctrl-C, because a shell makes processes in the background ignore it, which
    their children inherit."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def started(arguments: Sequence[str], folder: Path) -> subprocess.Popen[str]:
    """Return the process of a command in its own process group, once it handles signals."""
    process = subprocess.Popen(
        [BIN / arguments[0], *(word.format(folder) for word in arguments[1:])],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=restore_ctrl_c,
    )
    state = Path(f"/proc/{process.pid}/status")
    while state.exists() and process.poll() is None and not _catches(state.read_text(), signal.SIGTERM):
        time.sleep(0.002)
    return process


def _catches(state: str, number: int) -> bool:
    caught = next((line for line in state.splitlines() if line.startswith("SigCgt:")), "SigCgt: 0")
    return bool(int(caught.split()[1], 16) >> (number - 1) & 1)


@pytest.mark.slow
@POSIX
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "sigterm"])
@pytest.mark.parametrize("command", LONG)
def test_an_interrupt_at_any_time(command: str, number: signal.Signals, tmp_path: Path) -> None:
    """An interrupt at random moments, from the first import to the middle of the calculation, ends the
    command properly. The moments differ in every run."""
    for longest in (0.0, 1.0) if number == signal.SIGINT else (0.3, 3.0):
        delay = random.uniform(0.5, 1.0) * longest
        with started(LONG[command], tmp_path) as process:
            time.sleep(delay)
            assert process.poll() is None, "it was finished too early"
            os.killpg(process.pid, number)
            out, errors = process.communicate(timeout=60)
        assert (process.returncode, out) == (128 + number, ""), (delay, errors)
        last = errors.splitlines()[-1]
        assert last.startswith("Error: interrupted"), (delay, errors)
        assert "Traceback" not in errors
        assert errors.count("Error") == errors.count("interrupted") == 1, (delay, errors)
        assert all(file.suffix in (".png", ".csv") for file in tmp_path.iterdir()), delay
        with pytest.raises(ProcessLookupError):  # noqa: PT012
            end = time.monotonic() + 20.0  # a test of OpenGL or the resource tracker may take time to end
            while time.monotonic() < end:
                os.killpg(process.pid, 0)
                time.sleep(0.02)


@POSIX
def test_an_interrupt_while_workers_start() -> None:
    """Ctrl-C, which reaches all processes of a terminal, just after the first worker was started."""
    code = as_command(
        "def main():\n"
        "    from multiprocessing import util\n"
        "    spawn = util.spawnv_passfds\n"
        "    def start(*arguments):\n"
        "        child = spawn(*arguments)\n"
        "        if '--multiprocessing-fork' in arguments[1]:\n"
        "            os.killpg(0, signal.SIGINT)\n"
        "        return child\n"
        "    util.spawnv_passfds = start\n"
        "    with process.workers(2) as pool:\n"
        "        print(pool.submit(int).result())"
    )
    done = python(code, start_new_session=True, preexec_fn=restore_ctrl_c)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Error: interrupted\n")


@POSIX
def test_an_interrupt_during_a_message() -> None:
    """An interrupt while standard error is being written prints its message after the output and ends the
    process with status 143."""
    code = as_command("def main():\n    while True:\n        sys.stderr.write('.' * 100)")
    for _ in range(4):
        with subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE) as process:
            assert process.stderr is not None
            process.stderr.read(random.randrange(1, 100_000))
            process.send_signal(signal.SIGTERM)
            errors = process.communicate(timeout=60)[1]
        assert process.returncode == 143
        assert errors.strip(b".") == b"\nError: interrupted\n"


def shell(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    path = f"{BIN}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        cwd=folder,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@POSIX
@pytest.mark.parametrize(
    ("command", "status", "errors"),
    [
        *((f"{name} --help > /dev/full", 2, "No space left on device") for name in COMMANDS),
        ("beveloid-geom --version >&-", 2, "Bad file descriptor"),
        ("beveloid-geom tca --points 9 --csv >&-", 2, "Bad file descriptor"),
        ("beveloid-geom tca --points 9 --csv 2>&- >table.csv", 0, ""),
        ("beveloid-geom tca missing.toml 2>&-", 2, ""),
        ("beveloid-geom tca missing.toml 2>/dev/full", 2, ""),
        ("beveloid-geom map --steps 3 2>/dev/full >table.csv", 0, ""),
        ("beveloid-geom mesh --part pinion-tooth --out tooth.stl 2>&-", 0, ""),
        ("render-figures --only fig-02 --size 300x200 --out . 2>/dev/full", 0, ""),
        ("render-figures --only fig-02 --size 300x200 --out . 2>&-", 0, ""),
        ("beveloid-geom tca --points 20000 --no-certify --csv | head -n 1", 141, ""),
        ("beveloid-geom tca missing.toml 2>&1 >table.csv | true", 2, ""),
    ],
    ids=lambda value: str(value) if isinstance(value, str) and "-" in value else "",
)
def test_output_that_cannot_be_written(command: str, status: int, errors: str, tmp_path: Path) -> None:
    done = shell(command, tmp_path)
    line = f"Error: cannot write to standard output: {errors}\n" if errors else ""
    assert (done.returncode, done.stderr) == (status, line)


def test_an_internal_error_has_another_status_than_no_contact() -> None:
    done = python("from beveloid_geom.support.process import run; run('beveloid_geom.no_such_module')")
    assert done.returncode == 70
    assert "ModuleNotFoundError" in done.stderr


@POSIX
@pytest.mark.parametrize(
    ("count", "line"),
    [(1, "0.stl is not written"), (20, "0.stl is not written, nor are 19 others")],
)
def test_an_interrupt_of_many_files_is_one_short_line(count: int, line: str, tmp_path: Path) -> None:
    code = as_command(
        "from contextlib import ExitStack\nfrom pathlib import Path\n"
        "from beveloid_geom.support.atomic_file import atomic_file\n"
        "def main():\n"
        "    with ExitStack() as stack:\n"
        f"        [stack.enter_context(atomic_file(Path(f'{{i}}.stl'))) for i in range({count})]\n"
        "        os.kill(os.getpid(), signal.SIGTERM)"
    )
    done = python(code, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (143, f"Error: interrupted: {line}\n")
    assert not list(tmp_path.iterdir())


@POSIX
def test_an_interrupt_leaves_no_empty_folder(tmp_path: Path) -> None:
    out = tmp_path / "new" / "figures"
    asked = ["render-figures", "--only", "tolerance-cloud", "--out", "{}/new/figures"]
    with started(asked, tmp_path) as process:
        end = time.monotonic() + 60.0
        while not out.exists() and time.monotonic() < end:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGTERM)
        process.communicate(timeout=60)
    assert process.returncode == 143
    assert not list(tmp_path.iterdir())


@POSIX
def test_signals_that_are_ignored_stay_ignored() -> None:
    code = "import os, signal\nfrom beveloid_geom.support.process import _handle_signals\n_handle_signals()\n"
    code += "os.kill(os.getpid(), signal.SIGHUP)\nos.kill(os.getpid(), signal.SIGINT)\n"
    ignored = "trap '' HUP; exec " + f"{sys.executable} -c '{code}'"
    done = subprocess.run(
        ["bash", "-c", ignored], capture_output=True, text=True, check=False, preexec_fn=restore_ctrl_c
    )
    assert (done.returncode, done.stderr) == (130, "Error: interrupted\n")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_its_version(command: str) -> None:
    done = subprocess.run([BIN / command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"{command}, version {beveloid_geom.__version__}\n"


def test_the_version_is_known_without_metadata() -> None:
    """The version is printed without metadata of the package, which frozen programs and zip files do not
    have."""
    done = python(
        "import importlib.metadata as metadata\n"
        "def missing(name):\n    raise metadata.PackageNotFoundError(name)\n"
        "metadata.version = metadata.distribution = missing\n"
        "from beveloid_geom.cli.main import main\nmain(['--version'])\n"
    )
    assert done.stdout.endswith(f", version {beveloid_geom.__version__}\n")
    assert version("beveloid-geom") == beveloid_geom.__version__


@POSIX
@pytest.mark.parametrize("encoding", ["cp1252", "ascii:surrogateescape", "cp932"])
def test_names_outside_the_encoding_of_the_console(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "\u6b6f\u00f8").mkdir()
    written = "beveloid-geom mesh --part pinion-flank --out \u6b6f\u00f8/p.stl"
    done = shell(f"PYTHONIOENCODING={encoding} {written} > out.txt", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert b"/p.stl: " in (tmp_path / "out.txt").read_bytes()
    assert (tmp_path / "\u6b6f\u00f8" / "p.stl").exists()


@POSIX
@pytest.mark.parametrize(
    ("command", "epoch"),
    [
        *(("beveloid-geom mesh --part pinion-flank --out p.stl", epoch) for epoch in ("abc", "9" * 30)),
        ("render-report --cases 1 --out r.html", "1.5"),
    ],
)
def test_an_invalid_source_date_is_named(command: str, epoch: str, tmp_path: Path) -> None:
    done = shell(f"SOURCE_DATE_EPOCH={epoch} {command}", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"Error: SOURCE_DATE_EPOCH must be whole seconds since 1970, got '{epoch}': correct it or unset it\n"
    )
    assert not list(tmp_path.iterdir())


def test_the_package_is_a_command() -> None:
    command = [sys.executable, "-m", "beveloid_geom", "tca", "--points", "3"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "dw1 = 211.594669 mm" in done.stdout


UNCHANGED_STATE_SCRIPT = """
import os, signal
def state():
    mask = os.umask(0o022)
    os.umask(mask)
    handlers = [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    return dict(os.environ), mask, handlers
before = state()
import numpy as np
import beveloid_geom as bg
names = [getattr(bg, name) for name in bg.__all__]
design = bg.builtin_design()
bg.path_certificate(bg.path_of_contact(design, points=5)), bg.mounted_backlash(design)
bg.mesh_cycle(design), bg.contact_pattern(design)
assert state() == before
print("same")
"""


def test_the_library_does_not_change_the_process() -> None:
    """The import and public functions do not change the environment, the umask and the signal handlers."""
    run = python(UNCHANGED_STATE_SCRIPT)
    assert (run.stdout, run.stderr) == ("same\n", "")
