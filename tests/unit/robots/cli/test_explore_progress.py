"""Lines of progress: one when the robot does something else, and one now and then."""

from ppaas.messages.base.std_msgs import Duration
from ppaas.messages.explore_msgs import ExploreFeedback
from robots.cli.explore_progress import ExploreProgress, line_of


def feedback(seconds: float, text: str, **numbers: float) -> ExploreFeedback:
    return ExploreFeedback(exploration_time=Duration.of(seconds), text=text, **numbers)  # type: ignore[arg-type]


def test_line_has_time_frontiers_area_distance_and_what_the_robot_does() -> None:
    told = feedback(75.0, "driving to a frontier at (1.0, 2.0)", frontiers=4, area=31.24, distance=12.06)
    assert line_of(told) == " 1m 15s  4 frontiers, 31.2 m² known, 12.1 m driven: driving to a frontier at (1.0, 2.0)"
    told.unreachable = 1
    assert "4 frontiers, 1 given up, " in line_of(told)


def test_control_characters_of_a_text_are_not_printed() -> None:
    assert "\x1b" not in line_of(feedback(1.0, "\x1b[2J"))


def test_same_text_is_repeated_every_five_seconds_only() -> None:
    lines: list[str] = []
    progress = ExploreProgress(lines.append)
    for second in range(12):
        progress(feedback(float(second), "driving" if second < 3 else "looking"))
    assert [line.split()[0] for line in lines] == ["0s", "3s", "8s"]
