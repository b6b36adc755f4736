"""Which robot an AGV is: one of its manufacturer and its serial number, and no other AGV's."""

import asyncio
from contextlib import AsyncExitStack
from typing import Any

import pytest

from ppaas.errors import Conflict, NotFound
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.topics import AgvAddress, Version
from robots.bridges.agv.options import FleetOptions
from robots.bridges.agv.registration import AgvRegistry, differences, radius_of, robot_file
from robots.client.robot_file import RobotFile
from tests.support.vda5050.messages import FACTSHEET


def agv(text: str) -> AgvAddress:
    return AgvAddress.of(Version.V2_1, *text.split("/"))


class Robots:
    """Stands in for the robots of an account in the cloud."""

    def __init__(self) -> None:
        self.files: dict[str, dict[str, Any]] = {}

    def put(self, name: str, **fields: Any) -> None:
        self.files[name] = {
            "id": name,
            "map": "hall",
            "model": "turtlebot2",
            "parameters": {"follow_path": {}},
            **fields,
        }

    async def get(self, path: str) -> dict[str, Any]:
        await asyncio.sleep(0)
        name = path.rpartition("/")[2]
        if name not in self.files:
            raise NotFound("robot", name)
        return self.files[name]

    async def put_robot(self, name: str, file: RobotFile) -> None:
        await asyncio.sleep(0)
        self.put(name, parameters=file.parameters, properties=file.properties)

    async def patch(self, path: str, change: dict[str, Any]) -> None:
        self.files[path.rpartition("/")[2]].update(change)


@pytest.fixture
def robots() -> Robots:
    return Robots()


async def taken(at: Robots, *agvs: str, **options: Any) -> list[str]:
    """Return the ids of the robots that AGVs are which come at the same time."""
    registry = AgvRegistry(at, FleetOptions(**options))  # type: ignore[arg-type]
    async with AsyncExitStack() as stack:
        entered = (stack.enter_async_context(registry.robot(agv(one), "hall", FACTSHEET)) for one in agvs)
        return [str(known["id"]) for known in await asyncio.gather(*entered)]


async def test_agvs_of_two_makers_with_one_serial_number_are_two_robots(robots: Robots) -> None:
    first, second = await taken(robots, "alpha/1234", "beta/1234")
    assert {first, second} == {"1234", "beta_1234"} or {first, second} == {"1234", "alpha_1234"}
    assert await taken(robots, "beta/1234") == [second], "also after the first has left"
    assert await taken(robots, "alpha/1234") == [first]


async def test_serials_that_differ_in_characters_that_ids_lack_are_two_robots(robots: Robots) -> None:
    found = await taken(robots, "alpha/a.1", "alpha/a 1", "alpha/a_1")
    assert len(set(found)) == 3
    assert await taken(robots, "alpha/a_1", "alpha/a 1", "alpha/a.1") == found[::-1]


async def test_an_agv_keeps_its_robot_when_the_one_that_had_its_name_is_gone(robots: Robots) -> None:
    robots.put("1234", properties={"vda5050": {"manufacturer": "alpha", "serialNumber": "1234"}})
    assert await taken(robots, "beta/1234") == ["beta_1234"]
    del robots.files["1234"]
    assert await taken(robots, "beta/1234") == ["beta_1234"]


async def test_the_file_of_a_robot_says_whose_it_is_from_the_first_time_on(robots: Robots) -> None:
    robots.put("1234", properties={"shelf": 7})
    assert await taken(robots, "alpha/1234") == ["1234"]
    assert robots.files["1234"]["properties"]["vda5050"] == {"manufacturer": "alpha", "serialNumber": "1234"}
    assert await taken(robots, "beta/1234") == ["beta_1234"]


@pytest.mark.parametrize(
    "named", [{"manufacturer": "alpha"}, {"serialNumber": "9"}, {"manufacturer": "beta", "serialNumber": "9"}]
)
async def test_an_agv_that_is_listed_is_refused_as_the_robot_of_another(robots: Robots, named: dict[str, str]) -> None:
    robots.put("fork", properties={"vda5050": named})
    with pytest.raises(
        Conflict, match=r"robot 'fork' is AGV '.*' by its file or .*, not 'beta/1234': .* --agv beta/1234=ROBOT"
    ):
        await taken(robots, "beta/1234", robots={"beta/1234": "fork"})


async def test_two_agvs_that_are_listed_as_one_robot_are_not_it_at_once(robots: Robots) -> None:
    robots.put("fork", properties={})
    listed = {"alpha/1": "fork", "beta/1": "fork"}
    assert await taken(robots, "alpha/1", robots=listed) == ["fork"]
    with pytest.raises(Conflict, match="'alpha/1'"):
        await taken(robots, "alpha/1", "beta/1", robots=listed)
    assert "vda5050" not in robots.files["fork"]["properties"], "the operator says whose it is"


async def test_without_registration_the_robot_of_another_is_refused_with_what_helps(robots: Robots) -> None:
    robots.put("1234", properties={"vda5050": {"manufacturer": "alpha", "serialNumber": "1234"}})
    with pytest.raises(Conflict, match="--agv beta/1234=ROBOT"):
        await taken(robots, "beta/1234", register=False)
    with pytest.raises(NotFound):
        await taken(robots, "beta/77", register=False)


async def test_an_agv_whose_factsheet_cannot_be_read_is_not_registered_without_a_size(robots: Robots) -> None:
    registry = AgvRegistry(robots, FleetOptions())  # type: ignore[arg-type]
    registry.unreadable[agv("alpha/1")] = "factsheet: not JSON"
    with pytest.raises(Conflict, match="give --radius, or mend its factsheet: factsheet: not JSON"):
        async with registry.robot(agv("alpha/1"), "hall", None):
            pass
    assert not robots.files


@pytest.mark.parametrize(("radius", "expected"), [(None, {}), (0.6, {"global_costmap": {"robot_radius": 0.6}})])
def test_a_factsheet_without_a_size_counts_as_none(radius: float | None, expected: dict[str, Any]) -> None:
    file = robot_file(agv("alpha/1"), "hall", Factsheet(), radius)
    assert file.parameters == {"follow_path": {}, **expected}


def test_a_factsheet_that_differs_from_the_file_is_reported() -> None:
    assert FACTSHEET.physical_parameters is not None
    file = robot_file(agv("alpha/1"), "hall", FACTSHEET, None)
    assert differences({"model": "turtlebot2", "parameters": file.parameters}, FACTSHEET) == ()
    small = {"model": "turtlebot2", "parameters": {"global_costmap": {"robot_radius": 0.25}}}
    (text,) = differences(small, FACTSHEET)
    assert text.startswith(
        f"the radius is 0.25 m by the robot's file, and "
        f"{radius_of(FACTSHEET.physical_parameters):.2f} m by the factsheet"
    )
    assert differences({"model": "turtlebot2", "parameters": {}}, FACTSHEET)
    assert differences(small, None) == differences(small, Factsheet()) == ()
