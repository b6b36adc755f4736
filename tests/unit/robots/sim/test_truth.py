"""The true pose is for the physics, the sensors and the scorer: all else must do with what the cloud tells."""

import ast

from tests.support.sources import ROOT

ROBOTS = ROOT / "robots"
KNOW_THE_TRUTH = {
    "sim/turtlebot.py", "sim/robot.py", "sim/world.py", "sim/scorer.py", "sim/contacts.py", "sim/walker.py",
    "bench/localize/scene.py",  # scores localization, and drives where that is lost too
    "bench/localize/jam.py",  # has people crowd around the robot, wherever it is
    "bench/goals/referee.py", "bench/goals/run.py", "bench/goals/picture.py",  # score goals, and draw how they went
}  # fmt: skip


def reads_the_truth(source: str) -> bool:
    """Tell whether a source looks into a robot's body."""
    return any(
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Attribute)
        and node.value.attr in ("base", "body")
        for node in ast.walk(ast.parse(source))
    )


def test_no_module_but_those_of_the_world_and_the_scorer_looks_into_a_body() -> None:
    found = {path.relative_to(ROBOTS).as_posix() for path in ROBOTS.rglob("*.py") if reads_the_truth(path.read_text())}
    assert found <= KNOW_THE_TRUTH
    assert "sim/scorer.py" in found
