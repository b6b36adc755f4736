"""Requests to workcells are repeated until they are answered, and answers lead to confirmations."""

from typing import Any

import pytest

from ppaas.wire.rmf.workcells import ACKNOWLEDGED, AGAIN, FAILED, REPEAT, SUCCESS, Kind, Workcells


def task(**fields: Any) -> dict[str, Any]:
    given = {"id": "t1", "map": "office", "places": [[1, 2, 0], [3, 4, 0]], "visited": 1, "holding": 7.5}
    holds = [{"dispenser": "belt", "items": {"box": 2}}, {"ingestor": "rack"}]
    return given | {"needs_confirmation": True, "holds": holds} | fields


def answer(kind: Kind, message: dict[str, Any], status: int, **fields: Any) -> tuple[Kind, dict[str, Any]]:
    names = {"request_guid": message["request_guid"], "source_guid": message["target_guid"], "status": status}
    return kind, names | fields


def test_a_robot_that_holds_for_a_dispenser_is_asked_for_until_it_answers() -> None:
    cells = Workcells("carts")
    [(kind, message)] = cells.see([task()], 100.0)
    assert (kind, message["target_guid"], message["transporter_type"]) == ("dispenser", "belt", "carts")
    assert message["items"] == [{"type_guid": "box", "quantity": 2}]
    assert cells.see([task()], 100.0 + REPEAT / 2.0) == []
    [(_, again)] = cells.see([task()], 100.0 + REPEAT)
    assert again["request_guid"] == message["request_guid"]
    assert Workcells("carts").see([task()], 5.0)[0][1]["request_guid"] == message["request_guid"]
    assert cells.take(*answer(kind, message, ACKNOWLEDGED), 103.0) == ""
    assert cells.see([task()], 103.0 + REPEAT) == []
    assert cells.take(*answer(kind, message, SUCCESS), 110.0) == ("office", "t1")
    assert cells.take(*answer(kind, message, SUCCESS), 111.0) == ""
    assert cells.see([task()], 200.0) == []


def test_the_next_place_is_another_request() -> None:
    cells = Workcells("carts")
    [(_, first)] = cells.see([task()], 0.0)
    [(kind, second)] = cells.see([task(visited=2, holding=20.0)], 1.0)
    assert (kind, second["target_guid"], second["items"]) == ("ingestor", "rack", [])
    assert first["request_guid"] != second["request_guid"]
    assert cells.take(*answer("dispenser", first, SUCCESS), 2.0) == ""


def test_a_workcell_that_fails_is_asked_again_after_a_while_and_that_is_reported() -> None:
    cells = Workcells("carts")
    [(kind, message)] = cells.see([task()], 0.0)
    assert "'belt' failed task t1" in cells.take(*answer(kind, message, FAILED), 1.0)
    assert cells.see([task()], AGAIN) == []
    assert len(cells.see([task()], AGAIN + 1.0)) == 1


def test_a_confirmation_that_did_not_arrive_is_asked_for_again() -> None:
    cells = Workcells("carts")
    [(kind, message)] = cells.see([task()], 0.0)
    assert cells.take(*answer(kind, message, SUCCESS), 1.0) == ("office", "t1")
    cells.confirm_failed("t1")
    assert len(cells.see([task()], REPEAT)) == 1


@pytest.mark.parametrize(
    "other",
    [{"request_guid": "x"}, {"source_guid": "another"}],
    ids=str,
)
def test_results_of_others_confirm_nothing(other: dict[str, Any]) -> None:
    cells = Workcells("carts")
    [(kind, message)] = cells.see([task()], 0.0)
    assert not isinstance(cells.take(*answer(kind, message, SUCCESS, **other), 1.0), tuple)
    assert cells.take(*answer("ingestor", message, SUCCESS), 1.0) == ""


def test_robots_that_hold_for_people_or_do_not_hold_ask_no_workcell() -> None:
    idle = task(needs_confirmation=False, holding=None, visited=0)
    by_hand = task(holds=[{"confirm": True}, None])
    assert Workcells("carts").see([idle, by_hand, task(needs_confirmation=False, holds=[])], 0.0) == []
