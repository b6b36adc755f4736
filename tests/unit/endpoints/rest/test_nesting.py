"""Values that are nested too deeply are refused before they are stored, and stored ones do not break a list.

The kind: input that is accepted and cannot be shown again. Its members: objects, lists and both, in the parameters and
properties of robots and the parameters of plans, by PUT and by PATCH; text that is not Unicode; numbers that are not
finite or too large.
"""

from typing import Any

import httpx
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endpoints.rest.nesting import HIDDEN, MAX_NESTING, MAX_SHOWN, is_deeper, showable
from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

JSON = {"Content-Type": "application/json"}


def depth_of(value: Any) -> int:
    children = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if children is None else 1 + max(map(depth_of, children), default=0)


values = st.recursive(st.integers(), lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=2), inner))


@given(values)
def test_the_depth_of_a_value_is_measured(value: Any) -> None:
    depth = depth_of(value)
    assert not is_deeper(value, depth)
    assert depth == 0 or is_deeper(value, depth - 1)


def nested(before: str, after: str, count: int) -> str:
    return before * count + "1" + after * count


TOO_DEEP = [
    nested('{"a":', "}", MAX_NESTING + 1),
    nested('{"a":', "}", 300),
    '{"a":' + nested("[", "]", 300) + "}",
    '{"a":' + nested('[{"a":', "}]", 100) + "}",
]


@pytest.mark.parametrize("value", TOO_DEEP, ids=["a level more", "objects", "lists", "both"])
@pytest.mark.parametrize("field", ["parameters", "properties"])
async def test_a_robot_with_too_deep_values_is_refused_and_not_stored(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, field: str, value: str
) -> None:
    header = await log_in("ann")
    await publish(header)
    answer = await client.put("/v1/robots/tb1", headers=header | JSON, content=f'{{"map":"house","{field}":{value}}}')
    assert f"at most {MAX_NESTING}" in problem_of(answer, 422, "invalid-request")["detail"]
    most = nested('{"a":', "}", MAX_NESTING)
    answer = await client.put("/v1/robots/tb1", headers=header | JSON, content=f'{{"map":"house","{field}":{most}}}')
    assert answer.status_code == 201
    answer = await client.patch("/v1/robots/tb1", headers=header | JSON, content=f'{{"{field}":{value}}}')
    problem_of(answer, 422, "invalid-request")
    [listed] = (await client.get("/v1/robots", headers=header)).json()["items"]
    assert not is_deeper(listed[field], MAX_NESTING)


@pytest.mark.parametrize("value", TOO_DEEP)
async def test_a_plan_with_too_deep_parameters_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, value: str
) -> None:
    header = await log_in("ann")
    await publish(header)
    plan = f'{{"map":"house","planner":"dijkstra","poses":[[0,0,0,0,0,0,1]],"parameters":{value}}}'
    problem_of(await client.put("/v1/plans/p1", headers=header | JSON, content=plan), 422, "invalid-request")
    problem_of(await client.get("/v1/plans/p1", headers=header), 404, "not-found")


@pytest.mark.parametrize("value", [r'"\ud800"', "9" * 400, "NaN", "1e400"])
async def test_values_that_cannot_be_written_again_are_refused_and_not_stored(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, value: str
) -> None:
    header = await log_in("ann")
    await publish(header)
    answer = await client.put(
        "/v1/robots/tb1", headers=header | JSON, content=f'{{"map":"house","parameters":{{"a":{value}}}}}'
    )
    assert answer.status_code in (400, 422)
    assert (await client.get("/v1/robots", headers=header)).json()["items"] == []


async def test_a_stored_robot_that_cannot_be_shown_does_not_break_the_list(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    header = await log_in("ann")
    await publish(header)
    for name in ("deep", "good"):
        await client.put(f"/v1/robots/{name}", headers=header, json={"map": "house", "parameters": {"a": 1}})
    deep: dict[str, Any] = {}
    for _ in range(300):
        deep = {"a": deep}
    services.store.put_robot(msgspec.structs.replace(services.store.robot("ann", "deep"), parameters=deep))
    items = (await client.get("/v1/robots", headers=header)).json()["items"]
    assert [(item["id"], item["parameters"]) for item in items] == [("deep", HIDDEN), ("good", {"a": 1})]
    assert (await client.get("/v1/robots/deep", headers=header)).json()["parameters"] == HIDDEN


def test_what_can_be_shown_is_shown_unchanged() -> None:
    value: list[Any] = []
    for _ in range(MAX_SHOWN - 1):
        value = [value]
    assert showable(value) is value
    assert showable([value]) == HIDDEN
