"""Numbers, topics and schemas in foxglove.md are those of the code."""

from endpoints.foxglove import app, robot_view, viewer
from endpoints.foxglove.app import MAX_FRAME
from ppaas.messages import type_name
from ppaas.nodes.topics import TOPICS
from ppaas.wire.foxglove import session
from ppaas.wire.foxglove.conversion.conversions import PICTURES, conversion_of
from ppaas.wire.foxglove.conversion.scenes import BODY, SCENE
from tests.support.documents import table, text_of

PAGE = "docs/foxglove.md"
SCENES = {BODY, *(topic for _, topic, _ in PICTURES.values())}


def test_topics_have_the_schemas_of_the_table() -> None:
    for names, schema, _ in table(PAGE, "topic", "schema", "in Foxglove")[:-1]:
        for name in names.replace("`", "").split(", "):
            found = SCENE if name in SCENES else conversion_of(type_name(TOPICS[name].type)).schema
            assert found.name == schema, name


def test_limits_are_those_of_the_code() -> None:
    own = f"{session.MAX_SUBSCRIPTIONS}; {session.MAX_CLIENT_CHANNELS}"
    limits = {what: limit for what, limit, _ in table(PAGE, "what", "limit", "beyond it")}
    assert limits == {
        "viewers of one user; in all": f"{app.MAX_OF_USER}; {app.MAX_VIEWERS}",
        "robots of one viewer; robots that its address names": f"{robot_view.MAX_ROBOTS}; {app.MAX_NAMED}",
        "frame of a viewer": f"{MAX_FRAME >> 20} MiB",
        "subscriptions; channels that a viewer publishes": own,
        "requests of a viewer that wait for a clone": f"{viewer.MAX_WORK}",
        "parameters that a viewer watches by name": f"{viewer.MAX_WATCHED}",
        "messages that wait for a slow viewer": "as for [any client](protocol.md#limits)",
    }
    page = " ".join(text_of(PAGE).split())
    assert f"Robots come and go within {viewer.PERIOD:g} s" in page
    assert f"Changes come within {viewer.PERIOD:g} s" in page
