"""The house: who may import whom, and what a bare import may cost."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = (
    *("process", "whole_file", "few_lines"),
    *("read_only", "field_limits", "inputs"),
    *("reference", "reference.pitch_region", "reference.five_equations_math"),
    *("reference.five_equations_numpy", "reference.five_equations_mp"),
    *("rack", "flank", "assembly", "mounting", "contact", "solve", "curve"),
    *("unfolded", "track", "ends", "cells", "walk", "follow", "path", "conditioning"),
    *("posing", "five_equations_curve", "five_equations", "design_limits", "design_file"),
    *("fillet", "undercut", "closing", "remarks"),
    *("surface", "touch", "approach", "scan", "first_contact", "certificate", "operation"),
    "ratio_in_operation",
    *("backlash", "backlash_by_tangency"),
    *("operating_rolls", "foot", "curvature", "marked_area", "pattern"),
    *("sensitivity", "statement_measures", "statement_verdicts", "modification_statements"),
    *("error_statements", "statements", "statement_readings"),
    "sliding",
    *("sampling", "closest", "proximity", "comparison_methods", "comparison", "job_size"),
    *("outline", "section", "solid", "tooth", "volume", "hexahedra", "hertz"),
    *("export", "export.material", "export.vtp", "export.load", "export.surfaces", "export.abaqus"),
    *("export.nastran", "export.volumes", "export.parts", "export.strips", "export._brep", "export.step"),
    *("tolerance", "report_notes", "report_backlash", "layout_remarks", "layout_advice"),
    *("report", "report_closing", "report_operation", "report_statements"),
    "report_sliding",
    "report_pattern",
    *("report_tolerance", "optimise", "report_optimise"),
    *("design_map", "report_map"),
    *("report_sensitivity", "cli_support", "cli_mesh", "cli_operation", "cli_tolerance", "cli_optimise"),
    "cli_map",
    "cli_sliding",
    "cli_pattern",
    *("cli_statements", "cli_sensitivity", "cli", "__main__"),
)
"""From the ground up: a module imports only modules named before it. 'export' is what the subpackage
imports itself."""
LOWER = {".opengl", ".theme", ".scene", ".whole_file"}
PACKAGE = ROOT / "beveloid_geom"
WRITERS = {"meshio", "trimesh", "OCP"}
"""Libraries that only the subpackage `export` may import."""
OFFSCREEN = {"viz", "pyvista", "vtk", "vtkmodules", "matplotlib"}
EXCEPTED = {"closest": {"vtkmodules"}}
"""Its cell locator was the best by measurement; `test_start_up_is_light` keeps it where it is."""


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


def floor_of(path: Path) -> str:
    """The name of a module of the library in FLOORS."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def floors_below(path: Path) -> set[str]:
    """The modules of the library that a file imports, by their names in FLOORS."""
    home, names = path.relative_to(PACKAGE).parent.parts, set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        package = home[: len(home) - node.level + 1]
        module = (*package, *(node.module or "").split(".")) if node.module else package
        inner = [".".join((*module, alias.name)) for alias in node.names]
        names |= {name for name in inner if name in FLOORS} or {".".join(module)}
    return names - {""}


MODULES = sorted(p for p in PACKAGE.rglob("*.py") if p != PACKAGE / "__init__.py")


@pytest.mark.parametrize("path", MODULES, ids=floor_of)
def test_imports_run_one_way(path: Path) -> None:
    floor = floor_of(path)
    assert floor in FLOORS, f"give {floor} its floor in this test"
    names = imported(path)
    assert not names & OFFSCREEN - EXCEPTED.get(floor, set())
    assert floor.startswith("export") or not names & WRITERS
    assert floors_below(path) <= set(FLOORS[: FLOORS.index(floor)])


@pytest.mark.parametrize("path", sorted((PACKAGE / "reference").glob("*.py")), ids=floor_of)
def test_the_reference_shares_only_the_inputs(path: Path) -> None:
    """What checks the solver's numbers must not be made of the solver's code."""
    assert all(n == "inputs" or n.startswith("reference.") for n in floors_below(path))
    assert not any(name.startswith("beveloid_geom") for name in imported(path))


def test_the_library_never_imports_viz() -> None:
    for path in PACKAGE.rglob("*.py"):
        assert not imported(path) & OFFSCREEN - EXCEPTED.get(floor_of(path), set())


def test_scene_code_never_solves() -> None:
    """viz/stage/scene.py, theme.py and opengl.py know nothing of gears."""
    for name in ("scene", "theme", "opengl"):
        assert not any(n.startswith(".") and n not in LOWER for n in imported(ROOT / "viz" / f"{name}.py"))
        assert "beveloid_geom" not in imported(ROOT / "viz" / f"{name}.py")


@pytest.mark.parametrize(
    ("statement", "unwanted"),
    [
        ("import beveloid_geom", "numpy"),
        ("import beveloid_geom.cli.main", "numpy"),
        ("import beveloid_geom.export.parts", "meshio"),
        ("import beveloid_geom.export.parts", "trimesh"),
        ("import viz.cli", "numpy"),
        ("import beveloid_geom.contact.path", "scipy"),
        ("import beveloid_geom.contact.path", "mpmath"),
    ],
)
def test_start_up_is_light(statement: str, unwanted: str) -> None:
    code = f"{statement}; import sys; print({unwanted!r} in sys.modules, 'vtk' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert run.stdout.split() == ["False", "False"]


def test_no_public_name_hides_a_module() -> None:
    """Importing a module puts its name into the package, in place of a function of that name."""
    import beveloid_geom

    assert not set(beveloid_geom.__all__) & {path.stem for path in MODULES}
    assert all(getattr(beveloid_geom, name) is not None for name in beveloid_geom.__all__)
