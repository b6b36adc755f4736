"""Errors of the driver, with advice."""

import pytest
from cassandra import InvalidRequest, OperationTimedOut, ReadFailure
from cassandra.cluster import NoHostAvailable

from ppaas.errors import Unavailable
from storage.cassandra.connection.errors import driver_errors, is_silence


def advice(error: Exception) -> str:
    with pytest.raises(Unavailable) as caught, driver_errors("db"):
        raise error
    return str(caught.value)


def test_too_many_deleted_rows_come_with_what_to_do() -> None:
    told = advice(ReadFailure("failed", error_code_map={"127.0.0.1": 1}))
    assert "deleted rows" in told
    assert "nodetool compact" in told
    for code in ({"127.0.0.1": 0}, None):
        assert "compact" not in advice(ReadFailure("failed", error_code_map=code))


def test_only_errors_without_a_response_are_silence() -> None:
    assert is_silence(NoHostAvailable("none", {}))
    assert is_silence(OperationTimedOut())
    assert not is_silence(InvalidRequest("no such table"))
    assert not is_silence(ReadFailure("failed"))
    assert not is_silence(None)
