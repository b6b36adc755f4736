"""OctoMap files, good and bad.

Trees of every type that has occupancies are read: ``OcTree`` (also under the id ``1`` of old releases),
``ColorOcTree``, ``OcTreeStamped``; counting trees are refused by name.
"""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.errors import InvalidMap
from ppaas.maps.octomap import binary_octomap, parse_octomap
from ppaas.maps.octree import OcTree, octree_of
from ppaas.maps.voxels import FREE, OCCUPIED, UNKNOWN
from tests.reference.maps import octree as twin
from tests.support.world import voxels

ARRAYS = hnp.arrays(np.uint8, st.tuples(*[st.integers(1, 5)] * 3), elements=st.sampled_from([FREE, OCCUPIED, UNKNOWN]))

HEAD = b"# Octomap OcTree %bfile\n# (a comment)\n\nid %b\nsize %d\nres 0.5\ndata\n"


def file_of(data, kind, name=b"OcTree", extra=b""):
    body, nodes = twin.write(data, kind, extra)
    return HEAD % (b"binary " if kind == "bt" else b"", name, nodes) + body


def leaves_of(tree):
    return [
        (*corner, depth, occupied)
        for corner, depth, occupied in zip(
            tree.corners.tolist(), tree.depths.tolist(), tree.occupied.tolist(), strict=True
        )
    ]


def body_of(text):
    return text[text.index(b"\ndata\n") + 6 :]


@given(ARRAYS)
def test_binary_file_is_read_like_by_the_twin_and_round_trips(data):
    data[0, 0, 0] = OCCUPIED
    text = file_of(data, "bt")
    tree = parse_octomap(text)
    leaves, rest = twin.read_binary(body_of(text))
    assert (leaves_of(tree), rest) == (leaves, b"")
    assert f"\nsize {tree.nodes}\n".encode() in text
    assert body_of(binary_octomap(tree)) == body_of(text)
    assert parse_octomap(binary_octomap(tree)).resolution == 0.5


@given(
    ARRAYS,
    st.sampled_from(
        [(b"OcTree", b""), (b"ColorOcTree", b"\x01\x02\x03"), (b"OcTreeStamped", b""), (b"1", b"")],
    ),
)
def test_a_full_file_has_the_leaves_of_the_binary_one(data, kind):
    data[0, 0, 0] = OCCUPIED
    tree = parse_octomap(file_of(data, "ot", *kind))
    assert leaves_of(tree) == leaves_of(parse_octomap(file_of(data, "bt", kind[0])))
    assert leaves_of(tree) == leaves_of(octree_of(voxels.grid(data, 0.5)))


@pytest.mark.parametrize(
    ("odds", "occupied"), [(0.0, True), (-0.0, True), (1e-30, True), (-1e-30, False), (-math.inf, False)]
)
def test_node_with_non_negative_log_odds_is_occupied(odds, occupied):
    tree = parse_octomap(HEAD % (b"", b"OcTree", 1) + struct.pack("<fB", odds, 0))
    assert leaves_of(tree) == [(0, 0, 0, 0, occupied)]


def test_tree_of_one_leaf_is_refused_as_grid_and_binary_file():
    tree = parse_octomap(HEAD % (b"", b"OcTree", 1) + bytes(5))
    assert tree.nodes == 1
    with pytest.raises(InvalidMap, match="coarser"):
        tree.voxels()
    with pytest.raises(InvalidMap, match="one leaf"):
        binary_octomap(tree)


def test_an_empty_tree_is_read_and_written():
    tree = parse_octomap(HEAD % (b"binary ", b"OcTree", 0))
    assert tree.nodes == 0
    assert leaves_of(parse_octomap(binary_octomap(tree))) == []


DEEP = b"\x03\x00" * 17
GOOD = file_of(np.array([[[OCCUPIED, FREE]]], np.uint8), "bt")
FULL = file_of(np.array([[[OCCUPIED, FREE]]], np.uint8), "ot")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (b"", "must begin with the line"),
        (b"\x89PNG", "must begin with the line"),
        (GOOD.replace(b"binary", b"binry"), "must begin with the line"),
        (GOOD.split(b"data")[0], "line 'data' is missing"),
        (b"# Octomap OcTree file\n" + b"# x\n" * 1000, "line 'data' is missing"),
        (GOOD.replace(b"id OcTree", b"id CountingOcTree"), "'CountingOcTree'; supported: OcTree, ColorOcTree"),
        (GOOD.replace(b"size", b"sise"), "whole number of nodes, not ''"),
        (GOOD.replace(b"size ", b"size -"), "whole number"),
        (GOOD.replace(b"size ", b"size 9999999999999999"), "whole number"),
        (GOOD.replace(b"res 0.5", b"res nan"), "'res' in the octree's header must be"),
        (GOOD.replace(b"res 0.5", b"res 0"), "'res' in the octree's header must be"),
        (GOOD.replace(b"res 0.5", b"res"), "'res' in the octree's header must be"),
        (GOOD[:-1], "truncated"),
        (GOOD + b"\0", "its header states"),
        (GOOD.replace(b"size ", b"size 1"), "its header states"),
        (HEAD % (b"binary ", b"OcTree", 2) + b"\x55\x55", "more nodes"),
        (HEAD % (b"binary ", b"OcTree", 99) + DEEP, "deeper than 16"),
        (HEAD % (b"binary ", b"OcTree", 99) + b"\0\0", "no children"),
        (HEAD % (b"binary ", b"OcTree", 99) + b"\x03\0\0\0", "no children"),
        (HEAD % (b"binary ", b"OcTree", 99), "truncated"),
        (FULL[:-1], "truncated"),
        (FULL + b"\0", "its header states"),
        (HEAD % (b"", b"OcTree", 99) + b"\0\0\0\0\1" * 17, "deeper than 16"),
        (HEAD % (b"", b"OcTree", 1) + struct.pack("<fB", math.nan, 0), "not a number"),
    ],
)
def test_an_invalid_file_is_refused_with_the_reason(text, reason):
    with pytest.raises(InvalidMap, match=reason):
        parse_octomap(text)


@given(st.binary(max_size=60), st.booleans(), st.integers(1, 99))
def test_corrupt_body_is_not_read_beyond_its_end(body, full, size):
    text = HEAD % (b"" if full else b"binary ", b"OcTree", size) + body
    try:
        tree = parse_octomap(text)
    except InvalidMap:
        return
    assert isinstance(tree, OcTree)
    assert tree.nodes == size


def test_scanned_building_has_the_nodes_of_its_header(data):
    text = (data / "octomap" / "geb079.bt").read_bytes()
    tree = parse_octomap(text)
    assert tree.nodes == 532_566
    assert tree.resolution == 0.08
    assert body_of(binary_octomap(tree)) == body_of(text)
    grid = tree.voxels()
    np.testing.assert_allclose(grid.info.origin, (-8.0, -7.52, -0.32), atol=1e-9)
    assert grid.info.shape == (39, 187, 487)
    assert body_of(binary_octomap(octree_of(grid))) == body_of(text)
    assert tree.voxels(15).info.shape == (20, 94, 244)
