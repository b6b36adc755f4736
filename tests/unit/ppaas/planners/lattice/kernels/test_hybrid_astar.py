"""Hybrid A* expands the same nodes as its twin and finds the same paths."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.planners.lattice.kernels.driving import flat_surface
from ppaas.planners.lattice.kernels.hybrid_astar import GREED
from ppaas.planners.lattice.kernels.pose_tree import fill_table, find
from ppaas.planners.lattice.kernels.steering import Car
from ppaas.planners.lattice.search import HybridAStarSearch, motions_of
from ppaas.planners.watch import proceed
from tests.reference.planners import dijkstra
from tests.reference.planners import lattice as twin


def random_world(seed):
    """Return a world without ties between paths, and two poses in it."""
    rng = np.random.default_rng(seed)
    costs = rng.integers(0, 100, (24, 26)).astype(np.uint8)
    costs[rng.random(costs.shape) < 0.04] = 254
    ends = [Pose2D(*rng.uniform(3.0, 21.0, 2).tolist(), rng.uniform(-3.0, 3.0)) for _ in range(2)]
    for x, y, _ in ends:
        costs[math.floor(y), math.floor(x)] = 0
    car = Car(rng.uniform(1.0, 4.0), bool(seed % 2), 36, 2.0, 1.2, 0.3, 3.5, 12.0)
    return twin.World(costs, 0.9 + 0.016 * np.arange(256.0), car), ends


def searched(seed):
    """Return cost and number of expanded nodes of the kernel and of its twin; check the legs of the path."""
    world, (start, goal) = random_world(seed)
    field = dijkstra.cost_field(world.costs, [(math.floor(goal.y), math.floor(goal.x))])
    motions = motions_of(world.car, interpolated=seed % 3 == 0)
    turns = [(k, s, int(turned)) for k, s, turned in motions.tolist()]
    surface = flat_surface(world.costs)._replace(rates=world.rates)
    search = HybridAStarSearch(surface, world.car, field, motions=motions, leaving=math.nan, start=start, goal=goal)
    cost = math.inf
    if search.run(proceed, 1 << 15):
        legs = search.legs()
        cost = float(legs[:, 5].sum())
        pieces = [tuple(piece) for piece in legs[:, 3:5].tolist()]
        assert twin.cost_of(world, tuple(start), pieces, pieces[0][0]) == pytest.approx(cost)
    return (cost, search.expanded), twin.search(world, field, turns, tuple(start), tuple(goal), GREED)


def test_search_agrees_with_its_twin_except_for_ties():
    found = [searched(seed) for seed in range(16)]
    for (cost, _), (twins, _) in found:
        assert math.isfinite(cost) == math.isfinite(twins)
        if math.isfinite(cost):
            assert cost == pytest.approx(twins, rel=0.1)
    assert any(math.isfinite(cost) for (cost, _), _ in found)
    assert sum(ours == pytest.approx(its) for ours, its in found) >= 12


def test_motions_leave_their_cell_and_turn_by_whole_bins():
    for radius in (1.0, 3.7, 8.0, 250.0):
        for interpolated in (False, True):
            car = Car(radius, True, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
            motions = motions_of(car, interpolated=interpolated)
            assert (np.abs(motions[:, 0]) <= 1.0 / radius + 1e-12).all()
            np.testing.assert_allclose(motions[:, 0] * motions[:, 1], motions[:, 2] * math.tau / 72, atol=1e-12)
            for curvature, length, _ in motions.tolist():
                x, y, _ = twin.driving.pose_along((0.0, 0.0, 0.0), curvature, length)
                assert math.hypot(x, y) > math.sqrt(2.0) - 1e-9


def test_table_finds_each_node_by_its_key():
    rng = np.random.default_rng(6)
    keys = np.unique(rng.integers(0, 1 << 40, 1_000))
    table = np.full(2_048, -1, np.int32)
    fill_table(keys, table, 0, len(keys))
    assert [table[find(keys, table, key)] for key in keys.tolist()] == list(range(len(keys)))
    others = set(rng.integers(0, 1 << 40, 1_000).tolist()) - set(keys.tolist())
    assert all(table[find(keys, table, key)] == -1 for key in others)
