"""Errors about robots in traffic say who drove and who waited for whom."""

import asyncio
from typing import Any

from benchmarks.chaos import run
from benchmarks.chaos.run import TrafficWatch
from ppaas.errors import Unavailable
from tests.support.waiting import until

ROBOTS = [
    {"robot": "a", "state": "waiting", "pose": (1.0, 2.0, 0.0), "waits_for": "b", "waited": 41.4},
    {"robot": "b", "state": "silent", "pose": (3.0, 2.126, 0.0), "waits_for": "", "waited": 0.0},
]


class Rest:
    """Answers with a traffic once, and then with errors."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    async def get(self, path: str) -> Any:
        self.asked.append(path)
        if len(self.asked) > 1:
            raise Unavailable("the cloud is not reachable")
        return {"robots": ROBOTS}


async def test_errors_have_the_traffic_as_it_was_last_seen(monkeypatch: Any) -> None:
    monkeypatch.setattr(run, "PERIOD", 0.0)
    rest, errors = Rest(), list[str]()
    watch = TrafficWatch(rest, "hall", errors.append)  # type: ignore[arg-type]  # it asks by GET alone
    watch.tell("a did not end")
    watching = asyncio.create_task(watch.run())
    await until(lambda: len(rest.asked) >= 3)
    watching.cancel()
    watch.tell("b did not end")
    assert errors == [
        "a did not end; traffic 0 s before: not known",
        "b did not end; traffic 0 s before: a waiting for b since 41 s at 1.00, 2.00, b silent at 3.00, 2.13",
    ]
    assert set(rest.asked) == {"/v1/maps/hall/traffic"}
