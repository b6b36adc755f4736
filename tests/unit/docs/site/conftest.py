"""A small project, whose pages become a site in a second."""

from pathlib import Path, PurePosixPath

import pytest

from docs.site import pages


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a project of three pages, a decision, a picture and a program."""
    root = tmp_path / "project"
    for folder in ("docs/adr", "docs/images", "docs/examples/small", "findings", "robots"):
        (root / folder).mkdir(parents=True)
    texts = {
        "README.md": "# A\n[rest](docs/rest.md#r) ![seen](docs/images/seen.png) [web](https://example.org)\n",
        "docs/rest.md": "# R\n[home](../README.md)\n[why](adr/) [one](../robots/one.py) [all](examples/small)\n"
        "```text\n[kept](../nowhere.md)\n```\n[here](#r)\n",
        "docs/adr/README.md": "# D\n[1](0001-one.md)\n",
        "docs/adr/0001-one.md": "# 0001: One\n[r](../rest.md)\n",
        "findings/README.md": "# F\n",
        "CHANGELOG.md": "# C\n",
        "CONTRIBUTING.md": "# C\n",
        "SECURITY.md": "# S\n",
        "docs/images/seen.png": "",
        "docs/examples/small/a.json": "{}",
        "robots/one.py": "print()\n",
    }
    for name, text in texts.items():
        (root / name).write_text(text)
    monkeypatch.setattr(pages, "ROOT", root)
    monkeypatch.setattr(pages, "GENERATED", {})
    monkeypatch.setattr(pages.examples, "files", lambda: [PurePosixPath("docs/examples/small/a.json")])
    return root
