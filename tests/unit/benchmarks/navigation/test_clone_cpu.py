"""CPU time of a whole clone: its robot drives, and the parts add up."""

from benchmarks.navigation import clone_cpu


def test_a_clone_is_measured_while_its_robot_drives() -> None:
    laps: list[None] = []
    spent = clone_cpu.measure(1, 3, done=lambda: laps.append(None))
    assert spent.commands >= 15 and len(spent.frames) == 30 and laps
    told = {str(row["work"]): float(str(row["ms"])) for row in clone_cpu.rows(spent)}
    causes = [told[cause] for cause in clone_cpu.CAUSES]
    assert min(causes) > 0.0 and abs(told["in all"] - sum(causes)) < 0.1
    parts = [ms for work, ms in told.items() if work.startswith(("node ", "links"))]
    assert abs(told["in all"] - sum(parts)) < 0.5
    assert told["json, the same frames"] > 0.0
