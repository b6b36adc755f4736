"""Differences of archives and images are named by their members."""

import hashlib
import io
import json
import tarfile
import zipfile
from pathlib import Path
from typing import Any

import pytest

from deploy.release.comparison import ImageArchive, folder_differences, image_differences

Files = dict[str, bytes]


def tar(files: Files, *, time: int = 0, mode: int = 0o644, form: str = "w") -> bytes:
    written = io.BytesIO()
    with tarfile.open(fileobj=written, mode=form) as archive:  # type: ignore[call-overload]
        for name, content in files.items():
            info = tarfile.TarInfo(name)
            info.size, info.mtime, info.mode = len(content), time, mode
            archive.addfile(info, io.BytesIO(content))
    return written.getvalue()


def wheel(files: Files, *, year: int = 2020) -> bytes:
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w") as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, (year, 1, 1, 0, 0, 0)), content)
    return written.getvalue()


def image(layers: list[bytes], **config: Any) -> bytes:
    """Return an image of these layers, in the layout of OCI."""
    blobs: Files = {}

    def blob(content: bytes) -> dict[str, str]:
        digest = hashlib.sha256(content).hexdigest()
        blobs[f"blobs/sha256/{digest}"] = content
        return {"digest": f"sha256:{digest}"}

    history = [{"created_by": f"RUN step {number}"} for number in range(len(layers))]
    settings = blob(json.dumps({"history": history, **config}).encode())
    manifest = blob(json.dumps({"config": settings, "layers": [blob(layer) for layer in layers]}).encode())
    index = json.dumps({"manifests": [manifest]}).encode()
    return tar({**blobs, "index.json": index})


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Return two empty folders."""
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
    return tmp_path / "one", tmp_path / "other"


def found(folders: tuple[Path, Path], name: str, one: bytes, other: bytes) -> list[str]:
    for folder, content in zip(folders, (one, other), strict=True):
        (folder / name).write_bytes(content)
    return list(folder_differences(*folders))


def test_equal_files_do_not_differ(folders: tuple[Path, Path]) -> None:
    assert found(folders, "a.whl", wheel({"m.py": b""}), wheel({"m.py": b""})) == []


def test_a_file_of_one_folder_is_named(folders: tuple[Path, Path]) -> None:
    (folders[1] / "a.whl").write_bytes(b"")
    assert list(folder_differences(*folders)) == ["a.whl: in the second folder only"]


@pytest.mark.parametrize(
    ("one", "other", "differences"),
    [
        (wheel({"m.py": b"1"}), wheel({"m.py": b"2"}), ["  m.py: content"]),
        (wheel({"m.py": b""}), wheel({"m.py": b""}, year=2021), ["  m.py: time"]),
        (tar({"a": b"", "b": b""}), tar({"b": b"", "a": b""}), ["  the order of the members"]),
        (tar({"a": b""}), tar({"a": b""}, time=9, mode=0o600), ["  a: mode, time"]),
        (tar({"a": b""}), tar({"b": b""}), ["  a: in the first only", "  b: in the second only"]),
    ],
)
def test_members_that_differ_are_named(
    folders: tuple[Path, Path], one: bytes, other: bytes, differences: list[str]
) -> None:
    assert found(folders, "a", one, other) == [f"a: {len(differences)} members differ", *differences]


def test_other_compression_of_the_same_members_is_a_difference(folders: tuple[Path, Path]) -> None:
    assert found(folders, "a", tar({"a": b""}), tar({"a": b""}, form="w:xz")) == ["a: other bytes of the same members"]


def test_many_differences_are_counted(folders: tuple[Path, Path]) -> None:
    names = [f"m{number}" for number in range(25)]
    lines = found(folders, "a", tar(dict.fromkeys(names, b"1")), tar(dict.fromkeys(names, b"2")))
    assert (lines[0], len(lines), lines[-1]) == ("a: 25 members differ", 22, "  and 5 others")


def images(folder: Path, one: bytes, other: bytes) -> list[str]:
    for name, content in (("one", one), ("other", other)):
        (folder / name).write_bytes(content)
    return list(image_differences(folder / "one", folder / "other"))


def test_equal_images_do_not_differ(tmp_path: Path) -> None:
    assert images(tmp_path, image([tar({"a": b""})]), image([tar({"a": b""})])) == []


def test_a_layer_that_differs_is_named_with_its_instruction_and_members(tmp_path: Path) -> None:
    same = tar({"a": b""})
    one, other = (image([same, tar({"b": content}, form="w:gz")]) for content in (b"1", b"2"))
    assert images(tmp_path, one, other) == ["layer 2, RUN step 1: 1 members differ", "  b: content"]


def test_settings_that_differ_are_named(tmp_path: Path) -> None:
    one, other = (image([], created=time) for time in ("2020", "2021"))
    assert images(tmp_path, one, other) == ["configuration: created"]


def test_an_image_of_more_layers_differs(tmp_path: Path) -> None:
    assert "1 and 2 layers" in images(tmp_path, image([tar({})]), image([tar({}), tar({})]))


def test_the_digest_is_the_one_of_the_manifest(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(image([tar({"a": b""})]))
    with ImageArchive(tmp_path / "a") as archive:
        [layer] = archive.layers
        assert archive.digest != layer
        assert list(archive.members(layer)) == ["a"]
