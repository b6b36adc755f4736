"""Representations of paths over REST: JSON and CBOR, with poses in full, in short, and as a polyline."""

import io
import json
import math
from typing import Any

import cbor2
import httpx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endpoints.rest.plans.representations import CBOR, JSON, PoseForm, Representation, polyline_of, preferred, short
from ppaas.errors import NotFound
from ppaas.geometry import poses_along, quaternion_of
from tests.support.endpoints.cbor_arrays import array_in
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

REQUEST: dict[str, Any] = {"start": [0.1, 0.2, 0.0], "goal": [3.1, 4.2, 1.0]}
HEADING = math.atan2(4.0, 3.0)
SHORT = [[0.1, 0.2, HEADING], [3.1, 4.2, 1.0]]
POLYLINE = "gEoKozD_yF"
ROUTES = ("/v1/maps/house/plans", "/v1/maps/house/plans?poses={form}&unknown=1")
"""The route as the fast path serves it, and with a query that is left to FastAPI."""


@pytest.mark.parametrize(
    ("accept", "media_type"),
    [
        ("", JSON),
        ("*/*", JSON),
        ("application/json", JSON),
        ("application/cbor", CBOR),
        ("Application/CBOR", CBOR),
        ("application/cbor, application/json", JSON),
        ("application/cbor, application/json;q=0.9", CBOR),
        ("application/cbor;q=0.5, */*;q=0.4", CBOR),
        ("application/cbor;q=0.5, application/*;q=0.6", JSON),
        ("application/json;q=0, */*", CBOR),
        ("application/cbor;q=0, */*", JSON),
        ("application/cbor;q=0", JSON),
        ("application/cbor; q=1.0; ext=1", CBOR),
        ("application/cbor;q=much", JSON),
        ("text/html", JSON),
        ("text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8", JSON),
        (",;,=,q=", JSON),
    ],
)
def test_the_preferred_media_type(accept: str, media_type: str) -> None:
    assert preferred(accept) == media_type


@given(st.text(alphabet="aplictonjsbr/*,;=q.019 ", max_size=60))
def test_any_header_prefers_one(accept: str) -> None:
    assert preferred(accept) in (JSON, CBOR)


async def posted(client: httpx.AsyncClient, ann: dict[str, str], route: str, **headers: str) -> httpx.Response:
    answer = await client.post(route, headers=ann | headers, json=REQUEST)
    assert answer.status_code == 201, answer.text
    return answer


@pytest.mark.parametrize("route", ROUTES)
async def test_a_path_is_returned_as_cbor_with_all_digits(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, route: str
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    route = route.format(form="rows")
    plain = (await posted(client, ann, route)).json()
    answer = await posted(client, ann, route, accept=CBOR)
    assert answer.headers["content-type"] == CBOR
    fields = cbor2.loads(answer.content)
    poses = array_in(fields.pop("poses"))
    assert poses.tobytes() == poses_along(np.array([[0.1, 0.2], [3.1, 4.2]]), 1.0).tobytes()
    np.testing.assert_allclose(poses, plain.pop("poses"), atol=6e-10)
    assert fields == plain


@pytest.mark.parametrize("media_type", [JSON, CBOR])
async def test_short_poses_and_polylines(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, media_type: str
) -> None:
    ann = await log_in("ann")
    await publish(ann)

    async def poses(path: str, method: str = "POST") -> Any:
        given = {"json": REQUEST} if method == "POST" else {}
        answer = await client.request(method, path, headers=ann | {"accept": media_type}, **given)  # type: ignore[arg-type]
        assert answer.is_success, answer.text
        found = answer.json() if media_type == JSON else cbor2.load(io.BytesIO(answer.content))
        return found["poses"], found["plan_id"]

    shortened, plan_id = await poses("/v1/maps/house/plans?poses=xyyaw")
    rows = shortened if media_type == JSON else array_in(shortened)
    np.testing.assert_allclose(rows, SHORT, atol=6e-10)
    assert (await poses("/v1/maps/house/plans?poses=polyline"))[0] == POLYLINE
    again, _ = await poses(f"/v1/plans/{plan_id}?poses=xyyaw", "GET")
    np.testing.assert_allclose(again if media_type == JSON else array_in(again), SHORT, atol=6e-10)
    assert (await poses(f"/v1/plans/{plan_id}?poses=polyline", "GET"))[0] == POLYLINE


async def test_an_unknown_form_is_refused(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await publish(ann)
    answer = await client.post("/v1/maps/house/plans?poses=spline", headers=ann, json=REQUEST)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"] == ["query", "poses"]


async def test_errors_are_problems_whatever_is_accepted(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    cloud.error = NotFound("planner", "x")
    answer = await client.post("/v1/maps/house/plans", headers=ann | {"accept": CBOR}, json=REQUEST)
    problem_of(answer, 404, "not-found")


async def test_poses_of_planners_are_rounded_as_in_the_first_answer_and_given_ones_are_not(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await posted(client, ann, "/v1/maps/house/plans")).json()
    assert made["poses"][0][5:] == [round(value, 9) for value in quaternion_of(HEADING)[2:]]
    kept = await client.get(f"/v1/plans/{made['plan_id']}", headers=ann)
    assert kept.json()["poses"] == made["poses"]
    rows = [[1 / 3, 2 / 3, 0.0, 0.0, 0.0, *quaternion_of(0.1)[2:]]] * 2
    given = {"map": "house", "planner": "mine", "poses": rows}
    assert (await client.put("/v1/plans/own", headers=ann, json=given)).status_code == 201
    assert (await client.get("/v1/plans/own", headers=ann)).json()["poses"] == rows
    answer = await client.get("/v1/plans/own", headers=ann | {"accept": CBOR})
    assert array_in(cbor2.loads(answer.content)["poses"]).tolist() == rows


@given(st.floats(-math.pi, math.pi), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_short_poses_have_the_yaw_of_the_quaternion(yaw: float, x: float, y: float) -> None:
    [row] = short(np.array([[x, y, 0.0, *quaternion_of(yaw)]])).tolist()
    assert row[:2] == [x, y]
    assert math.remainder(row[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("form", PoseForm)
@pytest.mark.parametrize("media_type", [JSON, CBOR])
def test_a_path_without_poses_has_a_representation(form: PoseForm, media_type: str) -> None:
    body = Representation(media_type, form).encode({"poses": np.empty((0, 7))})
    poses = (json.loads if media_type == JSON else cbor2.loads)(body)["poses"]
    if form is PoseForm.POLYLINE:
        assert poses == ""
    else:
        assert len(poses if media_type == JSON else array_in(poses)) == 0


coordinates = st.floats(-1e6, 1e6)


def decoded(text: str, decimals: int) -> list[list[float]]:
    """Return the points of a polyline, as the description of the format decodes it: character by character."""
    numbers, value, shift = list[int](), 0, 0
    for character in text:
        part = ord(character) - 63
        value |= (part & 31) << shift
        shift += 5
        if not part & 32:
            numbers.append(~(value >> 1) if value & 1 else value >> 1)
            value = shift = 0
    points = np.cumsum(np.array(numbers, np.int64).reshape(-1, 2), axis=0)
    return (points / 10.0**decimals).tolist()


def test_the_example_of_the_format() -> None:
    points = np.array([[38.5, -120.2], [40.7, -120.95], [43.252, -126.453]])
    assert polyline_of(points, 5) == "_p~iF~ps|U_ulLnnqC_mqNvxq`@"


@given(st.lists(st.tuples(coordinates, coordinates), max_size=20))
def test_points_round_trip_to_the_millimetre(points: list[tuple[float, float]]) -> None:
    given_points = np.array(points).reshape(-1, 2)
    again = np.array(decoded(polyline_of(given_points), 3)).reshape(-1, 2)
    np.testing.assert_allclose(again, given_points, rtol=0.0, atol=5.001e-4)


def test_a_step_between_cells_takes_four_characters() -> None:
    points = np.cumsum(np.full((100, 2), 0.05), axis=0)
    assert len(polyline_of(points)) == pytest.approx(400, abs=8)
