"""Rules of the head of a request: its version, and its Host."""

import pytest

from endpoints.http.request_head import BadHead, check_head

HOST = (b"host", b"cloud:8500")


@pytest.mark.parametrize(
    ("version", "headers", "websocket", "status"),
    [
        ("1.1", [HOST], False, None),
        ("1.1", [(b"host", b"")], False, None),
        ("1.1", [(b"host", b"[::1]:8500 ")], False, None),
        ("1.1", [(b"host", b"my_robot.lab")], False, None),
        ("1.0", [], False, None),
        ("1.0", [HOST], False, None),
        ("1.1", [HOST], True, None),
        ("1.1", [], False, 400),
        ("1.1", [HOST, HOST], False, 400),
        ("1.0", [HOST, (b"host", b"other")], False, 400),
        ("1.1", [(b"host", b"a b")], False, 400),
        ("1.1", [(b"host", b"a/b")], False, 400),
        ("1.1", [(b"host", b"a@b")], False, 400),
        ("1.1", [(b"host", b"a\xff")], False, 400),
        ("1.0", [HOST], True, 400),
        ("0.9", [HOST], False, 505),
        ("2.0", [HOST], False, 505),
        ("1.1", [HOST, (b"content-length", b"5")], True, 400),
        ("1.1", [HOST, (b"transfer-encoding", b"chunked")], True, 400),
        ("1.1", [HOST, (b"content-length", b"0")], True, None),
    ],
)
def test_a_head_is_accepted_or_refused_with_a_status(
    version: str, headers: list[tuple[bytes, bytes]], websocket: bool, status: int | None
) -> None:
    if status is None:
        check_head(version, headers, websocket=websocket)
    else:
        with pytest.raises(BadHead) as refused:
            check_head(version, headers, websocket=websocket)
        assert refused.value.status == status
