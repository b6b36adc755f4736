"""Report of a chaos run, as JSON and as text."""

import msgspec

from benchmarks.chaos.faults import InjectedFault
from benchmarks.chaos.message_checks import Gap
from benchmarks.chaos.report import (
    LONGEST,
    NO_FAULT,
    SEVERAL,
    ChaosReport,
    ServiceGap,
    Stray,
    log_of,
    longest_by_fault,
    longest_silences,
    strays_of,
)


def report(*wrong: str) -> ChaosReport:
    return ChaosReport(
        seed=1, robots=2, operators=1, machines=2, standby=True, seconds=60.0,
        faults={"container, killed": 3}, longest_gap_s={"web, killed": 4.5},
        longest_silence_s={"web, killed": 3.5},
        goals={"sent": 9, "result": 8, "status": 0, "lost": 1}, statuses={"SUCCEEDED": 8}, not_reached={},
        paths={"path": 7},
        commands=1000, sessions=2, cloud_starts=1, take_overs=1,
        log=[InjectedFault("container, killed", 3.0, "m2", 77)],
        silences=[ServiceGap("r", 3.0, 4.0, ["container, killed"])], wrong=list(wrong),
    )  # fmt: skip


def test_a_gap_is_attributed_to_the_only_fault_that_can_have_caused_it() -> None:
    faults = [InjectedFault("a", 10.0), InjectedFault("b", 14.0), InjectedFault("a", 30.0)]
    gaps = [Gap(10.5, 15.0), Gap(14.5, 15.0), Gap(31.2, 32.0), Gap(29.0, 30.5), Gap(10.5, 11.5)]
    assert longest_by_fault(faults, gaps) == {SEVERAL: 4.5, "b": 0.5, NO_FAULT: 0.8, "a": 1.5}


def test_a_stopped_process_can_cause_gaps_until_it_continues_or_exits() -> None:
    faults = [InjectedFault("fork server, stopped", 10.0, until=20.0), InjectedFault("container, killed", 18.0)]
    gaps = [Gap(15.0, 16.0), Gap(18.5, 22.0), Gap(21.5, 22.0)]
    assert longest_by_fault(faults, gaps) == {"fork server, stopped": 1.0, SEVERAL: 3.5, NO_FAULT: 0.5}


def test_the_longest_silences_are_listed_with_their_causes() -> None:
    faults = [InjectedFault("web, killed", 105.0), InjectedFault("web, stopped", 110.04, until=113.04)]
    gaps = {"a": [Gap(105.5, 108.0)] * LONGEST, "b": [Gap(120.0, 125.0)]}
    first, second, *others = longest_silences(faults, gaps, 100.0)
    assert first == ServiceGap("b", 20.0, 25.0, [])
    assert second == ServiceGap("a", 5.5, 8.0, ["web, killed"])
    assert len(others) == LONGEST - 2
    assert log_of(faults, 100.0) == [InjectedFault("web, killed", 5.0), InjectedFault("web, stopped", 10.0, until=13.0)]


def test_an_error_fails_a_run() -> None:
    assert report().passed
    failed = report("3.0 s: r received the feedback of a control cycle again")
    assert not failed.passed
    assert "WRONG: 3.0 s: r received the feedback of a control cycle again" in failed.sentences()
    assert failed.sentences()[-1] == "errors: 1"


def test_every_kind_of_fault_or_gap_has_a_row() -> None:
    assert report().rows() == [
        {"fault": "container, killed", "times": 3, "longest gap s": None, "served by nobody s": None},
        {"fault": "web, killed", "times": 0, "longest gap s": 4.5, "served by nobody s": 3.5},
    ]


def test_the_json_has_the_whole_report() -> None:
    assert msgspec.convert(msgspec.to_builtins(report("x")), ChaosReport) == report("x")


def test_contacts_of_robots_in_traffic_are_told() -> None:
    told = msgspec.structs.replace(report(), fleet=6, fleet_contacts=1).sentences()
    assert "6 more robots in traffic: 1 contacts" in told
    assert not [line for line in report().sentences() if "traffic" in line]


def test_times_astray_are_listed_with_the_faults_shortly_before_them() -> None:
    faults = [
        InjectedFault("web, killed", 85.0),
        InjectedFault("agent, stopped", 80.0, until=99.0),
        InjectedFault("container, killed", 105.0),
        InjectedFault("router, killed", 106.0),
    ]
    strays = strays_of(faults, {"b": [Gap(105.5, 130.0)], "a": [Gap(95.0, 96.0)]}, began=80.0)
    assert strays == [
        Stray("a", 15.0, 16.0, ["web, killed"]),
        Stray("b", 25.5, 50.0, ["agent, stopped", "container, killed"]),
    ]
    told = msgspec.structs.replace(report(), strays=strays).sentences()
    assert "b was astray from 25.5 to 50.0 s, after agent, stopped, container, killed" in told
