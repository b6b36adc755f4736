"""The project's own files, for tests that read them."""

import ast
import gc
import subprocess
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("ppaas", "engine", "endpoints", "storage", "robots")
"""The packages of the wheel."""
ALL_PACKAGES = (*PACKAGES, "benchmarks")
"""The packages of the checkout."""


@dataclass(frozen=True)
class Source:
    """A Python file: its path from the root, its text and its tree."""

    path: str
    text: str
    tree: ast.Module

    @classmethod
    def of(cls, path: str, text: str) -> "Source":
        """Parse a text."""
        return cls(path, text, ast.parse(text, path))


def sources(*packages: str) -> tuple[Source, ...]:
    """Return the files of some packages, by package and path."""
    return tuple(source for package in packages for source in _sources_of(package))


@cache
def _sources_of(package: str) -> tuple[Source, ...]:
    files = sorted((ROOT / package).rglob("*.py"))
    gc.disable()  # searches for garbage among the trees, of which there is none, take twice the time of parsing
    try:
        return tuple(Source.of(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8")) for file in files)
    finally:
        gc.enable()


@cache
def pyproject() -> dict[str, Any]:
    """Return pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@cache
def tracked_files() -> tuple[Path, ...]:
    """Return what git keeps and is there, or nothing where this is no checkout."""
    if not (ROOT / ".git").exists():
        return ()
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return tuple(ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file())
