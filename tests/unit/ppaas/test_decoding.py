"""Values are decoded as their types, which one thread at a time describes."""

import threading
from concurrent.futures import ThreadPoolExecutor

import msgspec
import pytest

from ppaas import decoding
from ppaas.decoding import converted, describe, from_json, from_msgpack


class Inner(msgspec.Struct):
    numbers: list[int]


class Outer(msgspec.Struct):
    inner: Inner | None = None


VALUE = {"inner": {"numbers": [1, 2]}}
EXPECTED = Outer(Inner([1, 2]))


def test_values_are_decoded_as_their_type() -> None:
    assert from_json(b'{"inner": {"numbers": [1, 2]}}', Outer) == EXPECTED
    assert from_msgpack(msgspec.msgpack.encode(VALUE), Outer) == EXPECTED
    assert converted(VALUE, Outer) == EXPECTED
    assert from_json(b"null", Outer | None) is None
    assert converted({"numbers": ["1"]}, Inner, strict=False) == Inner([1])


def test_errors_are_those_of_msgspec() -> None:
    for decode in (lambda: from_json(b"{", Outer), lambda: from_msgpack(b"\x81", Outer)):
        with pytest.raises(msgspec.DecodeError):
            decode()
    with pytest.raises(msgspec.ValidationError, match="numbers"):
        converted({"inner": {"numbers": "many"}}, Outer)


def test_one_thread_at_a_time_describes_a_type(monkeypatch: pytest.MonkeyPatch) -> None:
    now, most = 0, 0
    counting = threading.Lock()

    class Slow:
        """Stands for the decoder whose constructor describes a type."""

        def __init__(self, _kind: object) -> None:
            nonlocal now, most
            with counting:
                now, most = now + 1, max(most, now + 1)
            threading.Event().wait(0.01)
            with counting:
                now -= 1

    monkeypatch.setattr(msgspec.json, "Decoder", Slow)
    monkeypatch.setattr(decoding, "_described", set())
    kinds = [list[Outer], dict[str, Outer], tuple[Inner, Outer], Outer | None]
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(describe, kinds))
    assert (most, decoding._described) == (1, set(kinds))
