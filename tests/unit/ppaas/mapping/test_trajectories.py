"""Trajectories as text: our lines, and those of TUM and KITTI."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.mapping.trajectories import TRAJECTORY_FORMATS, format_trajectory, is_trajectory, parse_trajectory

STAMPS = np.array([10.0, 11.0, 12.5])
POSES = np.array([(0.0, 0.0, 0.0), (1.0, -2.0, math.pi / 2.0), (1.25, 1.0, -3.0)])


@pytest.mark.parametrize("form", TRAJECTORY_FORMATS)
def test_what_is_written_is_read_again(form):
    found = parse_trajectory("# a comment\n\n" + format_trajectory(STAMPS, POSES, form))
    if form == "kitti":
        assert found.stamps is None
    else:
        np.testing.assert_allclose(found.stamps, STAMPS)
    np.testing.assert_allclose(found.poses, POSES, atol=1e-6)


def test_a_line_of_tum_has_a_quaternion_whose_last_number_is_w():
    lines = format_trajectory(STAMPS, POSES, "tum").splitlines()
    assert lines[0] == "10.000000 0.000000 0.000000 0 0 0 0.000000000 1.000000000"
    assert lines[1] == "11.000000 1.000000 -2.000000 0 0 0 0.707106781 0.707106781"


def test_a_line_of_kitti_has_the_rows_of_a_matrix():
    line = format_trajectory(STAMPS, POSES, "kitti").splitlines()[1]
    np.testing.assert_allclose([*map(float, line.split())], [0, -1, 0, 1, 1, 0, 0, -2, 0, 0, 1, 0], atol=1e-8)


def test_stamps_of_tum_ascend_and_each_comes_once():
    stamps, poses = np.array([2.0, 1.0, 2.0]), POSES
    lines = format_trajectory(stamps, poses, "tum").splitlines()
    assert [line.split()[0] for line in lines] == ["1.000000", "2.000000"]
    assert lines[1].split()[1:3] == ["0.000000", "0.000000"]
    assert len(format_trajectory(stamps, poses).splitlines()) == 3


def test_poses_in_space_are_seen_from_above():
    tilt, turn = math.radians(5.0), 0.7
    line = f"1 2 3 0.4 0 {math.sin(tilt / 2):.9f} 0 {math.cos(tilt / 2):.9f}\n"
    np.testing.assert_allclose(parse_trajectory(line).poses, [(2.0, 3.0, 0.0)], atol=1e-6)
    both = f"1 2 3 0.4 0 0 {math.sin(turn / 2):.9f} {math.cos(turn / 2):.9f}\n"
    np.testing.assert_allclose(parse_trajectory(both).poses, [(2.0, 3.0, turn)], atol=1e-6)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no line of numbers: each is 'timestamp x y theta' or"),
        ("# only a comment\n", "no line of numbers"),
        ("1 2 3\n", "line 1 is not 'timestamp x y theta' or .*: 4 or 8 or 12 finite numbers"),
        ("1 2 3 4\n1 2 3 inf\n", "line 2 is not 'timestamp x y theta': 4 finite numbers"),
        ("# x\n1 2 3 4\n1 2 3 4 5 6 7 8\n", "line 3 is not 'timestamp x y theta'"),
        ("1 2 3 0 0 0 0 one\n", "line 1 is not"),
        ("1,2,3,4\n", "line 1 is not"),
        ("1 2 3 0 0 0 0 0\n", "pose 1 has a quaternion of length 0"),
        ("1 2 3 0 0 0 1 1\n", "pose 1 has a quaternion of length 1.41"),
        ("1 2 3 0 0.7071068 0 0 0.7071068\n", "pose 1 is tilted by 90°"),
        ("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 0 -1 0 0 1 0 0\n", "pose 2 is tilted by 90°"),
        ("1 1 0 0 0 1 0 0 0 0 1 0\n", "pose 1 has a matrix that is no rotation"),
    ],
)
def test_what_is_no_trajectory_of_a_robot_is_refused(text, why):
    with pytest.raises(InvalidInput, match=why):
        parse_trajectory(text)


def test_relations_are_told_apart_from_tum_by_their_last_four_numbers():
    assert not is_trajectory("1 2 0.1 0 0 0 0 0.3\n1 3 0.1 0 0 0 0 1.0\n")
    assert not is_trajectory("nothing of both\n")
    for form in TRAJECTORY_FORMATS:
        assert is_trajectory(format_trajectory(STAMPS, POSES, form))
