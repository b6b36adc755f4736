"""Rides of the bench: floors are known and robots localized, and rides that fail count as such."""

import numpy as np

from benchmarks.building import rides
from ppaas.buildings.riding.floor_belief import FloorBelief
from ppaas.buildings.riding.floor_finder import FloorFinder
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters


def test_robots_know_their_floor_and_pose_after_rides() -> None:
    scores = list(rides.measure(8, seed=3))[-1]
    assert (scores.rides, scores.known, scores.wrong, scores.late) == (8, 8, 0, 0)
    assert max(scores.seconds) <= rides.TIME and max(scores.errors) <= rides.WITHIN
    assert scores.passed
    assert {row["measured"]: row["value"] for row in scores.rows()}["floor known"] == "8 of 8"
    assert "5% end on another" in scores.sentences()[0]


def test_a_ride_after_which_nothing_is_known_counts_as_late() -> None:
    scores = rides.RideScores(rides=4, known=3, late=1, seconds=[0.1, 0.2, 2.0], errors=[0.01, 0.02, 0.03])
    found = {row["measured"]: row["value"] for row in scores.rows()}
    assert (found["floor known"], found["localized in time"], found["time until then"]) == (
        "3 of 4",
        "3 of 4",
        "0.2, 2",
    )
    assert not scores.passed and not rides.RideScores().passed and len(rides.RideScores().rows()) == 3


def test_a_robot_whose_pose_in_the_car_is_wrong_is_found_in_the_lobby() -> None:
    made, random = rides.made_up(5), np.random.default_rng(1)
    landings = {landing.floor: landing for landing in made.layout.landings["lift"]}
    belief = FloorBelief({floor.name: floor.elevation for floor in made.layout.building.floors}, "L1", "L3")
    outside = Pose2D(*landings["L3"].car) @ Pose2D(2.4, 0.3, 0.4)
    robot = rides.LeavingRobot(made, "L3", outside, random)
    wrong = {name: (made.layers[name], Pose2D(*landing.car)) for name, landing in landings.items() if name != "L1"}
    finder = FloorFinder(belief, wrong, robot.odom, AmclParameters())
    for _ in range(20):
        finder.scan(robot.scan(), robot.odom)
        robot.drive(0.05, 0.1)
    finder.scan(robot.scan(), robot.odom)
    assert finder.found is not None
    floor, pose = finder.found
    assert floor == "L3" and pose.distance_to(robot.pose) < 0.1
