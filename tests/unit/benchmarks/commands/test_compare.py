"""``ppaas bench compare``: JSON, table, and errors."""

import pytest

from benchmarks.planners import compare, peers
from robots.cli.main import main


def test_missing_and_unsuitable_peers_are_reported(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    field, path = peers.FIELDS[2], peers.PATHS[0]
    absent = peers.Peer("f", "absent-peer", "absent_peer", "nothing", field.prepare, field.told)
    small = peers.Peer(field.name, field.package, field.module, field.solves, field.prepare, field.told, 9)
    monkeypatch.setattr(compare, "BESIDE", {"absent-peer": absent, "scipy": small})
    monkeypatch.setattr(compare, "PATHS", ())
    assert main(["bench", "compare", "--empty", "8", "--threads", "1"]) == 0
    out, err = capsys.readouterr()
    assert "absent-peer f is left out: not installed" in err
    assert "scipy csgraph.dijkstra is left out: the grid is too large" in err
    assert "ppaas dijkstra, 1 thread" in out and path.package not in out


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["compare", "--empty", "3", "--only", "ours"], "not-found"),
    ],
)
def test_an_unknown_peer_is_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
