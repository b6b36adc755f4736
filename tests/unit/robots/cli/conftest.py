"""Command line against a real server: the application with in-memory stores and a cloud without machines."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from tests.support.cloud.command_line import CommandLine
from tests.support.cloud.served_users import serving_users
from tests.support.storage.records import YAML, pgm


@pytest.fixture
async def ppaas(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[CommandLine]:
    """Return the command line; the users are ann, bob and the administrator admin."""
    async with serving_users() as served:
        yield CommandLine(
            served.url, served.services, served.cloud, capsys.readouterr, monkeypatch, dict(served.tokens)
        )


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """Return the YAML file of a map, with its image in the same folder."""
    (tmp_path / "house.yaml").write_bytes(YAML)
    (tmp_path / "house.pgm").write_bytes(pgm())
    return tmp_path / "house.yaml"
