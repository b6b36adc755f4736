"""Tools of the MCP server, called by the client of the MCP library in this process."""

import asyncio
import base64
import io
import json
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from mcp import Client
from mcp_types import CallToolResult, ImageContent
from PIL import Image

from ppaas.errors import Unavailable
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from robots.mcp import looking
from robots.mcp.narrowed_cloud import NarrowedCloud
from robots.mcp.server import RobotServer, tools_of
from tests.support.cloud.served_users import ServedUsers
from tests.support.endpoints.goals_of import GoalsOf
from tests.support.endpoints.still_place import StillRobot, delivered
from tests.support.storage import records
from tests.support.waiting import until

LOOKING = ["list_robots", "robot_state", "goal_state", "list_maps", "map_picture", "plan_path", "list_tasks"]
CHANGING = ["go_to", "cancel_goals", "stop_robot"]


def connected(served: ServedUsers, token: str = "", robots: frozenset[str] | None = None, **options: bool) -> Client:
    """Return a client of a server with a token, ann's by default."""
    chosen = {"read_only": False, "may_release": False} | options
    cloud = NarrowedCloud(served.url, token or served.tokens["ann"], robots)
    return Client(RobotServer(cloud, tools_of(**chosen)).mcp)


async def refusal(client: Client, tool: str, **arguments: Any) -> str:
    """Return the text of a refusal."""
    answer = await client.call_tool(tool, arguments)
    assert answer.is_error
    return text_of(answer)


async def answer_of(client: Client, tool: str, **arguments: Any) -> Any:
    """Return the structured answer of a tool, which its text repeats."""
    answer = await client.call_tool(tool, arguments)
    assert not answer.is_error, text_of(answer)
    assert json.loads(text_of(answer)) == answer.structured_content
    return answer.structured_content


def text_of(answer: CallToolResult) -> str:
    [first, *_] = answer.content
    return first.text  # type: ignore[union-attr]


async def scoped(served: ServedUsers, role: str, *robots: str) -> str:
    """Return a token of ann for some robots."""
    rest = RestClient(served.url, served.tokens["ann"])
    made = await rest.post("/v1/scoped-tokens", {"robots": robots, "role": role})
    return str(made["token"])


# -- what is offered ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, LOOKING + CHANGING),
        ({"read_only": True}, LOOKING),
        ({"may_release": True}, [*LOOKING, *CHANGING, "release_robot"]),
    ],
)
async def test_tools_are_offered_by_their_effect(
    served: ServedUsers, options: dict[str, bool], expected: list[str]
) -> None:
    async with connected(served, **options) as client:
        tools = (await client.list_tools()).tools
        assert [tool.name for tool in tools] == expected
        for tool in tools:
            Draft202012Validator.check_schema(tool.input_schema)
            assert tool.input_schema["additionalProperties"] is False
            assert tool.annotations is not None
            assert tool.annotations.read_only_hint == (tool.name in LOOKING)
            assert (tool.output_schema is None) == (tool.name == "map_picture")
        missing = {"go_to", "release_robot"} - set(expected)
        for name in missing:
            assert "not-found: unknown tool" in await refusal(client, name, robot="tb1")


@pytest.mark.parametrize(
    ("tool", "arguments", "fault"),
    [
        ("go_to", {"robot": "tb1", "x": 1.0, "y": 2.0, "yaww": 1.5}, "yaww: Extra inputs are not permitted"),
        ("go_to", {"robot": "tb1", "x": "1.0", "y": 2.0}, "x: Input should be a valid number"),
        ("go_to", {"robot": "tb1", "x": float("nan"), "y": 2.0}, "x: Input should be a"),
        ("go_to", {"robot": "tb1", "x": 1e12, "y": True}, "y: Input should be a valid number"),
        ("go_to", {"robot": "tb1", "y": 2.0}, "x: Field required"),
        ("go_to", {"robot": "tb1", "x": 1.0, "y": 2.0, "wait": -1.0}, "wait: Input should be greater"),
        ("robot_state", {"robot": "../users/me"}, "robot: String should match pattern"),
        ("cancel_goals", {"robot": "tb1", "goal": ".."}, "goal: String should match pattern"),
        ("stop_robot", {"robot": "tb1", "reason": "x" * 201}, "reason: String should have at most 200 characters"),
        ("list_robots", {"most": 501}, "most: Input should be less than or equal to 500"),
        ("map_picture", {"map": "house", "size": 100_000}, "size: Input should be less than or equal to 1600"),
        ("plan_path", {"robot": "tb1", "x": 1, "y": 2, "start": [1.0]}, "start: List should have at least 2 items"),
    ],
)
async def test_arguments_that_do_not_fit_are_refused_by_name(
    served: ServedUsers, place: StillRobot, tool: str, arguments: dict[str, Any], fault: str
) -> None:
    async with connected(served) as client:
        text = await refusal(client, tool, **arguments)
    assert text.startswith(f"invalid-input: {tool}: ")
    assert fault in text
    assert not delivered(place), "nothing was sent"


# -- looking -----------------------------------------------------------------------------------------------------------


async def test_robots_are_listed_with_the_name_that_other_tools_take(served: ServedUsers, place: StillRobot) -> None:
    store = served.services.store
    store.put_robot(records.robot("cart", user="bob"))
    await RestClient(served.url, served.tokens["bob"]).put("/v1/robots/cart/shares/ann", {"role": "look"})
    async with connected(served) as client:
        listed = await answer_of(client, "list_robots")
        assert [row["robot"] for row in listed["robots"]] == ["tb1", "tb2", "bob:cart"]
        assert [row["role"] for row in listed["robots"]] == ["administer", "administer", "look"]
        assert [row["state"] for row in listed["robots"]] == ["starting", "offline", "offline"]
        first = await answer_of(client, "list_robots", most=1)
        assert ([row["robot"] for row in first["robots"]], first["more"]) == (["tb1"], True)
        state = await answer_of(client, "robot_state", robot="bob:cart")
        assert (state["robot"], state["map"], state["connected"]) == ("bob:cart", "house", False)
        assert (await refusal(client, "robot_state", robot="tb9")).startswith("not-found: ")


async def test_a_server_for_some_robots_knows_no_others(served: ServedUsers, place: StillRobot) -> None:
    async with connected(served, robots=frozenset({"tb2"})) as client:
        listed = await answer_of(client, "list_robots")
        assert ([row["robot"] for row in listed["robots"]], listed["more"]) == (["tb2"], False)
        for tool in ("robot_state", "cancel_goals", "stop_robot"):
            text = await refusal(client, tool, robot="tb1")
            assert text == "not-permitted: this server serves tb2 alone, not tb1"
        assert "not-permitted" in await refusal(client, "go_to", robot="tb1", x=1.0, y=1.0)
        assert "not-permitted" in await refusal(client, "plan_path", robot="tb1", x=1.0, y=1.0)
    assert not delivered(place)


async def test_a_picture_of_a_large_fleet_names_what_it_leaves_out(
    served: ServedUsers, place: StillRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    await RestClient(served.url, served.tokens["ann"]).upload_map("house", records.YAML, records.pgm(20, 10))
    async with connected(served) as client:
        assert "robots alone" not in text_of(await client.call_tool("map_picture", {"map": "house"}))
        monkeypatch.setattr(looking, "MOST_ROBOTS", 1)
        assert "(of the first 1 robots alone)" in text_of(await client.call_tool("map_picture", {"map": "house"}))


async def test_a_map_is_listed_and_drawn_with_its_robots(served: ServedUsers, place: StillRobot) -> None:
    rest = RestClient(served.url, served.tokens["ann"])
    yaml = records.YAML.replace(b"0.05", b"0.5")
    await rest.upload_map("house", yaml, records.pgm(20, 10), description="ground floor")
    async with connected(served) as client:
        listed = await answer_of(client, "list_maps")
        assert [(row["id"], row["description"], row["parts"]) for row in listed["maps"]] == [
            ("house", "ground floor", ["image", "yaml"])
        ]
        drawn = await client.call_tool("map_picture", {"map": "house", "size": 200})
        assert "a pixel is 0.05 m" in text_of(drawn)
        [_, picture] = drawn.content
        assert isinstance(picture, ImageContent)
        pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(picture.data))))
        assert pixels.shape[:2] == (100, 200), "enlarged to the size"
        assert (await refusal(client, "map_picture", map="attic")).startswith("not-found: ")


async def test_tasks_are_listed(served: ServedUsers) -> None:
    rest = RestClient(served.url, served.tokens["ann"])
    await rest.upload_map("house", records.YAML, records.pgm())
    for priority in (1, 2):
        await rest.post("/v1/maps/house/tasks", {"kind": "go_to", "places": [[0.0, 0.0]], "priority": priority})
    async with connected(served) as client:
        listed = await answer_of(client, "list_tasks", map="house")
        assert [(row["priority"], row["state"], row["robot"]) for row in listed["tasks"]] == [
            (1, "queued", None), (2, "queued", None),
        ]  # fmt: skip
        assert (await answer_of(client, "list_tasks", map="house", most=1))["more"]
        assert not (await answer_of(client, "list_tasks", map="house", state="done"))["tasks"]


async def test_no_path_is_planned_for_a_robot_that_is_away(served: ServedUsers, place: StillRobot) -> None:
    async with connected(served) as client:
        text = await refusal(client, "plan_path", robot="tb2", x=1.0, y=1.0)
    assert text == "unavailable: robot tb2 is not connected, so its clone plans no path"


# -- rights ------------------------------------------------------------------------------------------------------------


async def test_the_cloud_refuses_what_the_token_does_not_permit(served: ServedUsers, place: StillRobot) -> None:
    async with connected(served, await scoped(served, "look", "tb1")) as client:
        assert [row["robot"] for row in (await answer_of(client, "list_robots"))["robots"]] == ["tb1"]
        assert (await answer_of(client, "robot_state", robot="tb1"))["connected"]
        for tool, arguments in (
            ("go_to", {"robot": "tb1", "x": 1.0, "y": 1.0}),
            ("cancel_goals", {"robot": "tb1"}),
            ("stop_robot", {"robot": "tb1"}),
            ("list_maps", {}),
            ("list_tasks", {"map": "house"}),
        ):
            assert (await refusal(client, tool, **arguments)).startswith("not-permitted: "), tool
        assert (await refusal(client, "robot_state", robot="tb2")).startswith("not-permitted: ")
    async with connected(served, served.tokens["bob"]) as client:
        assert (await refusal(client, "go_to", robot="ann:tb1", x=1.0, y=1.0)).startswith("not-found: ")
    async with connected(served, "no-token") as client:
        assert (await refusal(client, "list_robots")).startswith("not-authenticated: ")
    assert not delivered(place)


# -- driving -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("status", "state", "text"),
    [(Status.SUCCEEDED, "succeeded", ""), (Status.ABORTED, "aborted", "in a keep-out zone")],
)
async def test_a_goal_is_followed_to_its_end(
    served: ServedUsers, place: StillRobot, status: Status, state: str, text: str
) -> None:
    heard: list[tuple[float, float | None, str | None]] = []
    goals = GoalsOf(place)

    async def progressed(done: float, total: float | None, message: str | None) -> None:
        heard.append((done, total, message))
        if len(heard) == 3:
            goals.end(status, text)

    async with connected(served) as client:
        arguments = {"robot": "tb1", "x": 4.0, "y": 1.5, "wait": 60.0}
        answer = await client.call_tool("go_to", arguments, progress_callback=progressed)
        assert not answer.is_error, text_of(answer)
        goal = answer.structured_content
        assert (goal["state"], goal["text"], goal["pose"]) == (state, text, [4.0, 1.5, 0.0])
        shown = await answer_of(client, "goal_state", robot="tb1", goal=goal["id"])
        assert shown == goal
    assert [done for done, _, _ in heard] == sorted(done for done, _, _ in heard)
    assert {total for _, total, _ in heard} == {60.0}
    assert all(message is not None and message.startswith(("pending", "active")) for _, _, message in heard)
    assert not goals.cancelled


async def test_a_cloud_that_is_away_for_a_while_does_not_end_a_call(
    served: ServedUsers, place: StillRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals, asked, get = GoalsOf(place), [0], RestClient.get

    async def sometimes(rest: RestClient, path: str) -> Any:
        asked[0] += 1
        if asked[0] <= 3:
            raise Unavailable("the cloud restarts")
        goals.end(Status.SUCCEEDED)
        return await get(rest, path)

    async def never(_rest: RestClient, _path: str) -> Any:
        raise Unavailable("the cloud restarts")

    async with connected(served) as client:
        monkeypatch.setattr(RestClient, "get", sometimes)
        assert (await answer_of(client, "go_to", robot="tb1", x=4.0, y=1.5, wait=60.0))["state"] == "succeeded"
        assert asked[0] > 3
        monkeypatch.setattr(RestClient, "get", never)
        text = await refusal(client, "go_to", robot="tb1", x=4.0, y=1.5, wait=0.1)
    away = "how far it is cannot be seen now: the cloud restarts"
    assert text == f"unavailable: goal {goals.sent[-1]} was sent, and {away}"
    assert not goals.cancelled


async def test_after_its_time_a_call_returns_and_the_robot_drives_on(served: ServedUsers, place: StillRobot) -> None:
    goals = GoalsOf(place)
    async with connected(served) as client:
        goal = await answer_of(client, "go_to", robot="tb1", x=4.0, y=1.5, wait=0.0)
        assert goal["state"] == "pending"
        [active] = (await answer_of(client, "robot_state", robot="tb1"))["goals"]
        assert active["id"] == goal["id"]
        assert not goals.cancelled
        ending = await answer_of(client, "cancel_goals", robot="tb1", goal=goal["id"])
        assert [one["id"] for one in ending["goals"]] == [goal["id"]]
    assert goals.cancelled == [goal["id"]]


async def test_all_goals_are_cancelled(served: ServedUsers, place: StillRobot) -> None:
    async with connected(served) as client:
        goal = await answer_of(client, "go_to", robot="tb1", x=4.0, y=1.5, wait=0.0)
        ending = await answer_of(client, "cancel_goals", robot="tb1")
        assert [one["id"] for one in ending["goals"]] == [goal["id"]]
    assert len(GoalsOf(place).cancelled) == 1


async def test_a_cancelled_call_cancels_its_goal(served: ServedUsers, place: StillRobot) -> None:
    goals = GoalsOf(place)
    async with connected(served) as client:
        call = asyncio.create_task(client.call_tool("go_to", {"robot": "tb1", "x": 4.0, "y": 1.5, "wait": 600.0}))
        await until(lambda: goals.sent)
        call.cancel()
        await until(lambda: goals.cancelled)
        assert goals.cancelled == goals.sent


async def test_a_call_that_is_cancelled_while_its_goal_is_sent_cancels_the_goal(
    served: ServedUsers, place: StillRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals, asked, answered, post = GoalsOf(place), asyncio.Event(), asyncio.Event(), RestClient.post

    async def slow(rest: RestClient, path: str, value: Any) -> Any:
        asked.set()
        await answered.wait()
        return await post(rest, path, value)

    monkeypatch.setattr(RestClient, "post", slow)
    async with connected(served) as client:
        call = asyncio.create_task(client.call_tool("go_to", {"robot": "tb1", "x": 4.0, "y": 1.5}))
        await asked.wait()
        call.cancel()
        answered.set()
        await until(lambda: goals.cancelled)
        assert goals.cancelled == goals.sent


async def test_a_robot_that_is_not_connected_takes_no_goal(served: ServedUsers, place: StillRobot) -> None:
    async with connected(served) as client:
        assert (await refusal(client, "go_to", robot="tb2", x=1.0, y=1.0)).startswith("unavailable: ")


async def test_a_stop_holds_until_it_is_released(served: ServedUsers, place: StillRobot) -> None:
    async with connected(served, may_release=True) as client:
        stopped = await answer_of(client, "stop_robot", robot="tb2", reason="a child is near")
        assert [(one["name"], one["by"], one["reason"]) for one in stopped["stops"]] == [
            ("tb2", "ann", "a child is near")
        ]
        assert "a child is near" in (await answer_of(client, "robot_state", robot="tb2"))["stopped"]
        released = await answer_of(client, "release_robot", robot="tb2")
        assert ([one["name"] for one in released["released"]], released["left"]) == (["tb2"], [])
        assert (await answer_of(client, "robot_state", robot="tb2"))["stopped"] is None
