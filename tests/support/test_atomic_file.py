"""Files that are written completely or not at all: which files are replaced, and their modes.

Pipes represent devices, which root could replace for all users.
"""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from beveloid_geom.support.atomic_file import atomic_file

BIN = Path(sys.executable).parent
COMMANDS = (
    ("render-report", "--cases", "1", "--out", "{}.html"),
    ("beveloid-geom", "mesh", "--part", "pinion-flank", "--out", "{}.stl"),
)


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes among files here")
    path = tmp_path / "pipe"
    os.mkfifo(path)
    return path


def test_a_linked_pipe_is_left_alone(pipe: Path) -> None:
    out = pipe.with_name("link")
    out.symlink_to(pipe)
    with pytest.raises(OSError, match="Not a regular file"), atomic_file(out):
        pytest.fail("it would be replaced")
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert set(pipe.parent.iterdir()) == {pipe, out}


@pytest.mark.parametrize("arguments", COMMANDS)
def test_commands_refuse_a_pipe(pipe: Path, arguments: tuple[str, ...]) -> None:
    program, *rest = (text.format(pipe) for text in arguments)
    out = Path(rest[-1])
    pipe.rename(out)
    run = subprocess.run([BIN / program, *rest], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith(f"Error: cannot write {out} (Not a regular file): choose ")
    assert run.stderr.count("\n") == 1
    assert stat.S_ISFIFO(out.stat().st_mode)
    assert list(out.parent.iterdir()) == [out]


def test_a_report_without_a_name_is_refused_at_once(tmp_path: Path) -> None:
    command = [str(BIN / "render-report"), "--out", ""]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 2
    assert run.stderr == "Error: cannot write . (Is a directory): choose a file with --out\n"


@pytest.mark.parametrize("mode", [0o444, 0o400])
def test_a_write_protected_file_is_refused(tmp_path: Path, mode: int) -> None:
    """A write-protected file is not replaced, also if the user is root, who may write to any file."""
    path = tmp_path / "a.stl"
    path.write_text("old")
    path.chmod(mode)
    with pytest.raises(PermissionError, match="Write-protected"), atomic_file(path):
        pytest.fail("it would be replaced")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mode", [0o600, 0o664, 0o755])
def test_a_replaced_file_keeps_its_mode(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "a.stl"
    path.write_text("old")
    path.chmod(mode)
    with atomic_file(path) as part:
        part.write_text("new")
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_the_umask_is_kept_and_not_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The mode follows the umask, which is never changed: another thread that writes a file would get the
    changed one."""
    before = os.umask(0o027)
    monkeypatch.setattr(os, "umask", lambda _: pytest.fail("other threads would see it"))
    try:
        with atomic_file(tmp_path / "new") as path:
            path.write_text("text")
    finally:
        monkeypatch.undo()
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
