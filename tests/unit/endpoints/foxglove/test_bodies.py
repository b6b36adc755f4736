"""Bodies of robots as viewers see them."""

from typing import Any

import pytest

from endpoints.foxglove.bodies import body_scene
from endpoints.services.services import Services
from ppaas.clone.robot_body import robot_body
from ppaas.wire.foxglove.conversion.scenes import SCENE
from tests.support.clients.foxglove_viewer import read_protobuf
from tests.support.storage import records

BOX = [[0.3, 0.2], [0.3, -0.2], [-0.1, -0.2], [-0.1, 0.2]]


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
