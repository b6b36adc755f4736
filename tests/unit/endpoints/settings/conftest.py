"""A file of settings, and an environment without variables of this project."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from endpoints.settings import effective

WriteSettings = Callable[[str], Path]


@pytest.fixture(autouse=True)
def no_variables(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in [name for name in os.environ if name.upper().startswith("PPAAS_")]:
        monkeypatch.delenv(name)
    monkeypatch.setattr(effective, "DEFAULT_FILE", tmp_path / "etc" / "ppaas.toml")


@pytest.fixture
def write(tmp_path: Path) -> WriteSettings:
    """Return a function that writes a file of settings."""

    def written(text: str) -> Path:
        path = tmp_path / "ppaas.toml"
        path.write_text(text)
        return path

    return written
