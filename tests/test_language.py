"""The prose of the project avoids patterns that readers have to decode."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PATTERNS = {
    "clause in place of a noun": r"\bwhat (?:is|are|it|they|else|touches|carries|holds|follows|remains)\b",
    "docstring that begins with Give, Say or Tell": r"^(?:Give|Say|Tell)\b",
    "told for reported or distinguished": r"\b(?:is|are|was|were|be|been) told\b|\btold (?:so|apart|from)\b",
    "stands for is": r"\b(?:stands?|standing) (?:beside|with|in|on|at|by|to|apart|under|above|there)\b",
    "square to for perpendicular to": r"\bsquare to\b",
    "archaic conjunction": r"\b(?:lest|save that|save where)\b",
}
FILES = [
    ROOT / "README.md",
    *(
        path
        for folder in ("beveloid_geom", "viz", "tests")
        for suffix in ("*.py", "*.md")
        for path in sorted((ROOT / folder).rglob(suffix))
        if path != Path(__file__)
    ),
]


def prose(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of each paragraph line of a page, and of each string and comment of a module."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        text = re.sub(r"```.*?```", lambda block: "\n" * block[0].count("\n"), text, flags=re.DOTALL)
        yield from enumerate(re.sub(r"`[^`]*`", "x", text).splitlines(), 1)
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip():
            yield node.lineno, " ".join(node.value.split())
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string.lstrip("# ")


@pytest.fixture(scope="module")
def places() -> list[tuple[str, str]]:
    """Name of the file with line, and text, for all prose of the project."""
    return [(f"{path.relative_to(ROOT)}:{line}", text) for path in FILES for line, text in prose(path)]


@pytest.mark.parametrize("name", PATTERNS)
def test_prose_avoids(name: str, places: list[tuple[str, str]]) -> None:
    pattern = re.compile(PATTERNS[name])
    assert [f"{place}: {text[:90]}" for place, text in places if pattern.search(text)] == []
