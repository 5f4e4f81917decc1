"""The house: rooms import one way, and a bare import costs little."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LIBRARY = (
    *("status", "arrays", "support", "design", "gear", "pair", "contact", "operation", "analysis"),
    *("workshop", "shapes", "export", "reference", "studies", "findings", "proposal", "report", "cli"),
)
"""Rooms of `beveloid_geom` and the modules outside them: each imports only from those before it."""
PICTURES = ("stage", "options", "parts", "figures", "film", "report", "examples", "site")
"""Rooms of `viz`, likewise, and what its commands share. Examples are users: they see what is installed."""
REFERENCE = ("five_equations_math", "five_equations_mp", "pitch_region")
"""Modules of `reference` that check the numbers of the library and share nothing but its inputs."""
STARTS = ("beveloid_geom", "beveloid_geom.__main__", "viz", "viz.cli", "viz.commands")
"""Where packages and commands start: of no room, and seen by none."""
OFFSCREEN = {"viz", "beveloid_viz", "pyvista", "vtk", "vtkmodules", "matplotlib"}
EXCEPTED = {"beveloid_geom.shapes.closest_points": {"vtkmodules"}}
"""VTK's cell locator was the best by measurement; `test_start_up_is_light` keeps it where it is."""
WRITERS = {"meshio", "trimesh", "OCP"}
"""Libraries that only `export` may import."""
FULL = 14
"""Modules beyond which a room is no longer seen at a glance."""


def name_of(path: Path) -> str:
    """Dotted name of a module, that of its package for an `__init__`."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def imported(path: Path) -> Iterator[str]:
    """Dotted names that a file imports anywhere, relative ones made whole."""
    package = path.parent.relative_to(ROOT).parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            home = package[: len(package) - node.level + 1] if node.level else ()
            module = (*home, *(node.module or "").split(".")) if node.module else home
            yield from (".".join((*module, alias.name)) for alias in node.names)


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def rooms_used(path: Path) -> set[str]:
    """Rooms of its own package from which a module imports."""
    package, *_ = name_of(path).split(".")
    names = (name.split(".") for name in imported(path))
    return {name[1] for name in names if name[0] == package and len(name) > 1}


@pytest.mark.parametrize(
    "path", [p for p in modules("beveloid_geom") if name_of(p) not in STARTS], ids=name_of
)
def test_rooms_of_the_library_import_one_way(path: Path) -> None:
    _, room, *_ = name_of(path).split(".")
    assert room in LIBRARY, f"give {room} its place in this test"
    assert rooms_used(path) <= set(LIBRARY[: LIBRARY.index(room) + 1])
    tops = {name.split(".")[0] for name in imported(path)}
    assert not tops & OFFSCREEN - EXCEPTED.get(name_of(path), set())
    assert room == "export" or not tops & WRITERS


@pytest.mark.parametrize("path", [p for p in modules("viz") if name_of(p) not in STARTS], ids=name_of)
def test_rooms_of_pictures_import_one_way(path: Path) -> None:
    _, room, *_ = name_of(path).split(".")
    assert rooms_used(path) <= set(PICTURES[: PICTURES.index(room) + 1])


@pytest.mark.parametrize("path", [*modules("viz"), *modules("tests")], ids=name_of)
def test_nothing_names_the_folder_viz(path: Path) -> None:
    """Installed, it is `beveloid_viz`: its modules see each other by relative imports, tests by that name."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    absolute = {n.name for node in ast.walk(tree) if isinstance(node, ast.Import) for n in node.names}
    absolute |= {n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and not n.level}
    assert "viz" not in {name.partition(".")[0] for name in absolute}


@pytest.mark.parametrize("path", modules("viz/stage"), ids=name_of)
def test_the_stage_knows_nothing_of_gears(path: Path) -> None:
    assert all(
        name.startswith("beveloid_geom.support.") for name in imported(path) if "beveloid_geom" in name
    )


@pytest.mark.parametrize("package", ["beveloid_geom", "viz"])
def test_modules_import_in_no_circle(package: str) -> None:
    """Within a room as between them; what is imported for the type checker alone counts too."""
    names = {name_of(path): path for path in modules(package)}
    below = {
        name: {n for used in imported(path) for n in (used, used.rpartition(".")[0]) if n in names} - {name}
        for name, path in names.items()
        if path.name != "__init__.py"
    }
    while below:
        ground = {name for name, used in below.items() if not used & below.keys()}
        assert ground, f"a circle among {sorted(below)}"
        below = {name: used for name, used in below.items() if name not in ground}


def test_rooms_are_seen_at_a_glance() -> None:
    """Each has a page that names its modules, and no more of them than that shows."""
    for room in (ROOT / "beveloid_geom").iterdir():
        found = sorted(path.stem for path in room.glob("*.py") if path.stem != "__init__")
        if not found:
            continue
        page = (room / "README.md").read_text(encoding="utf-8")
        assert len(found) <= FULL
        assert all(f"`{name}`" in page for name in found), room.name


@pytest.mark.parametrize("name", REFERENCE)
def test_the_reference_shares_only_the_inputs(name: str) -> None:
    """What checks the numbers of the library must not be made of its code."""
    used = [n for n in imported(ROOT / f"beveloid_geom/reference/{name}.py") if n.startswith("beveloid_geom")]
    assert all(n.split(".")[1] in ("design", "arrays") or n.split(".")[2] in REFERENCE for n in used)


@pytest.mark.parametrize(
    ("statement", "unwanted"),
    [
        (
            "import beveloid_geom, beveloid_geom.cli.main, beveloid_viz.cli, beveloid_viz.report.cli",
            {"numpy", "vtk", "jinja2", "matplotlib"},
        ),
        ("import beveloid_geom.export.parts", {"meshio", "trimesh", "vtk"}),
        ("import beveloid_geom.contact.path", {"scipy", "mpmath", "vtk"}),
    ],
)
def test_start_up_is_light(statement: str, unwanted: set[str]) -> None:
    code = f"{statement}; import sys; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert not unwanted & set(run.stdout.split())


def test_no_public_name_hides_a_room() -> None:
    """Importing a room puts its name into the package, in place of a function of that name."""
    import beveloid_geom

    assert not set(beveloid_geom.__all__) & set(LIBRARY)
    assert all(getattr(beveloid_geom, name) is not None for name in beveloid_geom.__all__)
