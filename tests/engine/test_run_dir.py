import socket
import stat
import tempfile

import pytest

from engine.run_dir import LONGEST_NAME, LONGEST_PATH, make_run_dir
from ppaas.errors import InvalidInput

MADE = len("/ppaas-12345678/")


def test_it_belongs_to_this_user_alone(short_path):
    folder = make_run_dir()
    assert folder.parent == short_path
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize("spare", [0, -1])
def test_a_socket_of_the_longest_name_can_be_bound_or_it_says_why_not(short_path, monkeypatch, spare):
    room = LONGEST_PATH - LONGEST_NAME - MADE - len(bytes(short_path)) - 1
    parent = short_path / ("a" * (room - spare))
    parent.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(parent))
    if spare < 0:
        with pytest.raises(InvalidInput, match="set TMPDIR to a shorter one"):
            make_run_dir()
        assert not list(parent.iterdir())
    else:
        with socket.socket(socket.AF_UNIX) as bound:
            bound.bind(str(make_run_dir() / ("s" * LONGEST_NAME)))
