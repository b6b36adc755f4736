import msgspec
import pytest

from ppaas import errors
from ppaas.wire.refusals import error_of_close, error_of_status, error_of_text


def problem(**members: object) -> bytes:
    return msgspec.json.encode(members)


@pytest.mark.parametrize(
    "kind", ["urn:ppaas:problem:goal-occupied", "https://host/errors/goal-occupied", "goal-occupied"]
)
def test_problem_slug_takes_precedence_over_the_status(kind: str) -> None:
    error = error_of_status(500, problem(type=kind, detail="a shelf stands there"))
    assert type(error) is errors.GoalOccupied
    assert str(error) == "a shelf stands there"


@pytest.mark.parametrize(
    ("status", "expected"),
    [
        (400, errors.InvalidInput),
        (401, errors.NotAuthenticated),
        (403, errors.NotPermitted),
        (404, errors.NotFound),
        (409, errors.Conflict),
        (413, errors.MessageTooLarge),
        (418, errors.InvalidInput),
        (429, errors.QuotaExceeded),
        (500, errors.Unavailable),
        (502, errors.Unavailable),
    ],
)
@pytest.mark.parametrize("body", [b"", b"<html>", b"[1]", b"\xff", problem(type="about:blank", status=1)])
def test_status_decides_without_a_known_slug(status: int, expected: type[errors.PPaaSError], body: bytes) -> None:
    error = error_of_status(status, body)
    assert type(error) is expected
    assert str(error) == f"HTTP status {status}"


def test_problem_title_is_the_text_without_detail() -> None:
    assert str(error_of_status(404, problem(title="No such robot"))) == "No such robot"


@pytest.mark.parametrize(
    ("code", "reason", "expected", "text"),
    [
        (4401, "log in again", errors.NotAuthenticated, "log in again"),
        (4409, "", errors.Conflict, "closed with code 4409"),
        (4404, "unavailable: the store is down", errors.Unavailable, "the store is down"),
        (1008, "no", errors.NotPermitted, "no"),
        (1009, "", errors.MessageTooLarge, "the connection was closed (code 1009)"),
        (1011, "", errors.Unavailable, "the connection was closed (code 1011)"),
        (1011, "not-found: no such robot", errors.NotFound, "no such robot"),
        (1001, "going away", errors.Unavailable, "going away"),
        (1000, "", errors.Unavailable, "the connection was closed (code 1000)"),
        (None, "", errors.Unavailable, "the connection was closed (code 1006)"),
        (4500, "", errors.Unavailable, "the connection was closed (code 4500)"),
    ],
)
def test_a_close_frame_is_read_by_its_slug_or_its_code(
    code: int | None, reason: str, expected: type[errors.PPaaSError], text: str
) -> None:
    error = error_of_close(code, reason)
    assert type(error) is expected
    assert str(error) == text


def test_every_error_round_trips_as_text() -> None:
    def all_errors(root: type[errors.PPaaSError]) -> list[type[errors.PPaaSError]]:
        return [root, *(found for child in root.__subclasses__() for found in all_errors(child))]

    for kind in all_errors(errors.PPaaSError):
        if kind.__module__ == errors.__name__ and "slug" in vars(kind):
            error = error_of_text(f"{kind.slug}: what: is\nwrong")
            assert (type(error), str(error)) == (kind, "what: is\nwrong")


def test_text_without_a_slug_is_kept_whole() -> None:
    error = error_of_text("robot: it fell over", errors.Unavailable)
    assert (type(error), str(error)) == (errors.Unavailable, "robot: it fell over")


def test_faults_of_zones_and_of_robot_files_are_read_and_other_members_do_no_harm() -> None:
    robot = errors.InvalidRobot([errors.RobotFault("model", "unknown"), errors.RobotFault("", "too tall")])
    zones = errors.InvalidZones("a crosses itself", [errors.ZoneFault("a", "crosses itself", (1.0, 2.0))])
    for sent in (robot, zones):
        faults = [fault._asdict() for fault in sent.faults]
        read = error_of_status(422, problem(type=f"urn:ppaas:problem:{sent.slug}", detail=str(sent), faults=faults))
        assert isinstance(read, type(sent)) and (str(read), read.faults) == (str(sent), sent.faults)
    busy = problem(type="urn:ppaas:problem:conflict", detail="busy", faults=[{"code": 7}])
    assert str(error_of_status(409, busy)) == "busy"
