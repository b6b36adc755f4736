"""Recordings are replayed to localization."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.localization.replay import ERROR, Replay, draw, drifting, map_of, play, summary
from benchmarks.localization.run import LOST
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN
from robots.recordings.recording import Recording
from robots.recordings.text_logs import read_log
from tests.support.world.drive_log import ROOM, graph_log


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("logs") / "drive.log"
    path.write_text(graph_log(40))
    return read_log(path)


def played(recording: Recording, *, anywhere: bool = False) -> Replay:
    looks = range(len(recording.looks))
    return play(recording, ROOM, {}, scans=looks, anywhere=anywhere, done=lambda: None)


@pytest.mark.parametrize("anywhere", [False, True])
def test_a_robot_is_localized_on_its_own_recording(recording: Recording, anywhere: bool) -> None:
    result = summary(played(recording, anywhere=anywhere), anywhere=anywhere)
    assert result["scans"] == 40
    assert result["lost"] is False
    assert result["error_cm"] <= result["p95_cm"] <= result["worst_cm"] <= 100.0 * LOST
    assert result["error_cm"] < 8.0
    assert result["lost_scans"] < 20
    assert result["error_deg"] < 2.0


def test_a_recording_without_true_poses_is_replayed_without_errors(recording: Recording) -> None:
    blind = replace(recording, looks=tuple(replace(look, true=None) for look in recording.looks))
    assert not all(look.true is not None for look in blind.looks)
    result = summary(played(blind, anywhere=True), anywhere=True)
    assert result["scans"] == 40
    assert result["lost"] is result["error_cm"] is None
    with pytest.raises(InvalidInput, match="--global"):
        played(blind)
    with pytest.raises(InvalidInput, match="--map"):
        map_of(blind.looks)


def test_a_map_of_scans_equals_the_recorded_room(recording: Recording) -> None:
    made = map_of(recording.looks)
    rows, columns = np.nonzero(made.data == OCCUPIED)
    world = made.info.to_world(np.column_stack((rows, columns)))
    cells = ROOM.info.to_cells(world.tolist())
    walls = np.argwhere(ROOM.data == OCCUPIED)
    near = [np.abs(walls - cell).max(axis=1).min() <= 2 for cell in np.array(cells)]
    assert np.mean(near) > 0.95
    look = recording.looks[0]
    assert made.data[made.info.cell_of(look.true.x, look.true.y)] == FREE
    assert made.data[0, 0] == UNKNOWN


def test_added_drift_worsens_odometry_reproducibly_by_seed(recording: Recording) -> None:
    once, again, other = (drifting(recording, 0.05, seed) for seed in (1, 1, 2))
    assert once == again != other
    assert once.looks[0].odom == recording.looks[0].odom
    assert 0.0 < once.looks[-1].odom.distance_to(recording.looks[-1].odom) < 1.0
    assert drifting(recording, 0.0, 1).looks[-1].odom.distance_to(recording.looks[-1].odom) < 1e-9


def test_a_picture_shows_large_errors(recording: Recording) -> None:
    looks = recording.looks
    right = Replay(looks, tuple(look.true for look in looks), 0.001)
    wrong = Replay(looks, tuple(reversed(right.told)), 0.001)
    for replay, has_errors in ((right, False), (wrong, True)):
        [axes] = draw(ROOM, replay).axes
        lines = {line.get_label(): line.get_xydata().tolist() for line in axes.lines}
        assert lines["true"] == [[look.true.x, look.true.y] for look in looks]
        assert lines["estimated"] == [[pose.x, pose.y] for pose in replay.told]
        assert (ERROR in {line.get_color() for line in axes.lines}) == has_errors


def test_errors_count_from_where_the_robot_was_found(recording: Recording) -> None:
    begin = [replace(recording.looks[0], stamp=stamp) for stamp in (1.0, 2.0)]
    looks = (*begin, *recording.looks[1:])
    estimates = (Pose2D(5.0, 4.0), *(look.true for look in looks[1:]))
    summed = summary(Replay(looks, estimates, 0.001), anywhere=True)
    assert (summed["lost"], summed["lost_scans"], summed["found_m"], summed["worst_cm"]) == (False, 1, 0.0, 0.0)
    assert summary(Replay(looks, estimates, 0.001), anywhere=False)["lost"] is True
