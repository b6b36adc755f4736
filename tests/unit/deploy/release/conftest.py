"""A small project in a checkout of git, from which releases are built in a moment."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from deploy.release import revision

Commit = Callable[..., Path]


@pytest.fixture
def commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Commit:
    """Return a function that writes files into the checkout, commits all, and returns the checkout."""
    root = tmp_path / "project"
    root.mkdir()
    monkeypatch.setattr(revision, "ROOT", root)
    git(root, "init", "--quiet")

    def write(files: dict[str, str], *, tag: str = "") -> Path:
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text)
        git(root, "add", "--all")
        git(root, "commit", "--quiet", "--message", "Change")
        if tag:
            git(root, "tag", "--force", tag)
        return root

    return write


def git(folder: Path, *words: str) -> None:
    identity = ["-c", "user.name=A", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", *identity, *words], cwd=folder, check=True, capture_output=True)
