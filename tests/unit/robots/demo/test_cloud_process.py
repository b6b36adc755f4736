"""The cloud that a demo starts, and the progress of its start."""

import asyncio
from typing import Any

import pytest

from ppaas.errors import Unavailable
from robots.client.rest import RestClient
from robots.demo import cloud_process
from robots.demo.cloud_process import start_text, tell_start
from tests.support.waiting import until

KERNELS = {"done": 12, "total": 107, "compiling": ["lattice/driving"]}


@pytest.mark.parametrize(
    ("health", "text"),
    [
        ({"status": "ok", "kernels": KERNELS}, ""),
        ({"status": "starting", "kernels": None}, "the cloud is starting"),
        (
            {"status": "starting", "kernels": KERNELS},
            "the cloud is starting: compiling kernels, 12 of 107 (now lattice/driving)",
        ),
        (
            {"status": "starting", "kernels": KERNELS | {"compiling": []}},
            "the cloud is starting: compiling kernels, 12 of 107",
        ),
    ],
)
def test_the_text_says_what_is_compiled(health: dict[str, Any], text: str) -> None:
    assert start_text(health) == text


async def test_each_change_is_told_once_also_if_the_cloud_does_not_serve_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    starting = {"status": "starting", "kernels": None}
    answers = iter([Unavailable("no"), starting, starting, starting | {"kernels": KERNELS}, {"status": "ok"}])

    async def get(_client: RestClient, path: str) -> Any:
        assert path == "/v1/health"
        answer = next(answers, {"status": "ok"})
        if isinstance(answer, Unavailable):
            raise answer
        return answer

    monkeypatch.setattr(RestClient, "get", get)
    monkeypatch.setattr(cloud_process, "PERIOD", 0.0)
    told: list[str] = []
    telling = asyncio.create_task(tell_start("http://127.0.0.1:1", told.append))
    await until(lambda: next(answers, None) is None)
    telling.cancel()
    assert [text.partition(" (")[0] for text in told] == ["the cloud is starting: compiling kernels, 12 of 107"]
