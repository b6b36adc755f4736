"""What a run came to, as programs and people read it."""

import msgspec

from robots.bench.chaos.faults import Fault
from robots.bench.chaos.report import NO_FAULT, SEVERAL, Report, longest_by_fault
from robots.bench.chaos.witness import Gap


def report(*wrong: str) -> Report:
    return Report(
        seed=1, robots=2, machines=2, seconds=60.0, faults={"container, killed": 3}, longest_gap_s={"web, killed": 4.5},
        goals={"sent": 9, "result": 8, "status": 0, "lost": 1}, statuses={"SUCCEEDED": 8}, paths={"path": 7},
        commands=1000, sessions=2, cloud_starts=1, log=[Fault("container, killed", 3.0, "m2", 77)], wrong=list(wrong),
    )  # fmt: skip


def test_a_gap_counts_for_the_one_fault_that_can_have_caused_it() -> None:
    faults = [Fault("a", 10.0), Fault("b", 14.0), Fault("a", 30.0)]
    gaps = [Gap(10.5, 15.0), Gap(14.5, 15.0), Gap(31.2, 32.0), Gap(29.0, 30.5), Gap(10.5, 11.5)]
    assert longest_by_fault(faults, gaps) == {SEVERAL: 4.5, "b": 0.5, NO_FAULT: 0.8, "a": 1.5}


def test_what_is_wrong_fails_a_run() -> None:
    assert report().passed
    failed = report("3.0 s: r heard of a control cycle again")
    assert not failed.passed
    assert "WRONG: 3.0 s: r heard of a control cycle again" in failed.sentences()
    assert failed.sentences()[-1] == "1 things are wrong"


def test_kinds_that_were_not_done_or_left_no_gap_have_their_row() -> None:
    assert report().rows() == [
        {"fault": "container, killed", "times": 3, "longest gap s": None},
        {"fault": "web, killed", "times": 0, "longest gap s": 4.5},
    ]


def test_programs_read_all_of_it() -> None:
    assert msgspec.convert(msgspec.to_builtins(report("x")), Report) == report("x")
