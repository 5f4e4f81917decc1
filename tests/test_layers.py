"""Packages import only from lower layers, and importing the library is cheap."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LIBRARY = (
    *("version", "status", "arrays", "support", "design", "gear", "pair", "contact", "operation", "analysis"),
    *("workshop", "shapes", "export", "validation", "findings", "proposal", "report", "cli"),
)
"""Layers of `beveloid_geom` (packages and single modules); each imports from itself and earlier ones."""
PICTURES = ("rendering", "options", "components", "figures", "film", "report", "explore", "examples", "site")
"""Layers of `viz`, in the same order. Examples come last because they use only the installed package."""
REFERENCE = ("five_equations_math", "five_equations_mp", "pitch_region")
"""Modules of `validation` that check the numbers of the library and share nothing but its inputs."""
STARTS = ("beveloid_geom", "beveloid_geom.__main__", "viz", "viz.cli", "viz.commands")
"""Entry points: they belong to no layer, and no layer imports them."""
OFFSCREEN = {"viz", "beveloid_viz", "pyvista", "vtk", "vtkmodules", "matplotlib"}
EXCEPTED = {
    "beveloid_geom.shapes.proximity.closest_points": {"vtkmodules"},
    "beveloid_geom.export.vtk_files": {"vtkmodules"},
    "beveloid_geom.shapes.solid": {"trimesh"},
}
"""VTK writes its own formats, and its cell locator was the best by measurement. `test_import_is_light` checks
that the commands, `export.parts` and `contact.path` are imported without VTK. `Solid.to_trimesh` imports
trimesh when it is called."""
WRITERS = {"meshio", "trimesh", "OCP"}
"""Libraries that only `export` may import, apart from the exceptions."""
MODULES_PER_PACKAGE = 14
"""Largest number of modules in one package."""


def name_of(path: Path) -> str:
    """Return the dotted name of a module; an `__init__` has the name of its package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def imported(path: Path) -> Iterator[str]:
    """Return the absolute dotted names that a file imports anywhere."""
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


def layers_used(path: Path) -> set[str]:
    """Return the layers of the same package from which a module imports."""
    package, *_ = name_of(path).split(".")
    names = (name.split(".") for name in imported(path))
    return {name[1] for name in names if name[0] == package and len(name) > 1}


@pytest.mark.parametrize(
    "path", [p for p in modules("beveloid_geom") if name_of(p) not in STARTS], ids=name_of
)
def test_library_imports_only_lower_layers(path: Path) -> None:
    _, layer, *_ = name_of(path).split(".")
    assert layer in LIBRARY, f"add {layer} to the layers of this test"
    assert layers_used(path) <= set(LIBRARY[: LIBRARY.index(layer) + 1])
    tops = {name.split(".")[0] for name in imported(path)}
    excepted = EXCEPTED.get(name_of(path), set())
    assert not tops & OFFSCREEN - excepted
    assert layer == "export" or not tops & WRITERS - excepted


@pytest.mark.parametrize("path", [p for p in modules("viz") if name_of(p) not in STARTS], ids=name_of)
def test_viz_imports_only_lower_layers(path: Path) -> None:
    _, layer, *_ = name_of(path).split(".")
    assert layers_used(path) <= set(PICTURES[: PICTURES.index(layer) + 1])


@pytest.mark.parametrize("path", [*modules("viz"), *modules("tests")], ids=name_of)
def test_nothing_names_the_folder_viz(path: Path) -> None:
    """The installed package is `beveloid_viz`: its modules use relative imports, tests use that name."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    absolute = {n.name for node in ast.walk(tree) if isinstance(node, ast.Import) for n in node.names}
    absolute |= {n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and not n.level}
    assert "viz" not in {name.partition(".")[0] for name in absolute}


@pytest.mark.parametrize("path", modules("viz/rendering"), ids=name_of)
def test_rendering_imports_no_gear_module(path: Path) -> None:
    assert all(
        name.startswith("beveloid_geom.support.") for name in imported(path) if "beveloid_geom" in name
    )


@pytest.mark.parametrize("package", ["beveloid_geom", "viz"])
def test_no_circular_imports(package: str) -> None:
    """Circular imports are excluded also inside a layer, and also for imports under TYPE_CHECKING."""
    names = {name_of(path): path for path in modules(package)}
    below = {
        name: {n for used in imported(path) for n in (used, used.rpartition(".")[0]) if n in names} - {name}
        for name, path in names.items()
        if path.name != "__init__.py"
    }
    while below:
        lowest = {name for name, used in below.items() if not used & below.keys()}
        assert lowest, f"circular import among {sorted(below)}"
        below = {name: used for name, used in below.items() if name not in lowest}


def test_package_pages_name_all_modules() -> None:
    """Each package has a README that names its modules, and at most 14 modules."""
    for layer in (ROOT / "beveloid_geom").iterdir():
        found = sorted(path.stem for path in layer.glob("*.py") if path.stem != "__init__")
        if not found:
            continue
        page = (layer / "README.md").read_text(encoding="utf-8")
        assert len(found) <= MODULES_PER_PACKAGE
        assert all(f"`{name}`" in page for name in found), layer.name


@pytest.mark.parametrize("name", REFERENCE)
def test_the_reference_shares_only_the_inputs(name: str) -> None:
    """What checks the numbers of the library must not be made of its code."""
    used = (n.split(".") for n in imported(ROOT / f"beveloid_geom/validation/{name}.py"))
    ours = [parts for parts in used if parts[0] == "beveloid_geom"]
    assert all(parts[1] in ("design", "arrays") or parts[2] in REFERENCE for parts in ours)


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
def test_import_is_light(statement: str, unwanted: set[str]) -> None:
    code = f"{statement}; import sys; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert not unwanted & set(run.stdout.split())


def test_no_public_name_hides_a_subpackage() -> None:
    """Importing a subpackage binds its name in the package and would replace a function of that name."""
    import beveloid_geom

    assert not set(beveloid_geom.__all__) & set(LIBRARY)


def test_every_package_is_installed() -> None:
    """`pyproject.toml` lists the packages because `viz` is installed under another name."""
    with open(ROOT / "pyproject.toml", "rb") as file:
        listed = tomllib.load(file)["tool"]["setuptools"]["packages"]
    folders = {path.parent.relative_to(ROOT) for path in (*modules("beveloid_geom"), *modules("viz"))}
    names = {".".join(folder.parts).replace("viz", "beveloid_viz", 1) for folder in folders}
    assert set(listed) == names - {"beveloid_viz.examples", "beveloid_viz.site"}
