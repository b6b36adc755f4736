"""Only physics, sensors and scorers read the true pose."""

import ast

from tests.support.sources import sources

READERS_OF_THE_TRUTH = {
    "robots/sim/robot.py", "robots/sim/world.py", "robots/sim/contacts.py",
    "robots/sim/pedestrian.py", "robots/sim/actors.py", "robots/demo/scorer.py",
    "benchmarks/localization/run.py",  # scores localization, and drives by the true pose
    "benchmarks/localization/crowd.py",  # places people around the true position of the robot
    # score goals, and draw how they went
    "robots/demo/contact_referee.py", "benchmarks/navigation/goals/run.py",
    "robots/demo/people.py", "robots/demo/people_truth.py",  # registers the robots at their starts; scores people
    "benchmarks/navigation/goals/picture.py",
    # carry out what robots measure of people, and score it
    "benchmarks/people/runs/scene.py", "benchmarks/people/runs/robot.py",
    "benchmarks/people/bandwidth.py", "benchmarks/people/legs.py",
    "benchmarks/fleet/traffic.py",  # places robots at their starts, and measures how near they come
    "benchmarks/service/dashboard_under_load.py",  # registers the robots at their starts
    "benchmarks/chaos/robot_under_test.py",  # tells how far a robot is from a goal that does not end
}  # fmt: skip


def reads_the_truth(tree: ast.Module) -> bool:
    """Return whether a module reads a robot's body."""
    return any(
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Attribute)
        and node.value.attr in ("base", "body")
        for node in ast.walk(tree)
    )


def test_only_world_and_scorers_read_the_true_pose() -> None:
    found = {source.path for source in sources("robots", "benchmarks") if reads_the_truth(source.tree)}
    assert found <= READERS_OF_THE_TRUTH
    assert "robots/demo/scorer.py" in found
