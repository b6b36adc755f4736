"""The stamp of kernels depends on their content and their paths, and on nothing else."""

import os
from pathlib import Path

import pytest

from ppaas.kernel_cache.sources import kernel_files, stamp_of


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Return the folder of a package with two kernel modules, one of them in a folder below, and their decorators."""
    for name in ("one/kernels/a.py", "one/kernels/deep/b.py", "one/other.py", "kernel_cache/decorators.py"):
        file = tmp_path / "package" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
    return tmp_path / "package"


def test_files_of_kernels_are_found_in_order(root: Path) -> None:
    assert [file.name for file in kernel_files(root)] == ["decorators.py", "a.py", "b.py"]


def test_a_stamp_is_the_same_elsewhere_and_after_a_touch(root: Path, tmp_path: Path) -> None:
    stamp = stamp_of(root)
    (root / "one/other.py").write_text("changed")
    os.utime(root / "one/kernels/a.py", (1, 1))
    assert stamp_of(root) == stamp
    assert stamp_of(root.rename(tmp_path / "moved")) == stamp


def test_a_stamp_changes_with_content_and_name(root: Path) -> None:
    stamps = [stamp_of(root)]
    (root / "one/kernels/a.py").write_text("changed")
    stamps.append(stamp_of(root))
    (root / "one/kernels/a.py").rename(root / "one/kernels/c.py")
    stamps.append(stamp_of(root))
    (root / "kernel_cache/decorators.py").write_text("other options")
    stamps.append(stamp_of(root))
    assert len(set(stamps)) == 4
