"""Relocalization: whether a robot counts as lost, which searches are run, and the scans of the last metres."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_search import PoseCandidates, PoseSearch
from ppaas.localization.relocalization import (
    AMISS,
    LEAST_SHARE,
    MOST_SHARE,
    SCANS,
    SPACING,
    SPACING_TURN,
    FitAverages,
    Relocalizer,
    ScanHistory,
)
from tests.support.world.planar_world import walled_map

LAYERS = build_layers(walled_map(6, 5, []))
POINTS = np.array([[1.0, 0.0], [0.0, 1.0]])
HERE = Pose2D(1.0, 1.0, 0.0)


@pytest.fixture
def relocalizer() -> Relocalizer:
    return Relocalizer(LAYERS, AmclParameters(), np.random.default_rng(1))


def drive(relocalizer: Relocalizer, begin: float, end: float, fit: float) -> list[PoseSearch]:
    """Add a scan every decimetre; return the searches requested."""
    searches = []
    for x in np.arange(begin, end, 0.1).tolist():
        relocalizer.note(fit, Pose2D(x, 0.0, 0.0), POINTS, HERE)
        searches.append(relocalizer.next_search())
    return [search for search in searches if search is not None]


def places(search: PoseSearch, believed: float, count: int = 100) -> PoseCandidates:
    weights = np.zeros(count)
    weights[0] = 1.0
    return PoseCandidates(search, np.tile((3.0, 3.0, 0.0), (count, 1)), weights, believed)


def test_no_search_while_scans_fit(relocalizer: Relocalizer) -> None:
    assert drive(relocalizer, 0.0, 10.0, fit=0.8) == []


def test_badly_fitting_robot_is_lost_only_if_likelier_elsewhere(
    relocalizer: Relocalizer,
) -> None:
    drive(relocalizer, 0.0, 5.0, fit=0.8)
    search = drive(relocalizer, 5.0, 6.0, fit=0.4)[-1]
    assert relocalizer.redraw_share(places(search, believed=0.5)) == 0.0
    assert not relocalizer.searching
    assert relocalizer.redraw_share(places(search, believed=1e-6)) == MOST_SHARE
    assert relocalizer.searching


def test_search_ignores_scans_from_before_the_bad_fit(relocalizer: Relocalizer) -> None:
    drive(relocalizer, 0.0, 5.0, fit=0.8)
    assert drive(relocalizer, 5.0, 6.0, fit=0.4)[0].metres == 0.0


def test_search_ends_if_no_other_pose_fits_better(relocalizer: Relocalizer) -> None:
    drive(relocalizer, 0.0, 5.0, fit=0.8)
    searches = drive(relocalizer, 5.0, 5.0 + 0.5 * (SCANS + 2), fit=0.6)
    assert len(searches) > SCANS
    assert relocalizer.redraw_share(places(searches[-1], believed=0.9)) == 0.0
    assert drive(relocalizer, 20.0, 25.0, fit=0.6) == []


def test_search_is_repeated_each_time_the_robot_has_moved(relocalizer: Relocalizer) -> None:
    relocalizer.begin(searching=True)
    searches = drive(relocalizer, 0.0, 2.0, fit=0.8)
    distances = [search.metres for search in searches]
    assert distances[0] == 0.0
    assert all(SPACING - 1e-9 <= distance <= SPACING + 0.1 + 1e-9 for distance in np.diff(distances))
    assert relocalizer.is_current(places(searches[-1], believed=1.0))
    assert not relocalizer.is_current(places(searches[0], believed=1.0))
    assert relocalizer.redraw_share(places(searches[-1], believed=1.0)) == LEAST_SHARE


def test_empty_scan_starts_no_search(relocalizer: Relocalizer) -> None:
    relocalizer.begin(searching=True)
    relocalizer.note(0.8, HERE, np.empty((0, 2)), HERE)
    assert relocalizer.next_search() is None


def after(averages: FitAverages, *fits: float) -> bool:
    for fit in fits:
        averages.note(fit)
    return averages.amiss


def test_steady_fits_are_not_amiss() -> None:
    averages = FitAverages(0.001, 0.1)
    assert not averages.amiss
    assert not after(averages, *[0.8] * 100, *[0.8 * (1.0 - 0.9 * AMISS)] * 1000)


def test_recent_worse_fits_are_amiss_until_scans_fit_again() -> None:
    averages = FitAverages(0.001, 0.1)
    assert after(averages, *[0.8] * 50, 0.4, 0.4, 0.4)
    assert not after(averages, *[0.8] * 20)


def test_first_fit_is_soon_outweighed() -> None:
    averages = FitAverages(0.001, 0.1)
    assert after(averages, 0.1, *[0.8] * 50, *[0.4] * 10)


def test_zero_rates_disable_the_detection() -> None:
    assert not after(FitAverages(0.0, 0.0), *[0.8] * 50, *[0.0] * 50)


def test_forget_resets_the_averages() -> None:
    averages = FitAverages(0.001, 0.1)
    after(averages, *[0.8] * 50)
    averages.forget()
    assert not after(averages, *[0.2] * 50)


POINT = np.array([[1.0, 0.0]])
numbers = st.floats(-3.0, 3.0)
poses = st.builds(Pose2D, numbers, numbers, numbers)


def test_scan_is_stored_only_after_the_robot_has_moved() -> None:
    history = ScanHistory()
    assert history.note(Pose2D(0.0, 0.0, 0.0), POINT)
    assert not history.note(Pose2D(0.9 * SPACING, 0.0, 0.9 * SPACING_TURN), POINT)
    assert history.note(Pose2D(0.0, 0.0, 1.1 * SPACING_TURN), POINT)
    assert history.note(Pose2D(1.1 * SPACING, 0.0, 1.1 * SPACING_TURN), POINT)
    assert history.metres == pytest.approx(1.1 * SPACING)


@given(st.lists(poses, min_size=1, max_size=6))
def test_points_of_all_scans_agree_in_the_newest_frame(odoms: list[Pose2D]) -> None:
    wall = Pose2D(5.0, -2.0, 0.0)
    history, last = ScanHistory(), odoms[0]
    for odom in odoms:
        x, y, _ = odom.inverse() @ wall
        if history.note(odom, np.array([[x, y]])):
            last = odom
    x, y, _ = last.inverse() @ wall
    seen = history.seen()
    np.testing.assert_allclose(seen[:, :2], np.tile((x, y), (len(seen), 1)), atol=1e-9)
    # Each ray keeps its length, and those of the newest scan start at the robot.
    origins = [last.inverse() @ odom for odom in odoms]
    assert all(min(math.dist(row, origin[:2]) for origin in origins) < 1e-9 for row in seen[:, 2:].tolist())
    np.testing.assert_allclose(seen[-1, 2:], 0.0, atol=1e-12)


def test_oldest_scan_is_dropped() -> None:
    history = ScanHistory()
    for i in range(SCANS + 3):
        assert history.full == (i >= SCANS)
        history.note(Pose2D(i, 0.0, 0.0), POINT)
    assert len(history.seen()) == SCANS
    assert history.metres == SCANS - 1


def test_rebase_keeps_the_history_after_an_odometry_reset() -> None:
    history, jump = ScanHistory(), Pose2D(3.0, -1.0, math.pi / 3)
    history.note(Pose2D(0.0, 0.0, 0.0), POINT)
    history.note(Pose2D(1.0, 0.0, 0.0), POINT)
    before = history.seen()
    history.rebase(jump)
    assert not history.note(jump.inverse() @ Pose2D(1.1, 0.0, 0.0), POINT)
    np.testing.assert_allclose(history.seen(), before, atol=1e-12)
