"""The gates of a fringe corner are the labelled corners through which its shortest paths leave the fringe."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.planners.hub_labels.building.contraction import Contraction
from ppaas.planners.hub_labels.building.gates import find_fringe
from ppaas.planners.hub_labels.building.graph import build_corner_graph, build_corner_map
from ppaas.planners.hub_labels.building.importance import edges_of
from ppaas.planners.hub_labels.building.labels import label
from ppaas.planners.hub_labels.kernels.layout import BOTTOM, HUB_BITS, LEFTMOST, RIGHTMOST, TOP
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT, moves_in
from ppaas.planners.watch import proceed
from tests.reference.planners import hub_labels as twin
from tests.support.budget import examples
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import in_whole_numbers, maps


def fringe_of(free, entries: int, threads: int = 1):
    """Return the labels of a map, its fringe, the cells of its corners by rank, and its edges."""
    corner_map = build_corner_map(free, threads=1, check=proceed)
    contraction = Contraction(build_corner_graph(corner_map, threads=1, check=proceed))
    contracted = contraction.run(check=proceed)
    while (pool := label(contracted, None, most_entries=entries, longest=2**29, threads=1, check=proceed)) is None:
        contracted = contraction.run(contraction.core * 3 // 4, check=proceed)
    nodes = np.argsort(pool.ranks).astype(np.int32)
    edges, positions = edges_of(contracted, nodes, pool.ranks), corner_map.positions[nodes]
    fringe = find_fringe(pool, edges, contracted.levels[nodes], positions, threads=threads, check=proceed)
    return pool, fringe, [(int(row) - 1, int(column) - 1) for row, column in positions], edges


def gates_of(fringe, rank: int) -> dict[int, float]:
    """Return the distance of each gate of a corner [cells]."""
    own = slice(fringe.begins[rank], fringe.ends[rank])
    hubs = fringe.gates[own] & ((1 << HUB_BITS) - 1)
    return dict(zip(hubs.tolist(), (fringe.lengths[own] / STRAIGHT).tolist(), strict=True))


@given(free=maps(14), entries=st.sampled_from([5, 20, 60]))
@settings(max_examples=examples(15))
def test_gates_are_on_shortest_paths_and_complete(free, entries):
    pool, fringe, cells, _ = fringe_of(free, entries)
    far = [twin.lengths_from(free, cell) for cell in cells]
    for rank in range(pool.labelled, len(cells)):
        gates = gates_of(fringe, rank)
        for hub, length in gates.items():
            assert length == pytest.approx(far[rank][cells[hub]])
            assert not any(
                gate != hub and far[rank][cells[gate]] + far[gate][cells[hub]] == pytest.approx(length)
                for gate in gates
            )
        for hub in range(pool.labelled):
            over = min((length + far[gate][cells[hub]] for gate, length in gates.items()), default=math.inf)
            assert over == pytest.approx(far[rank][cells[hub]])


def climbed_from(rank: int, fringe, edges) -> dict[int, float]:
    """Return the distance of each corner that a corner reaches over local edges [cells]."""
    reached = {rank: 0.0}
    for corner in range(rank, -1, -1):  # edges lead to more important corners
        for edge in range(edges.starts[corner], edges.starts[corner + 1]) if corner in reached else ():
            if fringe.local[edges.ids[edge]]:
                to, length = int(edges.to[edge]), reached[corner] + edges.lengths[edge] / STRAIGHT
                reached[to] = min(reached.get(to, math.inf), length)
    return reached


@given(free=maps(14), entries=st.sampled_from([5, 20, 60]))
@settings(max_examples=examples(15))
def test_box_of_a_corner_holds_all_nearer_unlabelled_corners(free, entries):
    pool, fringe, cells, edges = fringe_of(free, entries)
    far = [twin.lengths_from(free, cell) for cell in cells]
    for rank in range(pool.labelled, len(cells)):
        box = fringe.boxes[rank] - 1  # without the margin
        climbed = climbed_from(rank, fringe, edges)
        assert min(climbed) >= pool.labelled
        for other, length in climbed.items():
            row, column = cells[other]
            over = min((far[rank][cells[hub]] + far[hub][row, column] for hub in range(pool.labelled)), default=9e9)
            if length < over - 1e-6:
                assert box[TOP] <= row <= box[BOTTOM]
                assert box[LEFTMOST] <= column <= box[RIGHTMOST]
        rows, columns = zip(*(cells[other] for other in climbed), strict=True)
        assert min(rows) <= box[TOP] <= box[BOTTOM] <= max(rows)
        assert min(columns) <= box[LEFTMOST] <= box[RIGHTMOST] <= max(columns)


def test_gates_do_not_depend_on_threads():
    free = np.random.default_rng(7).random((120, 120)) > 0.25
    (pool, one, *_), (_, two, *_) = (fringe_of(free, 20_000, threads) for threads in (1, 2))
    assert 0 < pool.labelled < len(pool.ranks)
    assert all(gates_of(one, rank) == gates_of(two, rank) for rank in range(len(pool.ranks)))
    np.testing.assert_array_equal(one.local, two.local)
    np.testing.assert_array_equal(one.boxes, two.boxes)


@given(st.integers(0, STRAIGHT - 1), st.integers(0, 2000))
def test_moves_in_recovers_the_number_of_moves(diagonal, straight):
    assert moves_in(in_whole_numbers((0, 0), (diagonal, diagonal + straight))) == diagonal + straight
