"""Files of pose graphs, by any name, in any encoding, compressed or not."""

import bz2
import gzip
from pathlib import Path

import pytest

from ppaas.errors import InvalidGraph, InvalidInput
from robots.cli.verbs.slam_graph import is_graph, solve_file

LINES = """# a chain
VERTEX2 0 0 0 0
VERTEX2 1 0.5 0 0
EDGE2 0 1 1 0 0 100 0 100 400 0 0
"""
LOG = LINES + "ROBOTLASER1 0 -1.57 3.14 0.0174 80 0.1 0 1 2.0 0 0 0 0 0 0 0 0 0 0 0 0 host 0\n"


@pytest.mark.parametrize("name", ["a.g2o", "A.G2O", "a.graph", "a.toro", "a.txt", "a"])
def test_graphs_are_known_by_their_names_or_their_lines(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(LINES)
    assert is_graph(path)
    assert solve_file(path).answer["nodes"] == 2
    path.write_text(LOG)
    assert is_graph(path) == (path.suffix.lower() == ".g2o"), "a map is made of a graph with scans"


@pytest.mark.parametrize("name", ["a.bag", "missing.txt", "folder", "a.log"])
def test_other_files_are_no_graphs(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.bag").write_text(LINES)
    (tmp_path / "folder").mkdir()
    (tmp_path / "a.log").write_bytes(bytes(range(256)) * 20)
    assert not is_graph(tmp_path / name)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be"])
def test_graphs_are_read_in_encodings_of_windows(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "a.g2o"
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    path.write_bytes((mark + LINES.replace("\n", "\r\n")).encode(encoding))
    assert solve_file(path).answer["edges"] == 1


def test_compressed_graphs_are_read_and_one_that_is_cut_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o.gz"
    path.write_bytes(gzip.compress(LINES.encode()))
    assert is_graph(path)
    assert b"VERTEX_SE2 1 1.0" in solve_file(path).content
    path.write_bytes(gzip.compress(LINES.encode())[:-8])
    with pytest.raises(InvalidInput, match="its compressed content ends early"):
        solve_file(path)
    other = tmp_path / "b.toro.bz2"
    other.write_bytes(bz2.compress(LINES.encode()))
    assert is_graph(other)


def test_a_fixed_landmark_is_named_as_what_it_is_not(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(f"{LINES}VERTEX_XY 7 1 1\nFIX 7\n")
    assert "line 6: FIX names vertex 7, which no VERTEX_SE2 defines" in solve_file(path).notes


def test_a_graph_without_vertices_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text("")
    with pytest.raises(InvalidGraph, match="no VERTEX_SE2"):
        solve_file(path)
