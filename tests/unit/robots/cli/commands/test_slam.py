"""``ppaas slam``: maps of logs, their files and their scores."""

import bz2
import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidGraph, InvalidInput, InvalidParameter
from ppaas.mapping.graph.g2o import parse_g2o
from ppaas.mapping.graph.solver import Robust
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from ppaas.mapping.trajectories import TRAJECTORY_FORMATS, format_trajectory, parse_trajectory
from ppaas.maps.octomap import parse_octomap
from robots.cli.command_parser import CommandParser
from robots.cli.commands import slam
from robots.cli.verbs.slam_graph import is_graph, solve_file
from robots.client.map_files import read_map_file
from robots.recordings.scan_logs import FORMATS
from tests.support.recordings.bags import make_bag
from tests.support.recordings.sensor_bags import make_sensor_bag
from tests.support.world.log_text import carmen_log, relations_text
from tests.support.world.ring_drive import ring_drive

SCANS = 40


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "ring.clf.bz2"
    path.write_bytes(bz2.compress(carmen_log(ring_drive().first(SCANS)).encode()))
    return path


@pytest.fixture
def relations(tmp_path: Path) -> Path:
    path = tmp_path / "ring.relations"
    path.write_text(relations_text(ring_drive().first(SCANS), 10))
    return path


def run(*words: object) -> int:
    parser = CommandParser()
    slam.configure(parser)
    return slam.run(parser.parse_args(list(map(str, words))))


def test_the_command_offers_all_formats_and_methods() -> None:
    assert slam.FORMATS == FORMATS
    assert list(slam.METHODS) == [each.value for each in Robust]
    assert slam.TRAJECTORIES == TRAJECTORY_FORMATS


def test_map_trajectory_and_picture_are_written(tmp_path: Path, log: Path) -> None:
    out = tmp_path / "out.yaml"
    run(log, "--map", out, "--trajectory", tmp_path / "out.txt", "--plot", tmp_path / "out.png")
    grid = read_map_file(out)
    assert (grid.info.resolution, bool((grid.data == 100).any())) == (0.05, True)
    stamps, poses = parse_trajectory((tmp_path / "out.txt").read_text())
    np.testing.assert_allclose(stamps, ring_drive().log.stamps[:SCANS])
    assert poses.shape == (SCANS, 3)
    assert Image.open(tmp_path / "out.png").width > 100


def test_the_score_is_that_of_the_poses(log: Path, relations: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(log, "--score", relations, "--json")
    answer = json.loads(capsys.readouterr().out)
    assert answer["relations"] == SCANS - 10
    assert 0.0 < answer["mean_m"] < 0.02
    assert answer["scans"] == SCANS
    run(log, "--score", relations)
    heading, values = capsys.readouterr().out.splitlines()
    assert heading.split()[:2] == ["scans", "key_frames"]
    assert {"mean_m", "std_m", "max_m", "mean_deg"} <= set(heading.split())
    assert len(values.split()) == len(heading.split())


def test_a_trajectory_that_was_written_is_scored(
    tmp_path: Path, log: Path, relations: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(log, "--trajectory", tmp_path / "out.txt", "--score", relations, "--json")
    once = json.loads(capsys.readouterr().out)
    run("--trajectory", tmp_path / "out.txt", "--score", relations, "--json")
    again = json.loads(capsys.readouterr().out)
    assert again["mean_m"] == pytest.approx(once["mean_m"], abs=1e-5)


@pytest.mark.parametrize(
    ("name", "options", "columns"),
    [
        ("out.txt", (), 4), ("out.tum", (), 8), ("out.kitti", (), 12), ("out.txt", ("--trajectory-format", "tum"), 8),
        ("out.tum", ("--trajectory-format", "planar"), 4),
    ],
)  # fmt: skip
def test_a_trajectory_has_the_format_of_its_name_or_option(
    tmp_path: Path, log: Path, name: str, options: tuple[str, ...], columns: int
) -> None:
    run(log, "--trajectory", tmp_path / name, *options)
    assert {len(line.split()) for line in (tmp_path / name).read_text().splitlines()} == {columns}


def test_a_true_trajectory_of_tum_scores(tmp_path: Path, log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive = ring_drive()
    truth = tmp_path / "truth.txt"
    truth.write_text(format_trajectory(drive.log.stamps[:SCANS], drive.true[:SCANS], "tum"))
    run(log, "--trajectory", tmp_path / "out.tum", "--score", truth, "--json")
    once = json.loads(capsys.readouterr().out)
    assert (once["poses"], once["unmatched"]) == (SCANS, 0)
    assert 0.0 < once["rmse_m"] < 0.02
    run("--trajectory", tmp_path / "out.tum", "--score", truth, "--json")
    assert json.loads(capsys.readouterr().out)["rmse_m"] == pytest.approx(once["rmse_m"], abs=1e-5)
    run("--trajectory", tmp_path / "out.tum", "--score", truth)
    assert "poses" in capsys.readouterr().out.split()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--trajectory-format", "tum"), "give --trajectory too"),
        (("--graph", "out.dot"), "use out.g2o or out.graph"),
    ],
)
def test_outputs_that_cannot_be_are_refused_before_the_work(log: Path, words: tuple[str, ...], why: str) -> None:
    with pytest.raises(InvalidInput, match=why):
        run(log, *words)


def test_a_trajectory_without_stamps_is_not_compared_with_relations(tmp_path: Path, log: Path, relations: Path) -> None:
    run(log, "--trajectory", tmp_path / "out.kitti")
    with pytest.raises(InvalidInput, match="has no stamps"):
        run("--trajectory", tmp_path / "out.kitti", "--score", relations)
    with pytest.raises(InvalidInput, match="give a LOG"):
        run("--trajectory", tmp_path / "out.kitti", "--score", relations, "--trajectory-format", "tum")


def test_a_graph_of_toro_is_written_and_solved_again(
    tmp_path: Path, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(log, "--graph", tmp_path / "out.graph", "--json")
    frames = json.loads(capsys.readouterr().out)["key_frames"]
    run(tmp_path / "out.graph", "--graph", tmp_path / "again.toro", "--json")
    answer = json.loads(capsys.readouterr().out)
    assert (answer["nodes"], answer["edges"]) == (frames, frames - 1)
    tags = [line.split()[0] for line in (tmp_path / "again.toro").read_text().splitlines()]
    assert (tags.count("VERTEX2"), tags.count("EDGE2")) == (frames, frames - 1)


def test_parameters_have_an_effect(tmp_path: Path, log: Path) -> None:
    run(log, "--map", tmp_path / "out.yaml", "--parameter", "resolution=0.1")
    assert read_map_file(tmp_path / "out.yaml").info.resolution == 0.1
    with pytest.raises(InvalidParameter, match="resolution"):
        run(log, "--parameter", "resolutoin=0.1")


def test_the_pose_graph_is_written_and_solved_again(
    tmp_path: Path, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(log, "--graph", tmp_path / "out.g2o", "--json")
    frames = json.loads(capsys.readouterr().out)["key_frames"]
    run(tmp_path / "out.g2o", "--graph", tmp_path / "again.g2o", "--json")
    answer = json.loads(capsys.readouterr().out)
    assert (answer["nodes"], answer["edges"], answer["distrusted_edges"]) == (frames, frames - 1, 0)
    assert answer["chi2"] < 1e-3
    once, again = (parse_g2o((tmp_path / name).read_text().splitlines()).graph for name in ("out.g2o", "again.g2o"))
    np.testing.assert_allclose(again.edges.measurements, once.edges.measurements)
    run(tmp_path / "out.g2o")
    assert capsys.readouterr().out.split()[:3] == ["nodes", "edges", "fixed"]


def solved(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, *words: str) -> tuple[dict, str, list[str]]:
    """Solve a graph; return the answer, the notes, and the lines of the solution."""
    (tmp_path / "graph.g2o").write_text(text, encoding="utf-8")
    run(tmp_path / "graph.g2o", "--graph", tmp_path / "solved.g2o", "--json", *words)
    out, notes = capsys.readouterr()
    return json.loads(out), notes, (tmp_path / "solved.g2o").read_text().splitlines()


CHAIN = """\ufeff# Straße
FIX 3 0
VERTEX_SE2 3 3.3 0 0
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1 0 0
EDGE_SE2 0 1 1 0 0 100 0 0 100 0 100
EDGE_SE2 1 3 2 0 0 50 0 0 50 0 50
"""


def test_fixed_vertices_keep_their_poses_and_stay_fixed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer, notes, lines = solved(tmp_path, capsys, CHAIN)
    assert (answer["fixed"], answer["distrusted_edges"], answer["left_out"], notes) == (2, 0, {}, "")
    vertices = [line.split()[1:3] for line in lines if line.startswith("VERTEX_SE2")]
    assert [vertex for vertex, _ in vertices] == ["3", "0", "1"]
    assert [float(x) for _, x in vertices] == pytest.approx([3.3, 0.0, 1.1])
    assert lines[-2:] == ["FIX 3", "FIX 0"]


def test_what_is_not_solved_is_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    others = "VERTEX_XY 7 1 1\nEDGE_SE2_XY 0 7 1 1 1 0 1\nEDGE_SE2_XY 1 7 0 1 1 0 1\nFIX 9\nVERTEX_SE2 20 5 5 0\n"
    answer, notes, _ = solved(tmp_path, capsys, CHAIN + others)
    assert answer["left_out"] == {"VERTEX_XY": 1, "EDGE_SE2_XY": 2}
    first, second, third, fourth = notes.splitlines()
    assert first.startswith("note: 1 line VERTEX_XY left out, the first is line 8: only poses in the plane")
    assert second.startswith("note: 2 lines EDGE_SE2_XY left out, the first is line 9: ")
    assert third == "note: line 11: FIX names vertex 9, which no VERTEX_SE2 defines"
    assert fourth.startswith("note: the graph has 2 parts that no edge connects")


def test_solution_that_distrusts_most_closures_is_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    closure = "EDGE_SE2 0 3 9 0 0 900 0 0 900 0 900\n"
    answer, notes, _ = solved(tmp_path, capsys, CHAIN.replace("FIX 3 0\n", "") + closure)
    assert answer["distrusted_edges"] == 1
    assert notes.startswith("note: 1 of 1 loop closures contradict the other edges and have little weight")
    answer, notes, lines = solved(tmp_path, capsys, CHAIN.replace("FIX 3 0\n", "") + closure, "--robust", "none")
    assert (answer["distrusted_edges"], answer["method"], notes) == (0, "none", "")
    assert float(lines[0].split()[2]) > 8.0


def test_an_interruption_is_reported_and_leaves_no_file(
    tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(slam, "_mapped", interrupt)
    with pytest.raises(KeyboardInterrupt):
        run(log, "--map", tmp_path / "out.yaml", "--posegraph", tmp_path / "out.posegraph")
    assert capsys.readouterr().err.startswith("ppaas: interrupted before all files were written")
    assert not list(tmp_path.glob("out*"))


def test_key_frames_are_written_with_their_pose_graph(tmp_path: Path, log: Path) -> None:
    run(log, "--posegraph", tmp_path / "out.posegraph")
    mapping = unpack_mapping((tmp_path / "out.posegraph").read_bytes())
    assert len(mapping.frames) == mapping.graph.node_count > 5


def test_a_graph_with_lies_is_refused_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "bad.g2o").write_text("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\n")
    with pytest.raises(InvalidGraph, match="2"):
        run(tmp_path / "bad.g2o")
    with pytest.raises(InvalidInput, match="without scans"):
        run(tmp_path / "bad.g2o", "--map", tmp_path / "out.yaml")


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ((), "give a LOG to map"),
        (("--score", "a.relations"), "give a LOG to map"),
        (("--score", "a.relations", "--trajectory", "a.txt", "--map", "a.yaml"), "need a LOG"),
        (("--score", "missing.relations", "--trajectory", "missing.txt"), "cannot read the file"),
        (("missing.log",), "cannot read missing.log: no such file"),
        (("missing.bag",), r"cannot read missing\.bag: no such file or directory$"),
        (("missing.log", "--map", "out.png"), r"use out\.yaml"),
        (("missing.log", "--map", "nowhere/out.yaml"), "no folder nowhere"),
        (("missing.log", "--plot", "out.jpg"), r"use out\.png"),
        (("missing.log", "--graph", "out.txt"), r"use out\.g2o"),
        (("missing.log", "--posegraph", "out.txt"), r"a file out\.posegraph"),
        (("missing.g2o",), "cannot read .*missing.g2o: no such file"),
    ],
)
def test_what_cannot_be_done_is_refused_before_the_work(words: tuple[str, ...], error: str) -> None:
    with pytest.raises(InvalidInput, match=error):
        run(*words)


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


@pytest.mark.parametrize("kind", ["rvl", "cloud"])
def test_an_octomap_is_made_of_a_bag_without_a_laser(tmp_path: Path, kind: str) -> None:
    bag, out = make_sensor_bag(tmp_path / "bag", kind, images=6), tmp_path / "out.bt"
    run(bag, "--octomap", out, "--octomap-parameter", "resolution=0.1", "--map", tmp_path / "out.yaml")
    tree = parse_octomap(out.read_bytes())
    corners = (tree.corners[tree.occupied].astype(float) - 32768) * 0.1
    on_walls = (np.abs(np.abs(corners[:, 0] + 0.05) - 4.0) < 0.2) | (np.abs(np.abs(corners[:, 1] + 0.05) - 3.0) < 0.2)
    assert on_walls.sum() > 100
    assert (on_walls | (corners[:, 2] < 0.2)).all()
    with pytest.raises(InvalidParameter, match="resolutoin"):
        run(bag, "--octomap", out, "--octomap-parameter", "resolutoin=0.1")


def test_an_octomap_of_a_log_is_refused(tmp_path: Path, log: Path) -> None:
    with pytest.raises(InvalidInput, match="is no bag"):
        run(log, "--octomap", tmp_path / "out.bt")
    with pytest.raises(InvalidInput, match=r"out.bt or .ot"):
        run(log, "--octomap", tmp_path / "out.xyz")
    bag = make_bag(tmp_path / "lasers", "mcap", scans=5)
    with pytest.raises(InvalidInput, match="no depth image and no point cloud"):
        run(bag, "--octomap", tmp_path / "out.ot")
