"""A viewer sees robots with clones, their topics, and nothing that it has not subscribed to."""

import struct
from typing import Any

import pytest
from foxglove import messages as sdk

from endpoints.foxglove.robot_view import body_scene
from endpoints.resources.services import Services
from engine.protocols import robot_link
from engine.sessions.outbox import MAX_KEEP
from engine.specs.containers import MapVersion
from ppaas.clone.robot_body import robot_body
from ppaas.errors import NotAuthenticated, NotPermitted, Unavailable
from ppaas.wire.foxglove.conversion.scenes import SCENE
from storage.sharing_records import Share
from tests.support.clients.foxglove_viewer import read_protobuf
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.foxglove import StillViewer
from tests.support.endpoints.rapyuta import ClonePlace, StillSessions
from tests.support.storage import records
from tests.support.waiting import until

SCAN = {
    "header": {"frame_id": "base_scan"},
    "angle_min": 0.0,
    "angle_max": 1.0,
    "angle_increment": 0.5,
    "range_min": 0.1,
    "range_max": 4.0,
    "ranges": [1.0, None, 9.0],
}


async def test_nothing_is_subscribed_until_the_viewer_subscribes(viewer: StillViewer, place: ClonePlace) -> None:
    assert {"/tb1/scan", "/tb1/map", "/tb1/model", "/tb1/move_base/status"} <= viewer.channels.keys()
    assert not any(topic.startswith("/tb2/") for topic in viewer.channels)
    assert not place.heard()
    viewer.subscribe("/tb1/scan")
    viewer.subscribe("/tb1/scan", 2)
    assert place.heard() == {"scan"}
    viewer.say("unsubscribe", subscriptionIds=[1])
    assert place.heard() == {"scan"}
    viewer.say("unsubscribe", subscriptionIds=[2])
    assert not place.heard()
    assert not viewer.statuses


async def test_a_scan_comes_in_the_schema_of_foxglove(viewer: StillViewer, place: ClonePlace) -> None:
    viewer.subscribe("/tb1/scan", 7)
    place.publish_json("scan", SCAN)
    viewer.read()
    [(subscription, data)] = viewer.messages
    nan = float("nan")
    expected = sdk.LaserScan(
        timestamp=sdk.Timestamp(0, 0),
        frame_id="tb1/base_scan",
        pose=sdk.Pose(position=sdk.Vector3(), orientation=sdk.Quaternion(w=1.0)),
        end_angle=1.0,
        ranges=[1.0, nan, nan],
    )
    assert (subscription, data) == (7, expected.encode())


async def test_the_body_of_a_robot_is_in_its_base_frame(viewer: StillViewer) -> None:
    viewer.subscribe("/tb1/model", 3)
    await until(lambda: len(viewer.viewer.outbox) > 0)
    viewer.read()
    [(subscription, data)] = viewer.messages
    assert subscription == 3
    assert b"tb1/base_link" in data and b"tb1" in data


async def test_a_message_that_is_malformed_is_reported(viewer: StillViewer, place: ClonePlace) -> None:
    viewer.subscribe("/tb1/scan")
    place.say(robot_link.Published("scan", b'{"header": 5}'))
    place.publish_json("scan", SCAN)
    viewer.read()
    assert len(viewer.messages) == 1
    [status] = viewer.statuses
    assert status.startswith("malformed-message: ")


async def test_a_slow_viewer_gets_the_newest_scan(viewer: StillViewer, place: ClonePlace) -> None:
    viewer.subscribe("/tb1/scan")
    for number in range(5000):
        place.publish_json("scan", SCAN | {"ranges": [number % 4]})
    assert len(viewer.viewer.outbox) == 2  # and the time
    viewer.read()
    [(_, data)] = viewer.messages
    assert data.count(struct.pack("<d", 3.0)) == 1


async def test_a_large_map_is_converted_in_a_thread(viewer: StillViewer, place: ClonePlace) -> None:
    viewer.subscribe("/tb1/map")
    info = {"resolution": 0.05, "width": 400, "height": 400, "origin": {"position": {}, "orientation": {"w": 1.0}}}
    for value in (0, 50, 100):
        place.publish_json("map", {"header": {"frame_id": "map"}, "info": info, "data": [value] * 160_000})
    await until(lambda: len(viewer.viewer.outbox) > 0)
    await viewer.read_soon()
    assert 1 <= len(viewer.messages) <= 3
    assert viewer.messages[-1][1].endswith(bytes([100] * 1000))
    assert b"house\0" in viewer.messages[-1][1]


async def test_robots_come_and_go(
    viewer: StillViewer, sessions: StillSessions, services: Services, cloud: FakeCloud, place: ClonePlace
) -> None:
    viewer.subscribe("/tb1/scan")
    sessions.link.close(Unavailable("its container is gone"))
    await viewer.read_soon()
    assert not viewer.channels
    assert not sessions.attached
    sessions.place = ClonePlace()
    cloud.running = [container(), container("c2", robot="tb2", map=MapVersion("new:lab", ""))]
    await viewer.look()
    assert {"/tb1/scan", "/tb2/scan"} <= viewer.channels.keys()
    frames = {view.name: view.frames for view in viewer.viewer.views.values()}
    assert (frames["tb1"].map, frames["tb2"].map) == ("house", "")
    cloud.running = []
    await viewer.look()
    assert not viewer.channels and not viewer.viewer.views
    assert not viewer.statuses


async def test_a_viewer_sees_the_robots_that_it_names(
    services: Services, sessions: StillSessions, token: str, cloud: FakeCloud
) -> None:
    cloud.running = [container(), container("c2", robot="tb2")]
    viewer = StillViewer(services, sessions, token, "tb2", "nobody")
    await viewer.look()
    assert [view.name for view in viewer.viewer.views.values()] == ["tb2"]


async def test_shared_robots_are_below_the_name_of_their_owner(
    services: Services, sessions: StillSessions, token: str, cloud: FakeCloud
) -> None:
    await services.accounts.register("bob", "correct horse")
    share = Share("ann", "look", (), ("scan",))
    services.store.put_robot(records.robot("tb1", user="bob", shares=(share,)))
    cloud.running = [container(user="bob")]
    viewer = StillViewer(services, sessions, token)
    await viewer.look()
    assert viewer.channels.keys() == {"/bob/tb1/scan"}
    view, topic = viewer.viewer.find("/bob/tb1/scan")
    assert (view.name, topic) == ("bob/tb1", "scan")
    [attachment] = sessions.attached
    assert not attachment.request.hold


@pytest.mark.parametrize(("topics", "shown"), [(("robot_description",), True), (("*",), True), (("tf",), False)])
async def test_the_outline_of_a_robot_is_shown_to_those_who_may_read_its_description(
    services: Services, sessions: StillSessions, token: str, cloud: FakeCloud, topics: tuple[str, ...], shown: bool
) -> None:
    await services.accounts.register("bob", "correct horse")
    services.store.put_robot(records.robot("tb1", user="bob", shares=(Share("ann", "look", (), topics),)))
    cloud.running = [container(user="bob")]
    viewer = StillViewer(services, sessions, token)
    await viewer.look()
    assert ("/bob/tb1/model" in viewer.channels) == shown


async def test_a_robot_that_refuses_the_viewer_is_told_once(
    services: Services, sessions: StillSessions, token: str
) -> None:
    sessions.refusals = [NotPermitted("not today"), NotPermitted("not today")]
    viewer = StillViewer(services, sessions, token)
    await viewer.look()
    await viewer.look()
    assert viewer.statuses == ["robot tb1: not-permitted: not today"]
    await viewer.look()
    assert "/tb1/scan" in viewer.channels
    assert {"op": "removeStatus", "statusIds": ["tb1"]} in viewer.answers


async def test_a_viewer_whose_token_is_revoked_must_disconnect(viewer: StillViewer, services: Services) -> None:
    await services.accounts.revoke_all("ann")
    await viewer.look()
    assert isinstance(viewer.viewer.over.result(), NotAuthenticated)


async def test_a_viewer_that_does_not_read_what_it_must_disconnects(viewer: StillViewer) -> None:
    while not viewer.viewer.over.done():
        viewer.requests.take(struct.pack("<BIII", 2, 1, 1, 0) + bytes(1000))
    assert isinstance(viewer.viewer.over.result(), Unavailable)
    assert len(viewer.viewer.outbox) <= 10 * MAX_KEEP


BOX = [[0.3, 0.2], [0.3, -0.2], [-0.1, -0.2], [-0.1, 0.2]]


# Bodies of robots as viewers see them.


@pytest.mark.parametrize("given", [{}, {"footprint": BOX}, {"robot_radius": 0.5}])
async def test_a_body_has_the_outline_that_the_clone_plans_with(services: Services, given: dict[str, Any]) -> None:
    record = records.robot(parameters={"global_costmap": given})
    services.store.put_robot(record)
    data = body_scene(services.store, record, "tb1/base_link", "tb1")
    [entity] = read_protobuf({"schema": SCENE.data, "schemaName": SCENE.name}, data).entities
    drawn = [(point.x, point.y) for point in entity.lines[0].points]
    body = robot_body(record.model, None, record.parameters)
    if body.footprint:
        assert drawn == list(body.footprint)
    else:
        assert max(x for x, _ in drawn) == pytest.approx(body.robot_radius)


async def test_a_urdf_that_cannot_be_read_leaves_the_body_of_the_model(services: Services) -> None:
    record = records.robot()
    services.store.put_robot(record)
    plain = body_scene(services.store, record, "tb1/base_link", "tb1")
    services.store.put_urdf(record.user, record.id, b"<robot")
    assert body_scene(services.store, record, "tb1/base_link", "tb1") == plain
