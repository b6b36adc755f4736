"""Memory of lifelong mapping over hours, shortened to a minute."""

from benchmarks.mapping.parts.lifelong import mapped as mapped_hours, rows
from tests.support.world.ring_drive import ring_drive


def test_each_hour_is_measured() -> None:
    first, second = mapped_hours(ring_drive(), 50.0)
    assert (first["hour"], second["hour"]) == (1, 2)
    assert 0 < first["key_frames"] < second["key_frames"]
    assert 0.0 < first["log_mb"] < second["log_mb"]
    assert max(first["error_m"], second["error_m"]) < 0.1


def test_growth_is_that_since_the_hour_before() -> None:
    hour = {"memory_mb": 200.0, "key_frames": 10, "edges": 9, "log_mb": 0.1, "error_m": 0.01, "cpu_s": 1.0}
    table = rows([{"hour": 1, **hour}, {"hour": 2, **hour, "memory_mb": 201.5}])
    assert [row["growth MB"] for row in table] == ["+0.0", "+1.5"]
    assert table[1]["memory MB"] == "201.5"
