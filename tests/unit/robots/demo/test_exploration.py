"""Stage of the demo of mapping: the world is in the frame of the map that is to be made."""

import asyncio
from typing import Any

import pytest

from ppaas.errors import Conflict, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE
from robots.client.rest import RestClient
from robots.demo import cloud_process
from robots.demo.cloud_process import start_text, tell_start
from robots.demo.exploration import GOALS, background, set_stage
from robots.demo.options import DemoOptions
from tests.support.waiting import until


def test_explorer_starts_at_the_origin_and_all_poses_are_free() -> None:
    stage = set_stage(DemoOptions(seed=3))
    assert stage.map_id == "office"
    assert len(stage.course.goals) == GOALS
    for x, y, _ in ((0.0, 0.0, 0.0), stage.course.start, *stage.course.goals):
        cell = stage.grid.info.cell_of(x, y)
        assert cell is not None
        assert stage.grid.data[cell] == FREE


def test_several_explorers_start_apart_in_the_frame_of_the_first() -> None:
    stage, alone = set_stage(DemoOptions(seed=3, explorers=2)), set_stage(DemoOptions(seed=3))
    assert stage.starts[0] == alone.starts[0] == Pose2D(0.0, 0.0, 0.0)
    assert stage.course == alone.course
    assert stage.starts[0].distance_to(stage.starts[1]) > 1.0
    cell = stage.grid.info.cell_of(stage.starts[1].x, stage.starts[1].y)
    assert cell is not None and stage.grid.data[cell] == FREE


async def _fail() -> None:
    raise Unavailable("the robot has stopped")


async def test_failure_in_the_background_ends_the_block() -> None:
    with pytest.raises(Unavailable, match="the robot has stopped"):
        async with background(asyncio.sleep(60)), background(_fail()):
            await asyncio.sleep(60)


async def test_failure_of_the_block_is_raised_and_ends_the_background() -> None:
    ended = asyncio.Event()

    async def work() -> None:
        try:
            await asyncio.sleep(60)
        finally:
            ended.set()

    async with background(work()):
        await asyncio.sleep(0)
    assert ended.is_set()
    with pytest.raises(Conflict, match="no"):
        async with background(asyncio.sleep(60)):
            raise Conflict("no")


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
