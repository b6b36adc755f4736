"""Scenes of a chaos run."""

import asyncio
from typing import Any

from benchmarks.chaos import run, scene
from benchmarks.chaos.run import TrafficWatch
from benchmarks.chaos.scene import in_office, in_traffic
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from tests.support.waiting import until


def test_robots_in_traffic_start_and_end_in_different_cells_and_are_far_from_walls() -> None:
    traffic = in_traffic(1, 5, (18.0, 12.0))
    starts = [course.start for course in traffic.courses]
    assert len(starts) == 5
    assert min(one.distance_to(other) for one in starts for other in starts if one is not other) > 0.5
    assert all(len(set(course.goals)) == scene.GOALS for course in traffic.courses)
    assert traffic.traffic and traffic.contacts == 0


def test_the_contacts_of_a_scene_are_those_of_pairs() -> None:
    traffic = in_traffic(1, 2, (18.0, 12.0))
    x, y, _ = traffic.courses[0].start
    traffic.world.add_robot(Pose2D(x, y))
    traffic.world.add_robot(Pose2D(x + 0.2, y))
    traffic.world.step()
    assert traffic.contacts == 1


def test_robots_in_an_office_are_not_in_traffic() -> None:
    office = in_office(1, 3, 2, 1, (9.0, 10.0))
    assert (office.map_id, len(office.courses), office.operated, office.traffic) == ("chaos-1", 2, 1, False)


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
