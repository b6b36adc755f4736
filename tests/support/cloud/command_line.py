"""Command line ``ppaas`` against a cloud of the test."""

import asyncio
import io
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from endpoints.resources.services import Services
from robots.cli.main import main
from tests.support.endpoints.fake_cloud import FakeCloud

PASSWORD = "correct horse"


@dataclass
class Ended:
    """Result of a command."""

    status: int
    out: str
    err: str

    @property
    def rows(self) -> list[list[str]]:
        """The words of each output line."""
        return [line.split() for line in self.out.splitlines()]


@dataclass
class CommandLine:
    """Runs ``ppaas`` with the token of a user."""

    url: str
    services: Services
    cloud: FakeCloud
    captured: Callable[[], tuple[str, str]]
    patch: pytest.MonkeyPatch
    tokens: dict[str, str] = field(default_factory=dict)

    async def __call__(self, *arguments: str, user: str | None = "ann", stdin: str = "") -> Ended:
        """Run a command; it finds the token of ``user`` in the environment."""
        self.patch.setenv("PPAAS_URL", self.url)
        self.patch.delenv("PPAAS_TOKEN", raising=False)
        if user is not None:
            self.patch.setenv("PPAAS_TOKEN", self.tokens[user])
        self.patch.setattr("sys.stdin", io.StringIO(stdin))
        self.captured()
        status = await asyncio.to_thread(_run, list(arguments))
        return Ended(status, *self.captured())


def _run(arguments: list[str]) -> int:
    try:
        return main(arguments)
    except SystemExit as end:  # raised by argparse
        return int(end.code or 0)
