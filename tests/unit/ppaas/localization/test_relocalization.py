"""Relocalization: whether a robot counts as lost, and which searches are run."""

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_search import PoseCandidates, PoseSearch
from ppaas.localization.relocalization import LEAST_SHARE, MOST_SHARE, Relocalizer
from ppaas.localization.scan_history import SCANS, SPACING
from tests.support.world.planar_world import walled_map

LAYERS = build_layers(walled_map(6, 5, []))
POINTS = np.array([[1.0, 0.0], [0.0, 1.0]])
HERE = Pose2D(1.0, 1.0, 0.0)


@pytest.fixture
def relocalizer() -> Relocalizer:
    return Relocalizer(LAYERS, AmclParameters(), np.random.default_rng(1))


def drive(relocalizer: Relocalizer, begin: float, end: float, fit: float) -> list[PoseSearch]:
    """Add a scan every decimetre; return the searches requested."""
    looked = []
    for x in np.arange(begin, end, 0.1).tolist():
        relocalizer.note(fit, Pose2D(x, 0.0, 0.0), POINTS, HERE)
        looked.append(relocalizer.next_search())
    return [search for search in looked if search is not None]


def places(search: PoseSearch, told: float, count: int = 100) -> PoseCandidates:
    weights = np.zeros(count)
    weights[0] = 1.0
    return PoseCandidates(search, np.tile((3.0, 3.0, 0.0), (count, 1)), weights, told)


def test_a_robot_whose_scans_fit_is_not_looked_for(relocalizer: Relocalizer) -> None:
    assert drive(relocalizer, 0.0, 10.0, fit=0.8) == []


def test_a_robot_whose_scans_fit_worse_is_looked_for_and_lost_only_if_it_is_likelier_elsewhere(
    relocalizer: Relocalizer,
) -> None:
    drive(relocalizer, 0.0, 5.0, fit=0.8)
    search = drive(relocalizer, 5.0, 6.0, fit=0.4)[-1]
    assert relocalizer.redraw_share(places(search, told=0.5)) == 0.0
    assert not relocalizer.searching
    assert relocalizer.redraw_share(places(search, told=1e-6)) == MOST_SHARE
    assert relocalizer.searching


def test_of_what_was_seen_before_scans_fitted_worse_nothing_counts(relocalizer: Relocalizer) -> None:
    drive(relocalizer, 0.0, 5.0, fit=0.8)
    assert drive(relocalizer, 5.0, 6.0, fit=0.4)[0].metres == 0.0


def test_where_scans_fit_worse_and_nowhere_better_the_search_ends(relocalizer: Relocalizer) -> None:
    drive(relocalizer, 0.0, 5.0, fit=0.8)
    looked = drive(relocalizer, 5.0, 5.0 + 0.5 * (SCANS + 2), fit=0.6)
    assert len(looked) > SCANS
    assert relocalizer.redraw_share(places(looked[-1], told=0.9)) == 0.0
    assert drive(relocalizer, 20.0, 25.0, fit=0.6) == []


def test_a_robot_that_is_looked_for_is_so_each_time_it_has_moved(relocalizer: Relocalizer) -> None:
    relocalizer.begin(searching=True)
    looked = drive(relocalizer, 0.0, 2.0, fit=0.8)
    ways = [search.metres for search in looked]
    assert ways[0] == 0.0
    assert all(SPACING - 1e-9 <= way <= SPACING + 0.1 + 1e-9 for way in np.diff(ways))
    assert relocalizer.is_current(places(looked[-1], told=1.0))
    assert not relocalizer.is_current(places(looked[0], told=1.0))
    assert relocalizer.redraw_share(places(looked[-1], told=1.0)) == LEAST_SHARE


def test_a_scan_that_sees_nothing_is_not_looked_for(relocalizer: Relocalizer) -> None:
    relocalizer.begin(searching=True)
    relocalizer.note(0.8, HERE, np.empty((0, 2)), HERE)
    assert relocalizer.next_search() is None
