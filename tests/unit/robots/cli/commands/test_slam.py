"""``ppaas slam``: maps of logs, their files and their scores."""

import bz2
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidGraph, InvalidInput, InvalidParameter
from ppaas.mapping.graph.g2o import parse_g2o
from ppaas.mapping.relations import parse_trajectory
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from robots.cli.command_parser import CommandParser
from robots.cli.commands import slam
from robots.client.map_files import read_map_file
from robots.recordings.scan_logs import FORMATS
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


def test_the_command_offers_all_formats() -> None:
    assert slam.FORMATS == FORMATS


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
    once, again = (parse_g2o((tmp_path / name).read_text().splitlines()) for name in ("out.g2o", "again.g2o"))
    np.testing.assert_allclose(again.edges.measurements, once.edges.measurements)
    run(tmp_path / "out.g2o")
    assert capsys.readouterr().out.split()[:3] == ["nodes", "edges", "chi2"]


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
        (("missing.log",), "cannot read the log"),
        (("missing.log", "--map", "out.png"), r"use out\.yaml"),
        (("missing.log", "--map", "nowhere/out.yaml"), "no folder nowhere"),
        (("missing.log", "--plot", "out.jpg"), r"use out\.png"),
        (("missing.log", "--graph", "out.txt"), r"use out\.g2o"),
        (("missing.log", "--posegraph", "out.txt"), r"a file out\.posegraph"),
        (("missing.g2o",), "cannot read the graph"),
    ],
)
def test_what_cannot_be_done_is_refused_before_the_work(words: tuple[str, ...], error: str) -> None:
    with pytest.raises(InvalidInput, match=error):
        run(*words)
