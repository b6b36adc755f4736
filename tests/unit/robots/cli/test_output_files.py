"""Files that commands write, and the reason if they cannot."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from robots.cli.output_files import check_folder, write_file


def test_a_file_is_written_and_replaced(tmp_path: Path) -> None:
    file = tmp_path / "map.pgm"
    for content in (b"first", b"second"):
        check_folder(file)
        write_file(file, content)
        assert file.read_bytes() == content


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"there is no folder .*absent"):
        check_folder(tmp_path / "absent" / "map.pgm")


def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="cannot write the file"):
        write_file(tmp_path, b"")
