"""Stage of the demo of mapping: the world is in the frame of the map that is to be made."""

from ppaas.maps.grid import FREE
from robots.demo.demonstration import DemoOptions
from robots.demo.exploration import GOALS, set_stage


def test_explorer_starts_at_the_origin_and_all_poses_are_free() -> None:
    stage = set_stage(DemoOptions(seed=3))
    assert stage.map_id == "office"
    assert len(stage.course.goals) == GOALS
    for x, y, _ in ((0.0, 0.0, 0.0), stage.course.start, *stage.course.goals):
        cell = stage.grid.info.cell_of(x, y)
        assert cell is not None
        assert stage.grid.data[cell] == FREE
