"""Records that an older release wrote can be read."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import Unavailable
from storage.encoding import decode, decode_readable, encode, encode_plain, is_intact
from storage.records import Limits, RobotRecord, User


class RobotBefore(msgspec.Struct):
    """A robot as an older release stored it, without description and properties."""

    id: str
    user: str
    map: str
    model: str = "turtlebot2"
    initial_pose: tuple[float, float, float] = (1.0, 2.0, 0.5)
    cores: float = 0.25
    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    parameters: dict = {}


def test_a_robot_stored_before_properties_existed_is_read() -> None:
    kept = msgspec.msgpack.encode(RobotBefore("tb1", "ann", "house", parameters={"amcl": {"min_particles": 100}}))
    robot = decode(kept, RobotRecord)
    assert (robot.id, robot.cores, robot.parameters) == ("tb1", 0.25, {"amcl": {"min_particles": 100}})
    assert (robot.description, robot.properties) == ("", {})


class UserBefore(msgspec.Struct):
    """A user as an older release stored it, without limits."""

    id: str
    password_hash: str
    role: str = "user"


def test_limits_of_a_release_without_quotas_of_bytes_and_versions_are_read() -> None:
    stored = {"id": "ann", "password_hash": "$argon2id$", "role": "user", "limits": {"robots": 7}}
    assert decode(msgspec.msgpack.encode(stored), User).limits == Limits(robots=7)


def test_a_user_stored_before_limits_existed_has_no_limits() -> None:
    user = decode(msgspec.msgpack.encode(UserBefore("ann", "$argon2id$", "admin")), User)
    assert user == User("ann", "$argon2id$", "admin", Limits())


class Small(msgspec.Struct, frozen=True):
    """A record of one text."""

    text: str = ""


LARGE = msgspec.defstruct("Large", [(f"field{number}", int, number) for number in range(40)], frozen=True)
EDGE = msgspec.defstruct("Edge", [(f"f{number}", str, "ä") for number in range(15)], frozen=True)
RECORDS: list[msgspec.Struct] = [
    Small(),
    Small("x" * 300),
    EDGE(),
    LARGE(),
    User("ann", "$argon2id$"),
    RobotRecord("tb1", "ann", "house"),
]


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_a_record_is_read_with_and_without_its_checksum(record: msgspec.Struct) -> None:
    data = encode(record)
    assert decode(data, type(record)) == decode(encode_plain(record), type(record)) == record
    assert is_intact(data)
    assert msgspec.msgpack.decode(data, type=type(record)) == record, "a release that knows no checksums reads it"


@given(st.sampled_from(RECORDS), st.data())
def test_a_damaged_byte_never_makes_another_record(record: msgspec.Struct, data: st.DataObject) -> None:
    whole = encode(record)
    at = data.draw(st.integers(0, len(whole) - 1))
    byte = data.draw(st.integers(0, 255).filter(lambda byte: byte != whole[at]))
    damaged = whole[:at] + bytes((byte,)) + whole[at + 1 :]
    try:
        assert decode(damaged, type(record), "users/ann") == record
    except Unavailable as error:
        assert str(error).startswith("users/ann is damaged")
    cut = data.draw(st.integers(0, len(whole) - 1))
    with pytest.raises(Unavailable):
        decode(whole[:cut], type(record))


def test_a_text_that_is_not_unicode_is_damage() -> None:
    with pytest.raises(Unavailable, match="a stored Small is damaged"):
        decode(encode_plain(Small("abc")).replace(b"abc", b"a\xffc"), Small)


def test_damaged_records_are_left_out_of_lists(caplog: pytest.LogCaptureFixture) -> None:
    rows = [(encode(Small("a")), "t/a"), (b"", "t/b"), (b"\xc1", "t/c"), (encode(Small("d")), "t/d")]
    assert decode_readable(rows, Small) == [Small("a"), Small("d")]
    assert decode_readable(rows, Small, 1) == [Small("a")]
    assert "t/b is damaged" in caplog.text
