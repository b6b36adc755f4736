"""Progress of ``ppaas robot map --publish``."""

import asyncio
from typing import Any

import pytest

from ppaas.errors import Unavailable
from robots.cli.verbs import robot_map


class FakeClient:
    """Client that returns answers, or raises errors, one after the other."""

    def __init__(self, answers: list[Any]) -> None:
        self.answers = answers

    async def get(self, _path: str) -> Any:
        if not self.answers:
            await asyncio.Event().wait()
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return {"publishing": answer}


async def test_the_stages_are_shown_although_the_robot_is_away_for_a_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_map, "PERIOD", 0.0)
    client, shown = (
        FakeClient([None, {"stage": "loops", "part": 0.5}, Unavailable("away"), {"stage": "x", "part": 0}]),
        [],
    )
    watching = asyncio.create_task(
        robot_map._watch(client, "path", lambda text, done: shown.append((text, done)))  # type: ignore[arg-type]
    )
    while client.answers:
        await asyncio.sleep(0)
    await asyncio.sleep(0)
    watching.cancel()
    assert shown == [("search for missing loops", pytest.approx(0.4)), ("x", 0.0)]


async def test_without_a_terminal_nothing_is_requested() -> None:
    await robot_map._watch(FakeClient([Unavailable("away")]), "path", None)  # type: ignore[arg-type]
