"""Graph mapper: closures of wide windows are trusted in agreeing sets only."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.closures import agreement
from ppaas.mapping.closures.closure import Closure, Searched
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.pipeline.graph_mapper import GraphMapper
from ppaas.mapping.scan_points import prepare
from ppaas.planar_poses import relative

GEOMETRY = LaserGeometry(-1.5, 0.1, 31)
COUNT = 40


def closure(source: int, target: int, measurement, wide: bool = True) -> Closure:
    edges = Edges(
        np.array([target]), np.array([source]), np.array([measurement], float), np.diag((900.0, 900.0, 9000.0))[None],
        np.array([EdgeKind.CLOSURE], np.uint8),
    )  # fmt: skip
    return Closure(Submap(source, source + 1), Submap(target, target + 1), edges, 0.9, Pose2D(0.0, 0.0), wide)


@pytest.fixture
def mapper(monkeypatch) -> GraphMapper:
    """Return a mapper that has driven 0.5 m per scan along x; every scan is a key frame, and no loop was found."""
    found = GraphMapper(GEOMETRY)
    monkeypatch.setattr(found._search, "search", lambda *_: Searched())
    blind = prepare(np.full(31, np.nan), GEOMETRY, SlamParameters())
    for number in range(COUNT):
        found.add(blind, Pose2D(0.5 * number, 0.0))
    return found


def close(mapper: GraphMapper, monkeypatch, *closures: Closure) -> None:
    monkeypatch.setattr(mapper._search, "search", lambda *_: Searched(list(closures)))
    mapper._close_loops()


def moved(mapper: GraphMapper) -> float:
    poses = mapper.key_frames.poses
    return float(np.abs(relative(poses[0], poses[COUNT - 1]) - (0.5 * (COUNT - 1), 0.0, 0.0)).max())


def test_every_key_frame_is_a_node_with_an_edge_of_the_odometry(mapper):
    assert mapper.graph.node_count == COUNT
    np.testing.assert_allclose(mapper.graph.edges.measurements, [(0.5, 0.0, 0.0)] * (COUNT - 1), atol=1e-6)
    assert (mapper.graph.edges.kinds == EdgeKind.ODOMETRY).all()


def test_a_closure_of_a_narrow_window_is_trusted_at_once(mapper, monkeypatch):
    close(mapper, monkeypatch, closure(30, 2, (14.1, 0.0, 0.0), wide=False))
    assert mapper.counts.closures == mapper.counts.edges == 1
    assert moved(mapper) > 0.01


def test_a_lone_closure_of_a_wide_window_waits_and_is_given_up(mapper, monkeypatch):
    close(mapper, monkeypatch, closure(30, 2, (14.1, 0.0, 0.0)))
    assert (mapper.counts.closures, moved(mapper)) == (0, pytest.approx(0.0, abs=1e-6))
    monkeypatch.setattr(mapper._search, "search", lambda *_: Searched())
    mapper.finish()
    assert (mapper.counts.closures, mapper.counts.lone) == (0, 1)


def test_closures_of_wide_windows_that_agree_are_trusted_together(mapper, monkeypatch):
    close(mapper, monkeypatch, closure(30, 2, (14.1, 0.0, 0.0)))
    close(mapper, monkeypatch, closure(34, 4, (15.1, 0.0, 0.0)))
    assert mapper.counts.closures == 2
    assert moved(mapper) > 0.01


def test_closures_of_wide_windows_that_contradict_each_other_are_not_trusted(mapper, monkeypatch):
    close(mapper, monkeypatch, closure(30, 2, (14.1, 0.0, 0.0)))
    close(mapper, monkeypatch, closure(34, 4, (3.0, 6.0, 1.0)))
    assert mapper.counts.closures == 0


def test_closures_that_wait_are_bounded(mapper, monkeypatch):
    monkeypatch.setattr(agreement, "largest_consistent_set", lambda graph, edges: np.zeros(len(edges.first), bool))
    for number in range(agreement.WAITING + 3):
        close(mapper, monkeypatch, closure(30, 2, (float(number), 0.0, 0.0)))
    assert mapper.counts.lone == 3


def test_closures_that_the_drive_missed_are_searched_again_at_its_end(mapper, monkeypatch):
    searched, missed = [], closure(30, 2, (14.1, 0.0, 0.0), wide=False)

    def search(_frames, _graph, submaps, of, links=None):
        searched.append((of, links is not None))
        return Searched([missed] if links is not None and of == 5 and not links.join(5, 0) else [])

    monkeypatch.setattr(mapper._search, "search", search)
    mapper.finish()
    count = len(mapper._submaps.finished)
    again = [(of, True) for of in range(count)]
    assert searched == [(count - 1, False), *again, *again]
    assert mapper.counts.closures == 1
    assert moved(mapper) > 0.01
    assert mapper.weights.shape == (COUNT,)
