"""Build the documentation site: user guide, examples with pictures, reference, and developer pages.

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
    """Copy pages and pictures into the folder `source` with their paths in the repository."""
    pages = [page for top in ("beveloid_geom", "viz", "tests") for page in (ROOT / top).rglob("README.md")]
    pages += [ROOT / "README.md", *HERE.glob("tutorial_*.md")]
    for file in (*pages, *(ROOT / "outputs/gallery").iterdir()):
        copy = source / file.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
    for name in ("index.md", "api.md"):
        shutil.copyfile(HERE / name, source / name)
    # Examples write files into their working folder, which is therefore outside the source of the pages (see
    # `conf.py`).
    shutil.copytree(ROOT / "viz/examples", source.parent / "examples")


def main() -> int:
    """Build the site from scratch; warnings are errors. Returns the exit status of Sphinx."""
    with TemporaryDirectory() as folder:
        source = Path(folder) / "pages"
        gather(source)
        target = ROOT / "outputs/site"
        shutil.rmtree(target, ignore_errors=True)
        return int(build_main(["-W", "--keep-going", "-q", "-c", str(HERE), str(source), str(target)]))


if __name__ == "__main__":
    sys.exit(main())
