from pathlib import Path

from tests.support.ros2 import build_messages


def test_paths_are_mended_without_a_write_into_the_cache_that_files_are_linked_to(tmp_path: Path, monkeypatch) -> None:
    cached, environment = tmp_path / "cached.cmake", tmp_path / "kilted"
    (environment / "share").mkdir(parents=True)
    text = 'INCLUDES "{};{}/site-packages/numpy/_core/include"'
    cached.write_text(text.format("/opt/python/cp311-cp311/include/python3.11", "/other/kilted/lib/python3.11"))
    before = cached.read_text()
    linked = environment / "share" / "export.cmake"
    linked.hardlink_to(cached)
    monkeypatch.setattr(build_messages, "includes_of", lambda _: ("/py/include", "/here/numpy/_core/include"))
    build_messages.mend_paths(environment)
    assert linked.read_text() == 'INCLUDES "/py/include;/here/numpy/_core/include"'
    assert cached.read_text() == before
