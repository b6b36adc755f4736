import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.kernels import dwa
from ppaas.controllers.kernels.clearance import clearance
from ppaas.controllers.kernels.dwa import BLOCKED, Frame, OutlineCheck, Scoring, score_velocities
from ppaas.geometry import Pose2D
from ppaas.maps.kernels.distance import distance_serial
from tests.reference.driving import controllers
from tests.support.world import grids

SCORING = Scoring(1.7, 0.025, 0.2, 1.0, 0.5, 32.0, 24.0, 0.1, 0.2, 0.5, True, False, 0.36)
LINE = np.stack((np.linspace(0.0, 6.0, 40), np.full(40, 1.0)), axis=1)


def frame(costmap):
    x, y, theta = costmap.info.origin
    return Frame(x, y, math.cos(theta), math.sin(theta), costmap.info.resolution)


DISC = OutlineCheck(body_of((), 0.18), np.ones((1, 1), np.float32), 0.0)
BOX = body_of(((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)), 0.0)


def scores(costmap, velocities, pose, path=LINE, scoring=SCORING, outline=DISC):
    lengths = np.hypot(*np.diff(path, axis=0).T)
    remaining = np.concatenate((np.cumsum(lengths[::-1])[::-1], [0.0]))
    return score_velocities(
        np.array(velocities, dtype=float), costmap.data, frame(costmap), path, remaining, *pose, scoring, outline
    ), remaining


def field(draw_walls=()):
    data = np.zeros((40, 80), np.uint8)
    for rows, columns, cost in draw_walls:
        data[rows, columns] = cost
    return grids.of(data, 0.05)


@given(
    seed=st.integers(0, 10_000),
    density=st.floats(0.0, 0.3),
    pose=st.tuples(st.floats(0.1, 1.9), st.floats(0.1, 1.9), st.floats(-3.2, 3.2)),
    velocity=st.tuples(st.floats(-0.5, 1.0), st.floats(-1.5, 1.5)),
    unknown=st.booleans(),
    leaving=st.booleans(),
)
def test_kernel_scores_like_its_twin(seed, density, pose, velocity, unknown, leaving):
    rng = np.random.default_rng(seed)
    data = rng.integers(0, 253, (20, 20)).astype(np.uint8)
    crowded = rng.random(data.shape) < density
    data[crowded] = rng.choice([253, 254, 255], int(crowded.sum()))
    costmap = grids.of(data, 0.1, Pose2D(0.3, -0.2, 0.4))
    path = np.cumsum(rng.uniform(-0.05, 0.15, (rng.integers(1, 20), 2)), axis=0)
    scoring = SCORING._replace(allow_unknown=unknown, leaving=leaving)
    got, remaining = scores(costmap, [velocity], pose, path, scoring)
    assert got[0] == pytest.approx(
        controllers.score(costmap, path, remaining, pose, velocity, scoring), rel=1e-9, abs=1e-9
    )


@given(
    seed=st.integers(0, 10_000),
    start=st.tuples(st.floats(0.8, 3.0), st.floats(0.8, 1.4), st.floats(-3.2, 3.2)),
    velocity=st.tuples(st.floats(-0.5, 0.8), st.floats(-1.5, 1.5)),
)
def test_outline_rollout_is_blocked_exactly_if_a_pose_is_too_near(seed, start, velocity):
    rng = np.random.default_rng(seed)
    lethal = rng.random((40, 80)) < 0.002
    lethal[0, 0] = True
    distance, least = distance_serial(lethal.view(np.uint8), 0.05), 0.035
    # One cost everywhere, since a point on the edge of a cell may be assigned to either. A disc would not fit in 253.
    cost = int(rng.choice([0, 100, 253]))
    costmap = grids.of(np.full(lethal.shape, cost, np.uint8), 0.05, Pose2D(0.5, -0.3, 0.3))
    pose = costmap.info.origin @ Pose2D(*start)
    got, remaining = scores(costmap, [velocity], pose, outline=OutlineCheck(BOX, distance, least))
    poses = controllers.arc(start, velocity[0] * 1.7, velocity[1] * 1.7, 300)
    # The start of a rollout is not checked, since the robot is there already; its first step is a few centimetres on.
    nearest = min(clearance(distance, 0.05, BOX, x, y, math.cos(a), math.sin(a)) for x, y, a in poses[10:])
    graded = grids.of(np.minimum(costmap.data, 252), 0.05, costmap.info.origin)
    if nearest > least + 0.02:
        free = controllers.score(graded, LINE, remaining, pose, velocity, SCORING)
        assert got[0] == pytest.approx(free, abs=0.2)  # a tenth is that of 253 to 252, and what that slows
    elif nearest < least - 0.03:
        assert got[0] >= BLOCKED


def test_fastest_velocity_along_a_straight_path_scores_best():
    got, _ = scores(field(), [(0.1, 0.0), (0.3, 0.0), (0.5, 0.0), (0.5, 0.8), (0.5, -0.8)], (1.0, 1.0, 0.0))
    assert np.argmin(got) == 2


def test_velocity_that_cannot_stop_before_an_obstacle_is_infinite():
    wall = field([(slice(None), slice(27, 30), 254)])  # 0.35 m ahead
    got, _ = scores(wall, [(0.1, 0.0), (0.5, 0.0), (1.0, 0.0)], (1.0, 1.0, 0.0))
    assert got[0] < BLOCKED <= got[1] < math.inf
    assert math.isinf(got[2])


def test_turning_in_place_is_never_blocked():
    wall = field([(slice(None), slice(21, 30), 254)])
    assert np.isfinite(scores(wall, [(0.0, 1.5)], (1.0, 1.0, 0.0))[0]).all()


def test_slower_velocity_scores_better_near_obstacles():
    graded = field([(slice(None), slice(None), 200)])
    got, _ = scores(graded, [(0.28, 0.0), (0.5, 0.0)], (1.0, 1.0, 0.0))
    assert got[0] < got[1]


def test_leaving_an_inscribed_cell_prefers_the_shortest_way_out():
    stuck = field([(slice(None), slice(16, 24), 253), (slice(None), slice(0, 16), 254)])
    out = SCORING._replace(leaving=True)
    ahead, askew, back = scores(stuck, [(0.2, 0.0), (0.2, 0.3), (-0.2, 0.0)], (1.1, 1.0, 0.0), scoring=out)[0]
    assert ahead < askew < BLOCKED
    assert math.isinf(back)
    assert math.isinf(scores(stuck, [(0.2, 0.0)], (1.1, 1.0, 0.0))[0][0])
    along = scores(stuck, [(0.1, 0.0), (0.1, 1.0)], (1.1, 1.0, math.pi / 2), scoring=out)[0]
    assert np.isinf(along).all()


def test_unknown_and_outside_are_free_only_if_allowed():
    strict = SCORING._replace(allow_unknown=False)
    for pose in ((0.5, 1.0, 0.0), (3.8, 1.0, 0.0)):
        costmap = field([(slice(None), slice(12, 16), 255)])
        assert scores(costmap, [(0.5, 0.0)], pose)[0][0] < BLOCKED
        assert scores(costmap, [(0.5, 0.0)], pose, scoring=strict)[0][0] >= BLOCKED


def test_speed_past_the_end_of_the_plan_has_no_penalty():
    path = LINE[LINE[:, 0] <= 1.2]
    got, _ = scores(field(), [(0.1, 0.0), (0.3, 0.0)], (1.0, 1.0, 0.0), path)
    assert got[1] < got[0]


def test_warm_compiles_the_kernel():
    dwa.warm()
    assert len(score_velocities.signatures) >= 3
