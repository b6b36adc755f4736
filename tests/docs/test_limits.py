"""The table of limits is that of the code."""

import pytest
import uvicorn
from python_multipart.multipart import DEFAULT_MAX_HEADER_COUNT, DEFAULT_MAX_HEADER_SIZE

from endpoints.foxglove import app
from endpoints.foxglove.app import Foxglove
from endpoints.foxglove.robot_view import MAX_ROBOTS
from endpoints.foxglove.viewer import MAX_WORK
from endpoints.http import connection_table, frame_pacing, http_protocol, tls, websocket_protocol
from endpoints.merging.coordinator import TRANSFER_TIMEOUT, TURN_TIMEOUT
from endpoints.protocols import MAX_FRAME
from endpoints.rapyuta import clone, executor, interfaces
from endpoints.resources import heavy_work, plan_writer
from endpoints.resources.joint_maps import MOST_ROBOTS
from endpoints.resources.services import RequestLimits
from endpoints.rest import paging, schemas, strict_json
from endpoints.rest.buildings.buildings import MOST_BUILDINGS
from endpoints.rest.maps import map_programs, multipart
from endpoints.rest.maps.upload_form import MAX_FIELDS, MAX_ZONES
from endpoints.rest.plans.schemas import MAX_MATRIX, MAX_WAYPOINTS
from engine.cloud_client import link_listener
from engine.control.master_calls import server
from engine.links import carried_session
from engine.protocols import handshakes, sockets
from engine.recorder import robot_recorder
from engine.remote import join_secrets, joining, machines
from ppaas.buildings import building
from ppaas.fleet.lane_placing import MOST_CELLS
from ppaas.mapping.serialization import rebuilding
from ppaas.maps import yaml_keys
from ppaas.maps.formats import map_yaml, netpbm, pictures
from ppaas.maps.grid import MAX_CELLS
from ppaas.nodes.grid_slam import joint_maps
from ppaas.nodes.recorder.node import MOST_PAYLOAD, MOST_SECONDS
from ppaas.people import settings as people
from ppaas.perception.depth_scan import MOST_PIXELS
from ppaas.recording import reader
from ppaas.recording.parameters import MOST_MB, MOST_MINUTES
from ppaas.robot_model import urdf, xml_document
from ppaas.wire import fragments
from ppaas.wire.binary import cbor
from ppaas.wire.foxglove import session
from ppaas.wire.foxglove.requests import MAX_LISTED, MAX_TEXT
from ppaas.wire.rapyuta import message_codec, part_assembler, requests
from ppaas.wire.ros import rmw_zenoh, ros1_master, tcpros, types
from ppaas.zones import zone
from robots.bridges.ros1 import connections, http, move_base
from robots.bridges.ros1 import node as ros1_node
from robots.bridges.zenoh import node
from storage.buildings import records
from tests.support.documents import table, text_of

LIMITS = "docs/limits.md"
SETTINGS = RequestLimits()
KEEP_ALIVE = uvicorn.Config("app").timeout_keep_alive


def size(count: float) -> str:
    """Return a size in bytes as the page has it."""
    return f"{count / (1 << 20):g} MiB" if count >= 1 << 20 else f"{count / (1 << 10):g} KiB"


ROWS = {
    ("connections", "number"): [connection_table.MAX_CONNECTIONS, connection_table.RESERVED_FILES],
    ("connections", "time without a request, in the beginning"): [f"{http_protocol.HEAD_SECONDS:g} s"],
    ("connections", "time between two requests"): [f"{KEEP_ALIVE:g} s"],
    ("connections", "time for the client to read a block of an answer"): [f"{http_protocol.UNREAD_SECONDS:g} s"],
    ("HTTP head", "size"): [size(http_protocol.MAX_HEAD)],
    ("HTTP head", "lines"): [http_protocol.MAX_LINES],
    ("HTTP head", "time from its first byte"): [f"{http_protocol.HEAD_SECONDS:g} s"],
    ("HTTP head", "requests that wait for the answer to one before"): [http_protocol.MAX_PIPELINED],
    ("HTTP body", "size"): [
        size(SETTINGS.max_body),
        f"{size(SETTINGS.max_login)} of a login",
        f"{size(SETTINGS.max_upload)} of a form",
    ],
    ("HTTP body", "time"): [f"{SETTINGS.max_body_seconds:g} s", f"{SETTINGS.max_upload_seconds:g} s of a form"],
    ("HTTP body", "chunk extensions and trailers without content between"): [size(http_protocol.MAX_HEAD)],
    ("HTTP body", "what still arrives after the answer and is dropped"): [
        f"{http_protocol.REST_SECONDS:g} s",
        size(http_protocol.REST_OF_BODY),
        f"{size(http_protocol.REST_OF_HEAD)} after a refused head",
    ],
    ("JSON body", "objects and lists"): [strict_json.MAX_CONTAINERS],
    ("JSON body", "keys of an object"): [strict_json.MAX_KEYS],
    ("JSON body", "objects and lists within each other"): [strict_json.MAX_DEPTH, f"{strict_json.MAX_NESTING} in free"],
    ("JSON body", "size of a free-form value"): [schemas.MAX_PARAMETERS],
    ("JSON body", "poses"): [MAX_WAYPOINTS, f"{MAX_MATRIX} starts and {MAX_MATRIX} goals"],
    ("settings of [people](people.md)", "zones, corners of a zone, targets, names"): [
        f"{people.MOST_ZONES}, {people.MOST_CORNERS}, {people.MOST_TARGETS}, {people.MOST_TARGETS}"
    ],
    ("query", "length of a `cursor`"): [paging.MAX_CURSOR],
    ("form with a map", "text fields"): [f"{MAX_FIELDS} fields", size(multipart.MAX_TEXT)],
    ("form with a map", "head of a part"): [f"{DEFAULT_MAX_HEADER_COUNT} lines", f"{DEFAULT_MAX_HEADER_SIZE} bytes"],
    ("YAML of a map", "size"): [size(map_yaml.MAX_YAML)],
    ("YAML of a map", "brackets, and levels of nesting"): [yaml_keys.MAX_BRACKETS, f"and {yaml_keys.MAX_DEPTH};"],
    ("[zones](zones.md) of a map", "size"): [size(MAX_ZONES), size(SETTINGS.max_body)],
    ("lanes of a map", "cells along them"): [MOST_CELLS],
    (
        "zones of a map",
        "zones, positions of all, positions of lanes, zones of the kind `capacity`, hours of a zone, stations",
    ): [
        zone.MOST_ZONES,
        zone.MOST_POSITIONS,
        zone.MOST_ON_LANES,
        zone.MOST_CAPACITIES,
        zone.MOST_HOURS,
        zone.MOST_MARKS,
    ],
    ("[building](buildings.md)", "floors, lifts, doors, ways"): [
        f"{building.MOST_FLOORS}, {building.MOST_LIFTS}, {building.MOST_DOORS}, {building.MOST_WAYS}"
    ],
    ("building", "former versions that are kept"): [records.MOST_FORMER, size(records.FORMER_BYTES)],
    ("buildings", "number of a user"): [MOST_BUILDINGS],
    ("image of a map", "header of PGM, PPM and PBM"): [size(netpbm.MAX_HEADER)],
    ("image of a map", "pixels of PGM and PPM"): [
        MAX_CELLS,
        f"fewer than {SETTINGS.max_upload} in a binary PGM",
        f"the form ends at {size(SETTINGS.max_upload)}",
    ],
    ("image of a map", "pixels of PBM"): [netpbm.MAX_BITS],
    ("image of a map", "pixels of PNG, BMP, JPEG and TIFF"): [pictures.MAX_PIXELS],
    ("image of a map", "chunks of a PNG"): [pictures.MAX_CHUNKS, f"{pictures.MAX_OTHERS} without pixels"],
    ("image of a map", "scans of a JPEG"): [pictures.MAX_SCANS],
    ("octree of a map", "memory and time of its check, in a separate process"): [
        f"{map_programs.MEMORY >> 20} MiB",
        f"{map_programs.CHECK_SECONDS:g} s",
    ],
    ("pose graph of a map", "memory of its key frames, and of its check, as for an octree"): [
        f"{rebuilding.MOST_BYTES >> 20} MiB",
        f"{map_programs.MEMORY >> 20} MiB",
    ],
    ("[joint map](mapping.md#joint-maps) for a robot", "size, and memory of its key frames"): [
        f"{joint_maps.MOST_BYTES >> 20} MiB",
        f"{rebuilding.MOST_BYTES >> 20} MiB",
    ],
    ("joint map", "robots, and joins at once"): [f"{MOST_ROBOTS}, and 1"],
    ("transfer of a joint map or its parts from or to a robot; other work of the owner", "time"): [
        f"{TRANSFER_TIMEOUT:g} s; {TURN_TIMEOUT:g} s"
    ],
    ("maps that are drawn from a pose graph or merged", "memory and time of a separate process"): [
        f"{map_programs.MEMORY >> 20} MiB",
        f"{map_programs.MAKE_SECONDS:g} s",
    ],
    ("images and octrees", "requests that decode or check at once"): [
        heavy_work.MAX_AT_ONCE,
        f"{heavy_work.MAX_OF_USER} of one user",
    ],
    ("recordings that are put together", "copies of one user at once"): [heavy_work.MAX_OF_USER],
    ("paths that wait for a store that takes none", "number, and size of their poses"): [
        plan_writer.MOST_UNSTORED,
        size(plan_writer.MOST_UNSTORED_BYTES),
    ],
    ("URDF", "size"): [size(xml_document.MAX_BYTES)],
    ("URDF", "links, joints and shapes"): [f"{urdf.MAX_LINKS}, {urdf.MAX_LINKS} and {urdf.MAX_SHAPES}"],
    ("WebSocket", "size of a message"): [size(MAX_FRAME)],
    ("WebSocket", "time from the first byte of a message to its last"): [f"{websocket_protocol.MESSAGE_TIMEOUT:g} s"],
    ("WebSocket", "use of the connection in proportion"): [
        f"{frame_pacing.FRAMES:g} frames/s",
        f"{size(frame_pacing.BYTES)}/s",
        f"{frame_pacing.BUSY:.0%}".replace("%", " %"),
    ],
    ("WebSocket", "frames that its container has not settled, beside streams such as `scan`"): [
        carried_session.MAX_KEPT,
        size(carried_session.MAX_KEPT_BYTES),
    ],
    ("WebSocket", "fragments (`op: fragment`) of incomplete messages"): [
        f"{fragments.MAX_OPEN} messages",
        fragments.MAX_FRAGMENTS,
        size(fragments.MAX_SIZE),
    ],
    ("WebSocket", "items of a frame in CBOR, numbers in its typed arrays, levels"): [
        f"{cbor.MAX_ITEMS}, {cbor.MAX_NUMBERS} and {cbor.MAX_DEPTH}"
    ],
    ("WebSocket", "ranges of a compact scan"): [0xFFFF],
    ("WebSocket", "pixels of a depth image"): [MOST_PIXELS],
    (
        "robot of [Rapyuta](rapyuta.md)",
        "binary parts of a message; messages and parts that wait for each other, their size and time",
    ): [
        part_assembler.MAX_PARTS,
        f"{part_assembler.MAX_WAITING} each, {size(part_assembler.MAX_BYTES)}, {part_assembler.TIMEOUT:g} s",
    ],
    ("robot of Rapyuta", "text of a message; objects and lists in it"): [
        size(part_assembler.MAX_TEXT),
        part_assembler.MAX_OBJECTS,
    ],
    (
        "robot of Rapyuta",
        "objects and lists within each other; items of a list of a configuration; id of a message",
    ): [part_assembler.MAX_DEPTH, f"{requests.MAX_ITEMS}; {requests.MAX_MESSAGE_ID} characters"],
    (
        "robot of Rapyuta",
        "containers; nodes of a container; interfaces of an endpoint, and their connections",
    ): [executor.MAX_CONTAINERS, f"{clone.MAX_NODES}; {interfaces.MAX_INTERFACES}, {interfaces.MAX_PEERS} each"],
    ("robot of Rapyuta", "message of a forwarder without compression"): [size(message_codec.MAX_SERIALIZED)],
    ("viewer of [Foxglove](foxglove.md)", "viewers of one user, and in all; robots of one viewer"): [
        f"{app.MAX_OF_USER}, {app.MAX_VIEWERS}; {MAX_ROBOTS}"
    ],
    ("viewer of Foxglove", "size of a message; subscriptions; channels it publishes; requests without an answer"): [
        f"{size(Foxglove.max_frame)}; {session.MAX_SUBSCRIPTIONS}; {session.MAX_CLIENT_CHANNELS}; {MAX_WORK}"
    ],
    ("viewer of Foxglove", "items in one list of a request; a name in it"): [f"{MAX_LISTED}; {MAX_TEXT} characters"],
    ("[recording](recording.md) of a robot", "time and size; all of a user"): [
        f"{MOST_SECONDS:g} s and {robot_recorder.MOST_BYTES >> 20} MiB; {robot_recorder.MOST_USER_BYTES >> 20} MiB"
    ],
    ("ring of a robot", "time and size"): [f"{MOST_MINUTES:g} min and {MOST_MB} MB"],
    ("recorded message", "size as JSON"): [size(MOST_PAYLOAD)],
    ("file of MCAP", "record, chunk after decompression, channels and schemas, metadata"): [
        f"{size(reader.MOST_RECORD)}, {size(reader.MOST_CHUNK)}, {reader.MOST_CHANNELS} each, {size(reader.MOST_NOTES)}"
    ],
    ("message of ROS in CDR or of ROS 1", "size"): [f"{types.MAX_MESSAGE >> 20} MiB"],
    ("connection header of ROS 1", "size; fields"): [f"{size(tcpros.MAX_HEADER)}; {tcpros.MAX_FIELDS}"],
    ("call or response of XML-RPC of ROS 1", "size"): [
        f"{size(ros1_master.MAX_CALL)} or {size(ros1_master.MAX_RESPONSE)}"
    ],
    (
        "node of the bridge of ROS 1",
        "connections for data, for calls; subscribers of a topic, publishers, clients of a service",
    ): [f"{ros1_node.MAX_PEERS}, {http.MAX_CONNECTIONS}; {connections.MAX_SUBSCRIBERS} each"],
    ("node of the bridge of ROS 1", "time for a header; time without a call"): [
        f"{connections.HEADER_TIMEOUT:g} s; {http.IDLE_TIMEOUT:g} s"
    ],
    ("subscriber in ROS 1 that does not read", "messages that wait for it"): [f"at most {move_base.MAX_GOALS}"],
    ("graph of a robot with ROS 2", "entities; token of one"): [node.MAX_ENTITIES, rmw_zenoh.MAX_TOKEN],
    ("TLS", "time of the handshake"): [
        f"{tls.HANDSHAKE_SECONDS:g} s",
        f"{sockets.HANDSHAKE_TIMEOUT:g} s on the port",
    ],
    ("port of machines", "wrong [join secrets](machines.md#join-secrets) of one address"): [
        f"{join_secrets.MOST_WRONG} in {join_secrets.WRONG_PERIOD:g} s",
    ],
    ("port of machines", "file of join secrets"): [
        size(join_secrets.MAX_FILE),
        f"{join_secrets.MOST_SECRETS} secrets of {join_secrets.SHORTEST} to {join_secrets.LONGEST} characters",
    ],
    ("port of machines", "clients that join with a ticket"): [
        f"{machines.MAX_JOINING} at once",
        size(joining.MAX_JOIN),
        f"{joining.PATIENCE:g} s",
    ],
    (
        "links of containers to an endpoint, and of endpoints to the master",
        "connections whose peer has not said who it is; time",
    ): [f"{handshakes.MOST} each", f"{link_listener.HELLO_TIMEOUT:g} s", f"{server.REGISTER_TIMEOUT:g} s"],
}
IN_WORDS = {
    ("connections", "number of one address (IPv6: of one /64)"),
    ("HTTP head", "Host"),
    ("HTTP head", "version"),
}
"""Rows whose limit is no number."""

LISTED = {tuple(cells[:2]): cells[2] for cells in table(LIMITS, "input", "what is limited", "limit", "beyond it")}


def test_the_table_has_the_limits_of_this_test() -> None:
    assert set(LISTED) == set(ROWS) | IN_WORDS


@pytest.mark.parametrize("row", ROWS, ids=": ".join)
def test_a_limit_is_that_of_the_code(row: tuple[str, str]) -> None:
    for value in ROWS[row]:
        assert str(value) in LISTED[row]


def test_options_and_other_pages_are_linked() -> None:
    for option in ("--max-connections", "--max-connections-per-address"):
        assert f"`{option}`" in text_of(LIMITS) or f" {option}`" in text_of(LIMITS)
    for page in ("docs/rest.md", "docs/protocol.md", "docs/security.md", "SECURITY.md", "README.md"):
        assert "limits.md" in text_of(page), page
