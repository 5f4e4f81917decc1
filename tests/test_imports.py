"""The house: who may import whom, and what a bare import may cost."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = (
    *("inputs", "rack", "flank", "assembly", "mounting", "contact", "solve", "curve", "track", "path"),
    *("five_equations", "design_limits", "design_file", "closing"),
    *("fillet", "touch", "first_contact", "certificate", "operation", "curvature", "pattern"),
    *("sampling", "closest", "proximity", "undercut", "section", "solid", "tooth", "volume", "hexahedra"),
    *("export", "report", "cli_support", "cli_mesh", "cli"),
)
"""From the ground up: a module imports only modules named before it."""
LOWER = {".opengl", ".theme", ".scene", ".whole_file"}
OFFSCREEN = {"viz", "pyvista", "vtk", "vtkmodules", "matplotlib"}


def imported(path: Path) -> set[str]:
    """Top-level packages and, for relative imports, '.module' names that a file imports anywhere."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            parts = (node.module or "").split(".")
            names.add("." + parts[1] if parts[0] == "beveloid_geom" and len(parts) > 1 else parts[0])
        elif isinstance(node, ast.ImportFrom):
            names |= {"." + node.module.split(".")[0]} if node.module else {"." + a.name for a in node.names}
    return names


MODULES = sorted(p for p in (ROOT / "beveloid_geom").glob("*.py") if p.stem != "__init__")


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.stem)
def test_imports_run_one_way(path: Path) -> None:
    assert path.stem in FLOORS, f"give {path.stem} its floor in this test"
    names = imported(path)
    assert not names & OFFSCREEN
    below = FLOORS[: FLOORS.index(path.stem)]
    assert {name[1:] for name in names if name.startswith(".")} <= set(below)


def test_the_library_never_imports_viz() -> None:
    assert not any(imported(path) & OFFSCREEN for path in (ROOT / "beveloid_geom").rglob("*.py"))


def test_scene_code_never_solves() -> None:
    """viz/scene.py, theme.py and opengl.py know nothing of gears."""
    for name in ("scene", "theme", "opengl"):
        assert not any(n.startswith(".") and n not in LOWER for n in imported(ROOT / "viz" / f"{name}.py"))
        assert "beveloid_geom" not in imported(ROOT / "viz" / f"{name}.py")


@pytest.mark.parametrize(
    ("statement", "unwanted"),
    [
        ("import beveloid_geom", "numpy"),
        ("import beveloid_geom.cli", "numpy"),
        ("import viz.cli", "numpy"),
        ("import beveloid_geom.path", "scipy"),
    ],
)
def test_start_up_is_light(statement: str, unwanted: str) -> None:
    code = f"{statement}; import sys; print({unwanted!r} in sys.modules, 'vtk' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert run.stdout.split() == ["False", "False"]
