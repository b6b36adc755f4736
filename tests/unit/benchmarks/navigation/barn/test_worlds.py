from pathlib import Path

import pytest

from benchmarks.navigation.barn.worlds import read_worlds
from ppaas.errors import InvalidInput, NotFound
from tests.support.world import barn


def test_worlds_are_read_with_their_own_or_another_radius(tmp_path: Path) -> None:
    path = barn.write(tmp_path / "worlds.json", barn.world(3), barn.world(9))
    assert [each.world for each in read_worlds(path)] == [3, 9]
    [one] = read_worlds(path, (9,), 0.115)
    assert (one.world, one.radius) == (9, 0.115)
    assert one.centres.shape == (len(one.cylinders), 2)
    assert one.best_time == pytest.approx(5.1)


def test_an_unknown_world_is_named(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match="world '4'; known: 3"):
        read_worlds(barn.write(tmp_path / "worlds.json", barn.world(3)), (4,))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '[{"world": 1}]',
        '[{"world": 1, "radius": 0.1, "cylinders": [[1.0]], "path_length": 1.0}]',
        '[{"world": 1, "radius": 0.0, "cylinders": [], "path_length": 1.0}]',
        '[{"world": 1, "radius": 0.1, "cylinders": [[1.0, 1e999]], "path_length": 1.0}]',
        '[{"world": 1, "radius": 0.1, "cylinders": [], "path_length": -1.0}]',
    ],
)
def test_an_invalid_file_of_worlds_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "worlds.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput):
        read_worlds(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"worlds\.json"):
        read_worlds(tmp_path / "worlds.json")
