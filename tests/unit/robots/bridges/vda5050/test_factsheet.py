"""Factsheets of robots, checked against the published schemas."""

import pytest

from ppaas.errors import NotFound
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.topics import Address, Version
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.factsheet import factsheet_of
from tests.support.vda5050.schemas import problems


@pytest.mark.parametrize("version", Version)
@pytest.mark.parametrize("model", ["turtlebot2", "turtlebot3_burger"])
def test_factsheets_satisfy_the_published_schemas(version: Version, model: str) -> None:
    options = AgvOptions(version, services={"beep": "/beep"}, zones=True)
    sheet = factsheet_of({"model": model, "description": "a robot"}, options)
    headers = HeaderCounter(version, Address.of(version, "ppaas", "tb1"))
    payload = encode(topics.FACTSHEET, headers.next(topics.FACTSHEET, 0.0), sheet, version)
    assert problems(version, topics.FACTSHEET, payload) == []


def test_a_factsheet_tells_the_body_and_the_actions_of_its_version() -> None:
    old, new = (
        factsheet_of({"model": "turtlebot3_burger"}, AgvOptions(version, services={"beep": "/beep"}))
        for version in (Version.V2_1, Version.V3_0)
    )
    body = new.physical_parameters
    assert (body.maximum_speed, body.maximum_height) == (0.22, 0.192)
    assert body.width == pytest.approx(0.21) and body.length == pytest.approx(0.21)
    names = [{one.action_type for one in sheet.protocol_features.mobile_robot_actions} for sheet in (old, new)]
    assert names[0] ^ names[1] == {
        "initPosition", "initializePosition", "clearInstantActions", "enableZoneSet", "deleteZoneSet",
    }  # fmt: skip
    assert "beep" in names[0] & names[1]
    assert new.type_specification.supported_zones == []


def test_an_unknown_model_is_refused() -> None:
    with pytest.raises(NotFound, match="robot model"):
        factsheet_of({"model": "rover"}, AgvOptions())
