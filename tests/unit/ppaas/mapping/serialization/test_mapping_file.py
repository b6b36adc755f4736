import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidGraph, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.refinement import refine
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.mapping import Mapping, pack_laser
from ppaas.mapping.serialization.mapping_file import MAGIC, is_mapping, pack_mapping, unpack_mapping
from ppaas.mapping.serialization.quantised_scans import pack_scans, unpack_scans
from ppaas.mapping.serialization.rebuilding import BEAM_MEMORY, FRAME_MEMORY, ROW_MEMORY, Rebuilding
from ppaas.mapping.serialization.records import Record, RecordKind, pack_record, unpack_records
from ppaas.mapping.serialization.rows import divided_edges, frame_rows, pack_edges, pack_frames, pack_waiting
from tests.support.world.mappings import room_mapping

START = 20
"""Size of the start of a file [bytes]."""


@pytest.fixture(scope="module")
def mapping():
    return room_mapping(300, closures=20)


@pytest.fixture(scope="module")
def data(mapping):
    return b"".join(pack_mapping(mapping))


def test_a_mapping_is_the_same_after_packing(mapping, data):
    read = unpack_mapping(data)
    assert read.laser_frame == "laser" and read.frames.geometry == mapping.frames.geometry and not read.waiting
    np.testing.assert_array_equal(read.frames.poses, mapping.frames.poses)
    np.testing.assert_array_equal(read.frames.scans, mapping.frames.scans)
    np.testing.assert_array_equal(read.frames.valid, mapping.frames.valid)
    np.testing.assert_allclose(read.frames.information, mapping.frames.information, rtol=1e-6)
    np.testing.assert_allclose(read.frames.points, mapping.frames.points, atol=2.5e-4)
    np.testing.assert_allclose(read.frames.normals, mapping.frames.normals, atol=8e-4)
    np.testing.assert_array_equal(read.graph.poses, mapping.graph.poses)
    assert read.graph.edge_count == mapping.graph.edge_count == 319
    for name in ("first", "second", "measurements", "kinds"):
        np.testing.assert_array_equal(getattr(read.graph.edges, name), getattr(mapping.graph.edges, name))
    np.testing.assert_allclose(read.graph.edges.information, mapping.graph.edges.information, rtol=1e-5, atol=1.0)


def test_a_mapping_that_was_read_is_packed_to_the_same_bytes(data):
    assert b"".join(pack_mapping(unpack_mapping(data))) == data


def test_a_beam_takes_few_bytes(mapping, data):
    assert len(data) < 3.2 * len(mapping.frames) * mapping.frames.geometry.beams + 200 * len(mapping.frames)


def test_rounding_moves_refined_poses_by_less_than_a_tenth_of_a_millimetre():
    mapping = room_mapping(60)
    read = unpack_mapping(b"".join(pack_mapping(mapping)))
    before, after = (refine(each.frames, each.graph.poses, each.graph.edges).poses for each in (mapping, read))
    assert np.abs(after[:, :2] - before[:, :2]).mean() < 1e-4
    assert np.abs(after[:, 2] - before[:, 2]).mean() < 1e-4


def test_a_laser_keeps_its_mount_and_times():
    laser = LaserGeometry(1.5, -0.05, 60, Pose2D(0.1, -0.2, 0.3), 1e-4, 0.0)
    read = unpack_mapping(b"".join(pack_mapping(room_mapping(2, laser))))
    assert read.frames.geometry == laser


def test_chains_and_edges_of_any_kind_stay():
    mapping = room_mapping(5)
    graph = PoseGraph()
    for pose in mapping.graph.poses:
        graph.add_node(pose)
    kinds = EdgeKind.ODOMETRY, EdgeKind.CLOSURE
    for first, second, kind in ((0, 1, 0), (0, 2, 1), (2, 3, 1), (3, 4, 0), (3, 4, 0), (4, 1, 0)):
        graph.add_edge(first, second, (0.1, 0.2, 0.3), np.eye(3), kinds[kind])
    read = unpack_mapping(b"".join(pack_mapping(Mapping(mapping.frames, graph)))).graph.edges
    rows = sorted(zip(read.first.tolist(), read.second.tolist(), read.kinds.tolist(), strict=True))
    assert rows == [(0, 1, 0), (0, 2, 1), (2, 3, 1), (3, 4, 0), (3, 4, 0), (4, 1, 0)]


def test_a_file_cut_off_anywhere_is_refused(data):
    for size in (0, 10, len(MAGIC), START, START + 5, 1000, len(data) // 2, len(data) - 1):
        with pytest.raises(InvalidGraph):
            unpack_mapping(data[:size])
    *_, (last, _) = unpack_records(data[START:])
    with pytest.raises(InvalidGraph, match="cut off after"):
        unpack_mapping(data[: START + last])


def test_a_damaged_byte_is_found_wherever_it_is(data):
    for at in np.random.default_rng(3).integers(0, len(data), 60).tolist():
        damaged = bytearray(data)
        damaged[at] ^= 0x10
        with pytest.raises(InvalidGraph):
            unpack_mapping(bytes(damaged))


def test_what_follows_the_end_is_refused(data):
    with pytest.raises(InvalidGraph, match="after its end"):
        unpack_mapping(data + pack_record(RecordKind.END, bytes(12)))


def test_records_that_are_missing_or_swapped_are_noticed(data):
    records = [pack_record(*record) for _, record in unpack_records(data[START:])]
    for order in ([0, 1, 3, 4], [0, 1, 2, 4], [0, 2, 1, 3, 4], [1, 2, 3, 4]):
        with pytest.raises(InvalidGraph):
            unpack_mapping(data[:START] + b"".join(records[k] for k in order))


def test_a_file_of_a_later_format_names_both_formats(data):
    with pytest.raises(InvalidGraph, match="format 2; this release reads format 1"):
        unpack_mapping(MAGIC + struct.pack("<I", 2) + data[START:])


def test_only_files_of_mappings_begin_as_one(data):
    assert is_mapping(data) and not is_mapping(b"P5\n") and not is_mapping(b"")


def test_memory_is_bounded_before_anything_is_decompressed(data):
    with pytest.raises(QuotaExceeded, match="at most 0 are allowed"):
        unpack_mapping(data, most_bytes=100_000)
    rows = struct.pack("<II", 0, 2**31) + zlib.compress(bytes(100))
    with pytest.raises(QuotaExceeded):
        unpack_mapping(_file(room_mapping(1), pack_record(RecordKind.FRAMES, rows)))


@pytest.mark.parametrize("kind", [RecordKind.EDGES, RecordKind.POSES, RecordKind.WAITING])
def test_memory_of_all_other_rows_is_bounded_too(kind):
    rebuilding = Rebuilding(most_bytes=100_000)
    laser = pack_laser(room_mapping(1).frames.geometry, "laser")
    rebuilding.add(next(unpack_records(laser))[1])
    with pytest.raises(QuotaExceeded, match="at most 0 are allowed"):
        rebuilding.add(Record(kind, struct.pack("<II", 0, 10_000) + zlib.compress(bytes(570_000))))


def test_rows_of_several_kinds_share_the_memory(mapping, data):
    exact = len(mapping.frames) * (FRAME_MEMORY + mapping.frames.geometry.beams * BEAM_MEMORY)
    with pytest.raises(QuotaExceeded):
        unpack_mapping(data, most_bytes=exact)
    assert unpack_mapping(data, most_bytes=exact + 20 * ROW_MEMORY[RecordKind.EDGES]).graph.edge_count == 319


def test_waiting_closures_are_refused_in_a_file():
    mapping = room_mapping(3)
    rows = frame_rows(mapping.frames, mapping.graph, divided_edges(mapping.graph)[0], 0, 3)
    records = pack_record(RecordKind.FRAMES, pack_frames(rows)) + pack_record(RecordKind.WAITING, pack_waiting([]))
    with pytest.raises(InvalidGraph, match="only a log may have"):
        unpack_mapping(_file(mapping, records))


def test_rows_longer_than_they_say_are_refused():
    rows = struct.pack("<II", 0, 1) + zlib.compress(bytes(10_000_000))
    with pytest.raises(InvalidGraph, match="key frames that cannot be read"):
        unpack_mapping(_file(room_mapping(1), pack_record(RecordKind.FRAMES, rows)))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda rows: rows._replace(poses=rows.poses * np.nan), "out of range"),
        (lambda rows: rows._replace(poses=rows.poses + 1e8), "out of range"),
        (lambda rows: rows._replace(numbers=rows.numbers[::-1]), "order of their scans"),
        (lambda rows: rows._replace(numbers=rows.numbers + 2**62), "order of their scans"),
        (lambda rows: rows._replace(stepped=np.ones(3, bool)), "order of their scans"),
        (lambda rows: rows._replace(stepped=np.zeros(3, bool)), "no edge connects"),
        (lambda rows: rows._replace(steps=rows.steps * np.inf), "not finite"),
        (lambda rows: rows._replace(step_information=-rows.step_information), "information of the edge"),
        (lambda rows: rows._replace(first=1), "lacks key frames 0 to 0"),
    ],
)
def test_a_file_with_lies_about_key_frames_is_refused(change, text):
    mapping = room_mapping(3)
    rows = frame_rows(mapping.frames, mapping.graph, divided_edges(mapping.graph)[0], 0, 3)
    with np.errstate(invalid="ignore"), pytest.raises(InvalidGraph, match=text):
        unpack_mapping(_file(mapping, pack_record(RecordKind.FRAMES, pack_frames(change(rows)))))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda edges: edges._replace(second=edges.second + 7), "names node 8"),
        (lambda edges: edges._replace(second=edges.first), "to itself"),
        (lambda edges: edges._replace(kinds=edges.kinds + 9), "unknown kind"),
        (lambda edges: edges._replace(information=edges.information * np.nan), "not finite"),
    ],
)
def test_a_file_with_lies_about_edges_is_refused(change, text):
    mapping = room_mapping(3)
    rows = frame_rows(mapping.frames, mapping.graph, divided_edges(mapping.graph)[0], 0, 3)
    edges = change(mapping.graph.edges.take(np.array([0])))
    records = pack_record(RecordKind.FRAMES, pack_frames(rows)) + pack_record(RecordKind.EDGES, pack_edges(edges))
    with pytest.raises(InvalidGraph, match=text):
        unpack_mapping(_file(mapping, records, edges=3))


def test_a_file_with_an_impossible_laser_is_refused():
    mapping = room_mapping(1)
    record = pack_laser(mapping.frames.geometry, "laser").replace(b"\xa5beams\xcc\xb5", b"\xa5beams\xcc\x00")
    _, (kind, payload) = next(unpack_records(pack_record(RecordKind.LASER, record[12:])))
    with pytest.raises(InvalidGraph, match="impossible laser"):
        unpack_mapping(data_of(pack_record(kind, bytes(payload)), 1, 0))


def _file(mapping, records, edges=2):
    return data_of(pack_laser(mapping.frames.geometry, "laser") + records, len(mapping.frames), edges)


def data_of(records, frames, edges):
    """Return a file of these records, with an end that fits them."""
    begun = MAGIC + struct.pack("<I", 1) + records
    return begun + pack_record(RecordKind.END, struct.pack("<III", frames, edges, zlib.crc32(begun)))


@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.integers(1, 30), st.floats(0.01, 1000.0), st.floats(0.0, 1.0))
def test_scans_of_any_size_are_rounded_to_a_part_of_their_reach(seed, count, beams, reach, share):
    scans = random_scans(seed, count, beams, reach, share)
    read = unpack_scans(*pack_scans(scans), beams)
    step = max(2.0**-11, 2.0 ** np.ceil(np.log2(reach / 32767.0)))
    np.testing.assert_array_equal(read.valid, scans.valid)
    np.testing.assert_allclose(read.points, scans.points, atol=0.5001 * step)
    np.testing.assert_allclose(read.normals, scans.normals, atol=8e-4)
    assert pack_scans(read)[1] == pack_scans(unpack_scans(*pack_scans(read), beams))[1]
    again = unpack_scans(*pack_scans(read), beams)
    for stored, given_ in zip(again, read, strict=True):
        np.testing.assert_array_equal(stored, given_)


def test_a_point_too_far_away_is_refused():
    scans = random_scans(1, 1, 3, 10.0, 1.0)
    scans.points[0, 0] = 3e8
    with pytest.raises(InvalidGraph, match="set max_laser_range"):
        pack_scans(scans)


def test_beams_of_an_unknown_state_are_refused():
    exponents, data = pack_scans(random_scans(1, 1, 3, 10.0, 1.0))
    with pytest.raises(InvalidGraph, match="out of range"):
        unpack_scans(exponents, data[:-1] + b"\7", 3)
    with pytest.raises(InvalidGraph, match="out of range"):
        unpack_scans(exponents + np.int8(50), data, 3)


def random_scans(seed, count, beams, reach, share):
    random = np.random.default_rng(seed)
    valid = random.random((count, beams)) < share
    is_open = ~valid & (random.random((count, beams)) < 0.5)  # free up to its point, without a reading
    points = random.uniform(-reach, reach, (count, beams, 2)).astype(np.float32) * (valid | is_open)[..., None]
    angles = random.uniform(-np.pi, np.pi, (count, beams))
    normals = np.stack((np.cos(angles), np.sin(angles)), axis=-1) * (valid & (angles > -1.0))[..., None]
    return ScanPoints(points, normals.astype(np.float32), valid)
