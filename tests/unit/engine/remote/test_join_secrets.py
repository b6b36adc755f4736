"""Files of join secrets, the choice among them, and the count of wrong proofs."""

from pathlib import Path

import pytest

from engine.remote.authority import STANDBY
from engine.remote.join_secrets import (
    MAX_FILE,
    MOST_ADDRESSES,
    MOST_SECRETS,
    MOST_WRONG,
    SHORTEST,
    WRONG_PERIOD,
    JoinExchange,
    JoinSecret,
    JoinSecrets,
    WrongProofs,
    is_proof,
    proof_of_cloud,
    proof_of_machine,
    read_secrets,
)
from ppaas.clock import ManualClock
from ppaas.errors import InvalidInput, NotPermitted, TooManyAttempts, Unavailable

ONE, OTHER = "1" * SHORTEST, "2" * SHORTEST
EXCHANGE = JoinExchange("m2", b"request", b"asked", b"challenge", "ab" * 32)


def file_of(folder: Path, *lines: str, name: str = "secrets") -> Path:
    path = folder / name
    path.write_text("\n".join(lines))
    return path


def test_secrets_are_read_one_a_line_with_their_expiry(tmp_path: Path) -> None:
    file = file_of(tmp_path, "# of this year", f"  {ONE} until=1970-01-01T01:00:10+01:00 ", "", OTHER)
    assert read_secrets(file) == (JoinSecret(ONE, 10.0), JoinSecret(OTHER, None))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "has 0 join secrets"),
        ("# none", "has 0 join secrets"),
        (f"{ONE}\n" * (MOST_SECRETS + 1), f"has {MOST_SECRETS + 1} join secrets"),
        (ONE[1:], f":1: a join secret has {SHORTEST} to"),
        ("x" * 257, ":1: a join secret has"),
        (f"{OTHER}\n{ONE} until=soon", ":2: after a join secret only until=TIME"),
        (f"{ONE} until=2027-01-31T12:00:00", ":1: after a join secret only until=TIME"),
        (f"{ONE} {OTHER}", ":1: after a join secret only until=TIME"),
        (f"{ONE} until=2027-01-31T12:00:00Z {OTHER}", ":1: after a join secret only until=TIME"),
        ("ä" * SHORTEST, "not all of it is ASCII"),
        ("#" * (MAX_FILE + 1), "too large"),
    ],
)
def test_an_invalid_file_is_refused_without_its_secrets(tmp_path: Path, content: str, reason: str) -> None:
    with pytest.raises(InvalidInput, match=reason) as refused:
        read_secrets(file_of(tmp_path, content))
    assert ONE not in str(refused.value) and OTHER not in str(refused.value)


def test_a_missing_file_is_refused_at_the_start(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="cannot be read: No such file"):
        JoinSecrets(tmp_path / "none")


@pytest.mark.parametrize(
    "changed",
    [
        JoinExchange("m3", b"request", b"asked", b"challenge", "ab" * 32),
        JoinExchange("m2", b"other", b"asked", b"challenge", "ab" * 32),
        JoinExchange("m2", b"request", b"again", b"challenge", "ab" * 32),
        JoinExchange("m2", b"request", b"asked", b"another", "ab" * 32),
        JoinExchange("m2", b"request", b"asked", b"challenge", "cd" * 32),
    ],
)
def test_a_proof_is_for_its_exchange_and_its_end_alone(changed: JoinExchange) -> None:
    issued = b"certificate", b"authority"
    assert is_proof(proof_of_machine(ONE, EXCHANGE), proof_of_machine(ONE, EXCHANGE))
    assert not is_proof(proof_of_machine(ONE, changed), proof_of_machine(ONE, EXCHANGE))
    assert not is_proof(proof_of_machine(OTHER, EXCHANGE), proof_of_machine(ONE, EXCHANGE))
    assert not is_proof(proof_of_cloud(ONE, changed, issued), proof_of_cloud(ONE, EXCHANGE, issued))
    assert not is_proof(proof_of_cloud(ONE, EXCHANGE, (b"other", b"authority")), proof_of_cloud(ONE, EXCHANGE, issued))
    assert not is_proof(proof_of_machine(ONE, EXCHANGE), proof_of_cloud(ONE, EXCHANGE, issued))


def test_a_secret_is_replaced_while_the_cloud_runs(tmp_path: Path) -> None:
    file = file_of(tmp_path, ONE)
    known = JoinSecrets(file)
    assert known.proven("m2", ONE.__eq__) == ONE
    file_of(tmp_path, OTHER, ONE)
    assert (known.proven("m2", OTHER.__eq__), known.proven("m2", ONE.__eq__)) == (OTHER, ONE), "both for a while"
    file_of(tmp_path, OTHER)
    with pytest.raises(NotPermitted, match="unknown or was replaced"):
        known.proven("m2", ONE.__eq__)


def test_a_secret_expires(tmp_path: Path) -> None:
    clock = ManualClock(9.0)
    known = JoinSecrets(file_of(tmp_path, f"{ONE} until=1970-01-01T00:00:10Z"), clock=clock)
    assert known.proven("m2", ONE.__eq__) == ONE
    clock.advance(2.0)
    with pytest.raises(NotPermitted, match="has expired"):
        known.proven("m2", ONE.__eq__)


def test_a_secret_of_machines_makes_no_standby(tmp_path: Path) -> None:
    known = JoinSecrets(file_of(tmp_path, ONE), file_of(tmp_path, OTHER, name="standbys"))
    assert known.proven(f"b{STANDBY}", OTHER.__eq__) == OTHER
    with pytest.raises(NotPermitted, match="for machines only"):
        known.proven(f"b{STANDBY}", ONE.__eq__)
    with pytest.raises(NotPermitted, match="for standbys only"):
        known.proven("m2", OTHER.__eq__)


def test_without_files_no_secret_is_right() -> None:
    with pytest.raises(NotPermitted, match="unknown"):
        JoinSecrets().proven("m2", lambda _: True)


def test_a_file_that_disappears_is_reported_without_its_path(tmp_path: Path) -> None:
    known = JoinSecrets(file_of(tmp_path, ONE))
    (tmp_path / "secrets").unlink()
    with pytest.raises(Unavailable, match="cannot be read") as refused:
        known.proven("m2", ONE.__eq__)
    assert str(tmp_path) not in refused.value.public


def test_wrong_proofs_are_limited_by_address_for_a_time() -> None:
    clock = ManualClock()
    wrong = WrongProofs(clock)
    for _ in range(MOST_WRONG):
        wrong.check("192.0.2.1")
        wrong.note("192.0.2.1")
        clock.advance(1.0)
    with pytest.raises(TooManyAttempts, match=r"192\.0\.2\.1: try again in 50 s"):
        wrong.check("192.0.2.1")
    wrong.check("192.0.2.2")
    clock.advance(WRONG_PERIOD)
    wrong.check("192.0.2.1")


def test_the_number_of_counted_addresses_is_bounded() -> None:
    wrong = WrongProofs(ManualClock())
    for number in range(MOST_ADDRESSES + 10):
        wrong.note(str(number))
    assert len(wrong._times) == MOST_ADDRESSES
