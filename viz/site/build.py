"""Builds the site: the pages of all rooms, the examples with their pictures, a reference of public names.

`python viz/site/build.py` needs the extra `site`, no network, and writes `outputs/site/index.html`.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from sphinx.cmd.build import build_main

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def gather(source: Path) -> None:
    """Copy pages and their pictures into the folder `source`, each where it lies in the repository."""
    pages = [page for room in ("beveloid_geom", "viz", "tests") for page in (ROOT / room).rglob("README.md")]
    for file in (ROOT / "README.md", *pages, *(ROOT / "outputs/gallery").iterdir()):
        copy = source / file.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
    for page in HERE.glob("*.md"):
        shutil.copyfile(page, source / page.name)
    # Beside the pages, which `conf.py` names: examples write their files where they lie.
    shutil.copytree(ROOT / "viz/examples", source.parent / "examples")


def main() -> int:
    """Build anew; warnings are errors. The exit status is Sphinx's."""
    with TemporaryDirectory() as folder:
        source = Path(folder) / "pages"
        gather(source)
        target = ROOT / "outputs/site"
        shutil.rmtree(target, ignore_errors=True)
        return build_main(["-W", "--keep-going", "-q", "-c", str(HERE), str(source), str(target)])


if __name__ == "__main__":
    sys.exit(main())
