"""Every parser that sees strangers' bytes reads them or raises a `PPaaSError`, with work and memory in proportion.

The kind: a parser that a few bytes keep busy, or that fails in a way nobody expects. Its members are the parsers of
this table; docs/limits.md lists what is limited in each. A new parser of strangers' bytes is added to both. The parser
of HTTP heads is a protocol and has its own test (tests/unit/endpoints/http/test_http_protocol_limits.py), as have
frames of rosbridge on a whole session (tests/unit/endpoints/rosbridge/test_session_any_frame.py).
"""

import contextlib
import io
import json
import struct
import zlib
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

import cbor2
import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image
from starlette.datastructures import QueryParams
from starlette.requests import Request

from endpoints.rest.maps.multipart import FormReader
from endpoints.rest.paging import Paging
from endpoints.rest.strict_json import parse
from endpoints.rosbridge import parse_connect_request
from engine.remote.joining import read_ticket
from ppaas.errors import PPaaSError
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.mapping.serialization.records import RecordKind, pack_record
from ppaas.maps.formats.image import image_size, open_image
from ppaas.maps.formats.map_yaml import Rules, parse_yaml, with_rules
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.maps.octomap import BINARY, parse_octomap
from ppaas.messages import decode
from ppaas.messages.base.spelling import read_json
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.people_msgs import People
from ppaas.messages.sensor_msgs import Image as RosImage
from ppaas.messages.sensor_msgs import LaserScan, PointCloud2
from ppaas.perception.compressed_depth import FORMATS, decompress
from ppaas.robot_model.describe import describe
from ppaas.wire.binary.cbor import cbor_to_json
from ppaas.wire.binary.packing import Packer, operation_of
from ppaas.wire.rapyuta.message_codec import Converter, Forwarder
from ppaas.wire.rapyuta.part_assembler import PartAssembler
from ppaas.wire.rapyuta.requests import read_request
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.rmw_zenoh import parse_token
from ppaas.wire.ros.ros1_master import pack_call, pack_response, unpack_call, unpack_response
from ppaas.wire.ros.serialization import serialize
from ppaas.wire.ros.tcpros import FrameReader, framed, pack_header, unpack_header
from ppaas.wire.rosbridge import RosbridgeSession
from ppaas.zones.reading import geojson_of, zones_of
from ppaas.zones.shapes import Polygon
from ppaas.zones.zone import KeepOut, Zone, ZoneSet
from tests.support.fuzzing import EXAMPLES
from tests.support.hostile_bytes import mutations, operations, peak_memory
from tests.support.world.mappings import room_mapping
from tests.support.world.png import chunk, header, png
from tests.support.world.urdf import example

REPETITIONS = 1200
"""Number of repetitions in a hostile file: their square is far above the limits below."""

OPERATIONS, PER_BYTE = 3000, 20
"""Number of calls that a parser may make for any file, and for a byte of it."""

SPARE = 4 << 20
"""Memory that a parser may take for any file [bytes]: imports, buffers of libraries."""

BYTES_PER_BYTE = 100
"""Memory that a parser may take for a byte of a file [bytes]."""

Family = Callable[[int], bytes]


def _written(image: Image.Image, name: str) -> bytes:
    file = io.BytesIO()
    image.save(file, name)
    return file.getvalue()


def _form(*parts: tuple[str, bytes]) -> bytes:
    return b"".join(b"--b\r\n%b\r\n\r\n%b\r\n" % (head.encode(), body) for head, body in parts) + b"--b--\r\n"


def _read_form(data: bytes) -> None:
    with FormReader("multipart/form-data; boundary=b", lambda _: nullcontext(io.BytesIO()), 20) as reader:
        reader.write(data)
        reader.end()


def _read_cursor(data: bytes) -> None:
    request = Request({"type": "http", "query_string": b"cursor=" + data.hex().encode()})
    Paging(request, cursor=data.decode("latin-1")).key(str, "")


def _read_query(data: bytes) -> None:
    parse_connect_request(QueryParams(data.decode("latin-1")))


def _take_frames(data: bytes) -> None:
    reader = FrameReader()
    reader.feed(data)
    while reader.take(1 << 16) is not None:
        pass


def _read_rows(data: bytes) -> None:
    opened = open_image(data)
    if opened.shape[0] * opened.shape[1] <= 1 << 16:
        opened.check()
        opened.rows(0, opened.shape[0])


def _receive(data: bytes) -> None:
    session = RosbridgeSession()
    session.receive(data)
    session.receive_binary(data)


def _receive_fragments(data: bytes) -> None:
    session = RosbridgeSession()
    for line in data.split(b"\n"):
        session.receive(line)


def _publish(data: bytes) -> None:
    """Send a message of a client to subscribers of all compressions and types: each gets a frame."""
    session = RosbridgeSession(packer=Packer(compact=True, serialize=serialize))
    session.packer.type_of = {"cmd_vel": "sensor_msgs/LaserScan"}.get
    for number, asked in enumerate(SUBSCRIPTIONS):
        topic = "/" * (number % 2) + "robot/" * (number // 2) + "cmd_vel"
        session.receive(json.dumps({"op": "subscribe", "topic": topic, "id": str(number)} | asked))
    frames = [frame for topic in session.subscribed() for frame in session.publish(topic, data, 0.0)]
    assert len(frames) == len(SUBSCRIPTIONS)


def _convert(data: bytes) -> None:
    converters = [Converter(kind) for kind in (None, LaserScan, PoseStamped, RosImage, PointCloud2, People)]
    for converter in converters:
        with contextlib.suppress(PPaaSError):
            converter.read(read_json(data, 1 << 16))
        with contextlib.suppress(msgspec.DecodeError, UnicodeDecodeError):  # the cloud has checked that it is JSON
            converter.write(data)


def _receive_of_2013(data: bytes) -> None:
    parts = PartAssembler()
    with contextlib.suppress(PPaaSError):
        parts.take_binary(data)
    message = parts.take_text(data.decode("latin-1"))
    if message is not None:
        read_request(message)


@dataclass(frozen=True)
class Parser:
    """Parser of strangers' bytes.

    Parameters
    ----------
    read : callable
        The parser.
    seeds : sequence of bytes
        Good files.
    families : sequence of callables
        Each returns a hostile file with this number of repetitions.
    """

    read: Callable[[bytes], object]
    seeds: Sequence[bytes]
    families: Sequence[Family] = ()


POSE = json.dumps({"header": {"frame_id": "map"}, "pose": {"position": {"x": 1.5}, "orientation": {"w": 1.0}}}).encode()
SCAN = json.dumps({"angle_min": -1.0, "angle_max": 1.0, "angle_increment": 1.0, "ranges": [1.0, None, 2.0]}).encode()
SUBSCRIPTIONS: list[dict[str, Any]] = [
    {}, {"compression": "png"}, {"compression": "cbor"}, {"compression": "cbor-raw"},
    {"compression": "cbor-raw", "type": "sensor_msgs/msg/LaserScan"},
    {"compression": "cbor-raw", "type": "geometry_msgs/msg/Twist"},
]  # fmt: skip
CDR = ("tf2_msgs/TFMessage", "sensor_msgs/LaserScan", "people_msgs/People", "action_msgs/srv/CancelGoal_Response")
YAML = (
    b"image: m.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
)
OCTOMAP = BINARY + b"\nid OcTree\nsize 3\nres 0.1\ndata\n\x03\x00\x09\x00"
GREY = Image.new("L", (5, 4), 200)
FILE = 'Content-Disposition: form-data; name="image"; filename="m.pgm"'
FIELD = 'Content-Disposition: form-data; name="id"'

POSEGRAPH = b"".join(pack_mapping(room_mapping(3)))

ZONES = geojson_of(ZoneSet([Zone(Polygon([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]), KeepOut(name="stairs"))])).replace(
    b".0", b""
)

PARSERS = {
    "JSON body": Parser(
        parse,
        [b'{"start": [0, 1.5], "goal": [2, 3], "labels": {"a": "b"}}', b'{"user": "ann", "password": "pass"}'],
        [
            lambda n: b"{" + b",".join(b'"%x":1' % i for i in range(n)) + b',"0":2}',
            lambda n: b"[" + b"[]," * n + b"1]",
            lambda n: b"[" * n,
            lambda n: b'"' + b"\\ud800" * n + b'"',
            lambda n: b"9" * n,
        ],
    ),
    "form": Parser(
        _read_form,
        [_form((FIELD, b"house"), (FILE, b"P5 1 1 255 \0"))],
        [
            lambda n: _form((FIELD + "x" * n, b"")),
            lambda n: _form(*[("X: y", b"")] * n),
            lambda n: _form((FIELD + ";a=b" * n, b"")),
            lambda n: _form((FILE, b"\r\n--" * n)),
        ],
    ),
    "cursor": Parser(_read_cursor, [b"ImhvdXNlIg", b"MTI"], [lambda n: b"A" * n]),
    "query of a WebSocket": Parser(
        _read_query,
        [b"robot=tb1&role=operator&session=s&resume=3.4&hold=0"],
        [lambda n: b"&robot=a" * n, lambda n: b"robot=" + b"%41" * n],
    ),
    "frame of rosbridge": Parser(
        _receive,
        [
            b'{"op": "publish", "topic": "/goal", "msg": {"a": [1]}}',
            b'{"op": "subscribe", "topic": "/map", "throttle_rate": 5}',
            b'{"op": "call_service", "service": "/s", "args": [1, 2], "id": "a"}',
            b'{"op": "fragment", "id": "a", "data": "{}", "num": 0, "total": 2}',
            b'{"op": "set_level", "level": "error"}',
        ],
        [lambda n: b"[" * n, lambda n: b'{"op":"publish","topic":"/a","msg":' + b'{"a":' * n, lambda n: b"{" * n],
    ),
    "CBOR of rosbridge": Parser(
        cbor_to_json,
        [
            cbor2.dumps({"op": "publish", "topic": "/scan", "msg": {"ranges": cbor2.CBORTag(85, bytes(8))}}),
            cbor2.dumps({"op": "call_service", "service": "/s", "args": [1, None, 2.5, b"ab"], "id": "a"}),
        ],
        [
            lambda n: b"\xa1\x61a" + b"\x81" * n,
            lambda n: b"\xa1\x61a\x9f" + b"\x80" * n + b"\xff",
            lambda n: b"\xbf" + b"\x61a\x01" * n + b"\xff",
            lambda n: b"\xa1\x61a" + b"\xc6" * n,
            lambda n: b"\xa1\x61a\xc2\x59" + n.to_bytes(2) + b"\xff" * n,
            lambda n: b"\xa1\x61a\xd8\x48\x59" + n.to_bytes(2) + b"\xff" * n,
            lambda n: b"\xa1\x61a\x9b\x00\x00\x00\x00\x7f\xff\xff\xff" + b"\x00" * n,
            lambda n: b"\xa1\x61a\xd8\x1c\x81" + b"\xd8\x1d\x00" * n,
        ],
    ),
    "compact frame": Parser(
        operation_of,
        [
            struct.pack("<BBHIffHH3H", 1, 0, 3, 5, -1.0, 1.0, 100, 9000, 0, 1500, 65535),
            struct.pack("<BBHI6f", 2, 0, 6, 7, 1.0, 2.0, 0.5, 0.2, 0.0, -0.1),
            struct.pack("<BBHI3f", 3, 0, 3, 0, 0.2, 0.0, -0.1),
        ],
        [
            lambda n: struct.pack("<BBHIffHH", 1, 0, n, 0, 0.0, 0.1, 0, 1) + bytes(2 * n),
            lambda n: struct.pack("<BBHIffHH", 1, 255, 1, 0, 0.0, 0.1, 0, 1) + bytes(n),
        ],
    ),
    "pose": Parser(lambda data: decode(PoseStamped, data), [POSE], [lambda n: b'{"pose":' * n]),
    "scan": Parser(
        lambda data: decode(LaserScan, data),
        [SCAN],
        [lambda n: b'{"ranges": [' + b"[]," * n + b"1]}", lambda n: b'{"ranges": [' + b"1," * n + b"1]}"],
    ),
    "frame of Rapyuta": Parser(
        _receive_of_2013,
        [
            b'{"type": "DM", "data": {"iTag": "a", "type": "b", "msgID": "c", "msg": {"x*": "%b"}}}' % (b"0a" * 16),
            b'{"type": "CN", "data": {"addNodes": [{"containerTag": "a", "nodeTag": "b", "pkg": "c", "exe": "d"}]}}',
            b"0a" * 16 + b"bytes",
        ],
        [
            lambda n: b"[" * n,
            lambda n: b'{"a":' * n,
            lambda n: b'{"type":"CX","data":{"connect":[' + b"{}," * n + b"{}]}}",
            lambda n: b'{"a*":[' + b",".join(b'"%032x"' % i for i in range(n)) + b"]}",
            lambda n: b"{" + b",".join(b'"%x*":"%032x"' % (i, i) for i in range(n)) + b"}",
        ],
    ),
    "fragments of rosbridge": Parser(
        _receive_fragments,
        [
            b"\n".join(
                json.dumps({"op": "fragment", "id": "a", "data": text, "num": number, "total": 3}).encode()
                for number, text in order
            )
            for order in (
                [(0, '{"op": "publish", '), (2, ', "msg": {"a": [1]}}'), (1, '"topic": "/goal"')],
                [(0, '{"op": "set_'), (0, "again"), (1, 'level", "level"'), (2, ': "info"}')],
            )
        ],
        [lambda n: b'{"op": "fragment", "id": "a", "data": "{", "num": 0, "total": 2}\n' * n],
    ),
    "message for subscribers": Parser(
        _publish,
        [SCAN, b'{"linear": {"x": 0.2}, "angular": {"z": 0.1}}', '[{"ä": null}]'.encode()],
        [
            lambda n: b"[" * n,
            lambda n: b'{"ranges": [' + b"[]," * n + b"1]}",
            lambda n: b'{"ranges": [' + b"1," * n + b"1]}",
        ],
    ),
    "JSON of a converter": Parser(
        _convert,
        [
            SCAN,
            POSE,
            b'{"header": {"stamp": "2013-09-01T00:00:00.1"}, "data": "AAEC", "width": 1, "time_increment": 1}',
            b'{"fields": [{"name": "x", "offset": 0}], "data": [1, 2]}',
            b'{"people": [{"tags": ["a"], "position": {"x": 1}}], "header": {"stamp": {"secs": 1, "nsecs": 2}}}',
        ],
        [lambda n: b'{"data": "' + b"A" * n + b'"}', lambda n: b'{"people": [' + b"{}," * n + b"{}]}"],
    ),
    "message of a converter": Parser(
        lambda data: Converter(LaserScan).read({"header": {"stamp": data.decode("latin-1")}, "ranges": data}),
        [b"2013-09-01T00:00:00.123456", bytes(8)],
        [lambda n: b"2" * 4 * n, lambda n: b"2013-09-01T" + b"0" * n],
    ),
    "message of a forwarder": Parser(
        Forwarder("sensor_msgs/LaserScan").read,
        [Forwarder("sensor_msgs/LaserScan").write(b"{}"), zlib.compress(bytes(60))],
        [lambda n: b"x\x9c" * n, lambda n: zlib.compress(b"\xff" * n), lambda n: zlib.compress(bytes(40 * n))],
    ),
    "CDR of ROS 2": Parser(
        lambda data: [ros_types("jazzy").decode_json(name, data) for name in CDR],
        [ros_types("jazzy").encode(name, {}) for name in CDR],
        [
            lambda n: b"\0\1\0\0" + bytes(16) + b"\xff\xff\xff\xff" + bytes(n),
            lambda n: b"\0\1\0\0" + bytes(12) + b"\1\0\0\0" + b"\0\xff\xff\xff" + b"\1\0\0\0" * n,
        ],
    ),
    "token of rmw_zenoh": Parser(
        lambda data: parse_token(data.decode("latin-1")),
        [b"@ros2_lv/2/8b20/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/RIHS01_0/::,7:,:,:,,"],
        [lambda n: b"@ros2_lv" + b"/" * n, lambda n: b"a" * n],
    ),
    "serialization of ROS 1": Parser(
        lambda data: ros_types("noetic").decode_json("nav_msgs/Path", data),
        [ros_types("noetic").encode("nav_msgs/Path", {"poses": [{"header": {"frame_id": "map"}}] * 2})],
        [lambda n: bytes(16) + b"\xff\xff\xff\xff" + bytes(n)],
    ),
    "connection header of ROS 1": Parser(
        unpack_header,
        [pack_header({"callerid": "/talker", "topic": "/chatter", "md5sum": "*", "type": "std_msgs/String"})],
        [lambda n: framed(b"a=") * n, lambda n: framed(b"%b=" % (b"a" * n)), lambda n: b"\1\0\0\0=" * n],
    ),
    "frames of TCPROS": Parser(
        _take_frames,
        [framed(b"hello") + framed(b"")],
        [lambda n: framed(b"") * n, lambda n: b"\xff\xff\0\0" + bytes(n)],
    ),
    "call of XML-RPC": Parser(
        unpack_call,
        [pack_call("publisherUpdate", "/master", "/odom", ["http://robot:1/"])],
        [
            lambda n: b"<a>" * n,
            lambda n: b"<methodCall>" + b"<value><array><data>" * n,
            lambda n: (
                b"<methodCall><params><param><value><int>" + b"9" * n + b"</int></value></param></params></methodCall>"
            ),
        ],
    ),
    "response of XML-RPC": Parser(
        unpack_response,
        [pack_response(1, "state", [[["/odom", ["/base"]]], [], []])],
        [lambda n: b"<methodResponse>" + b"<value>" * n],
    ),
    "pose graph": Parser(
        unpack_mapping,
        [POSEGRAPH],
        [
            lambda n: POSEGRAPH + pack_record(RecordKind.END, b"") * n,
            lambda n: POSEGRAPH[:20] + pack_record(RecordKind.POSES, b"") * n,
            lambda n: POSEGRAPH[:20] + pack_record(RecordKind.FRAMES, bytes(n)),
            lambda n: POSEGRAPH[:-20] + pack_record(RecordKind.FRAMES, b"\0\0\0\0\xff\xff\xff\x7f" + bytes(n)),
        ],
    ),
    "zones of a map": Parser(
        zones_of,
        [ZONES],
        [
            lambda n: ZONES.replace(b"[1,0]", b",".join([b"[1,0]"] * n)),
            lambda n: ZONES.replace(b"[1,0]", b"[" + b",".join([b"1"] * n) + b"]"),
            lambda n: ZONES.replace(b'"stairs"', b"[" * n + b"]" * n),
            lambda n: ZONES.replace(b"stairs", b"x" * n),
            lambda n: ZONES.replace(b'"kind"', b"".join(b'"_%d":0,' % i for i in range(n)) + b'"kind"'),
            lambda n: b"[" * n,
        ],
    ),
    "YAML of a map": Parser(
        parse_yaml,
        [YAML, b"{image: a.png, resolution: 1, origin: [0, 0, 0]}", YAML.replace(b"\n", b"\r\n") + b"---\na: b\n"],
        [
            lambda n: YAML + b"".join(b"k%d: v\n" % i for i in range(n)),
            lambda n: (
                YAML
                + b"a0: &a0 {k: v}\n"
                + b"".join(b"a%d: &a%d\n  <<:\n  - *a%d\n  - *a%d\n" % (i, i, i - 1, i - 1) for i in range(1, n))
            ),
            lambda n: b"- " * n,
            lambda n: b"? " * n,
            lambda n: b"[" * n,
            lambda n: b"a: \t" * n,
            lambda n: b'"' + b"\\x41" * n,
            lambda n: b"---\n" * n,
        ],
    ),
    "YAML with rules": Parser(lambda data: with_rules(data, Rules.NAV2), [YAML, YAML + b"rules: map_server\n"]),
    "PGM, PPM, PBM": Parser(
        _read_rows,
        [
            b"P5\n2 1\n255\n\0\xff",
            b"P2 2 1 255 0 255",
            b"P6 1 1 255 abc",
            b"P3 1 1 1 0 1 0",
            b"P4 9 1 \x80\0",
            b"P1 3 1 101",
        ],
        [
            lambda n: b"P5" + b" " * n,
            lambda n: b"P5 1" + b"#\n" * n,
            lambda n: b"P2 1 1 1 " + b"#\n" * n + b"1",
            lambda n: b"P1 99 99 " + b" " * n + b"1",
            lambda n: b"P2 40000 20000 255 " + b"1 " * n,
        ],
    ),
    "PNG": Parser(
        _read_rows,
        [png([b"\x00\xff"], 2), _written(GREY.convert("RGBA"), "PNG"), _written(GREY.convert("P"), "PNG")],
        [
            lambda n: header(4, 4) + chunk(b"tEXt", b"a\0b") * n,
            lambda n: header(4, 4) + chunk(b"iCCP", b"a\0\0" + zlib.compress(bytes(1000))) * n,
            lambda n: header(4, 4) + chunk(b"zTXt", b"a\0\0" + zlib.compress(bytes(1000))) * n,
            lambda n: header(4, 4) + chunk(b"IDAT") * n,
            lambda n: header(20_000, 20_000) + chunk(b"IDAT", zlib.compress(bytes(n))),
        ],
    ),
    "BMP, JPEG, TIFF": Parser(
        _read_rows,
        [_written(GREY, "BMP"), _written(GREY, "JPEG"), _written(GREY, "TIFF")],
        [
            lambda n: b"\xff\xd8\xff\xe0\0\x10JFIF\0\1\1\0\0\1\0\1\0\0" + b"\xff\xfe\0\2" * n,
            lambda n: b"\xff\xd8" + b"\xff\xda" * n,
        ],
    ),
    "size of an image": Parser(image_size, [png([b"\x00\xff"], 2), b"P5 2 1 255 ab", _written(GREY, "BMP")]),
    "octomap": Parser(
        parse_octomap,
        [OCTOMAP],
        [
            lambda n: BINARY + b"\n" * n,
            lambda n: BINARY + b"\nid OcTree\nsize %d\nres 1\ndata\n" % 10**15 + b"\xff\xff" * n,
            lambda n: BINARY + b"\nid OcTree\nsize 9\nres 1\ndata\n" + b"\x03\0" * n,
        ],
    ),
    "map of MovingAI": Parser(
        parse_map,
        [b"type octile\nheight 2\nwidth 3\nmap\n...\n.@T\n"],
        [lambda n: b"type octile\nheight 999999999\nwidth 999999999\nmap\n" + b".\n" * n],
    ),
    "scenario of MovingAI": Parser(
        parse_scenario, [b"version 1\n0\ta.map\t3\t2\t0\t0\t2\t1\t2.5\n"], [lambda n: b"version 1\n" + b"0 " * n]
    ),
    "URDF": Parser(
        describe.__wrapped__,
        [example("turtlebot3_burger"), b'<robot name="r"><link name="a"/></robot>'],
        [
            lambda n: b"<robot>" + b"<a>" * n,
            lambda n: (
                b'<robot><link name="l0"/>'
                + b"".join(
                    b'<link name="l%d"/><joint name="j%d" type="fixed"><parent link="l%d"/><child link="l%d"/></joint>'
                    % (i, i, i - 1, i)
                    for i in range(1, n)
                )
                + b"</robot>"
            ),
            lambda n: (
                b"<!DOCTYPE r ["
                + b"".join(b'<!ENTITY e%d "%b">' % (i, b"&e%d;" % (i - 1) * 10) for i in range(1, n))
                + b"]><robot>&e9;</robot>"
            ),
            lambda n: b"<robot " + b" ".join(b'a%d="1"' % i for i in range(n)) + b"/>",
        ],
    ),
    "depth image": Parser(
        lambda data: decompress(FORMATS["uint16"], data),
        [bytes(12) + png([b"\0\1\0\2"], 2, 16)],
        [lambda n: bytes(12) + header(4, 4, 16) + chunk(b"iCCP", b"a\0\0" + zlib.compress(bytes(1000))) * n],
    ),
    "ticket": Parser(lambda data: read_ticket(data.decode("latin-1")), [b"ppaas-ticket"], [lambda n: b"A" * n]),
}


@pytest.mark.parametrize("name", PARSERS)
@settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_hostile_bytes_are_read_or_refused(name: str, data: st.DataObject) -> None:
    parser = PARSERS[name]
    with contextlib.suppress(PPaaSError):
        parser.read(data.draw(mutations(parser.seeds)))


FAMILIES = [
    pytest.param(parser.read, family, id=f"{name}-{number}")
    for name, parser in PARSERS.items()
    for number, family in enumerate(parser.families)
]


@pytest.mark.parametrize(("read", "family"), FAMILIES)
def test_work_and_memory_are_in_proportion_to_the_bytes(read: Callable[[bytes], object], family: Family) -> None:
    def work() -> None:
        with contextlib.suppress(PPaaSError):
            read(file)

    file = family(1)
    work()  # imports and caches
    file = family(REPETITIONS)
    assert operations(work) <= OPERATIONS + PER_BYTE * len(file)
    assert peak_memory(work) <= SPARE + BYTES_PER_BYTE * len(file)
