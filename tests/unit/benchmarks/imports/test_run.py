"""Bench of the imports: kinds, samples, reports and drives."""

import re

import pytest

from benchmarks.imports import drives
from benchmarks.imports.kinds import KINDS
from benchmarks.imports.run import ImportsReport, TriedFile, try_file
from benchmarks.imports.samples import samples
from ppaas.maps.generate import office

SAMPLES = dict(samples(large=False))


@pytest.mark.parametrize("name", SAMPLES)
def test_a_sample_is_known_and_imported(name: str) -> None:
    tried = try_file(name, SAMPLES[name], drives=False)
    assert (tried.error, tried.refused, tried.drove) == ("", 0, "")
    assert tried.taken + tried.translated > 0
    assert tried.seconds > 0.0
    assert (tried.bare > 0.0) == (not name.endswith((".pcd", ".ply", ".xyz")))


def test_each_kind_of_sample_is_another_one() -> None:
    kinds = [next(kind.name for kind in KINDS if kind.knows(name, content)) for name, content in SAMPLES.items()]
    households, clouds, drawn = ["map"] * 2, ["cloud or raster"] * 3 + ["cloud"] * 2, ["raster", *["floor plan"] * 2]
    assert kinds == ["Nav2", "slam_toolbox", "graph", "graph", *households, *clouds, *drawn]


def test_files_with_several_programs_and_launch_files_have_a_kind() -> None:
    both = b"slam_toolbox:\n  ros__parameters: {resolution: 0.05}\namcl:\n  ros__parameters: {min_particles: 90}\n"
    launch = (
        b"<launch><node pkg='amcl' type='amcl' name='amcl'><param name='min_particles' value='90'/></node></launch>"
    )
    kinds = [try_file("nav.yaml", both, drives=False), try_file("amcl.launch", launch, drives=False)]
    assert [(each.kind, each.error, each.taken) for each in kinds] == [("Nav2", "", 1), ("ROS 1 launch file", "", 1)]


@pytest.mark.parametrize("more", [b"", b"name: web\nversion: 3\n"])
def test_a_file_of_which_nothing_is_taken_is_no_import(more: bytes) -> None:
    tried = try_file("compose.yaml", b"services: {web: {image: nginx}}\n" + more, drives=True)
    assert (tried.error, tried.drove, tried.good) == ("no: nothing was taken", "", False)


def test_a_robot_drives_a_part_of_a_lane_that_is_very_long() -> None:
    lanes = re.sub(rb"([1-9]\d*)\.0([,\]])", rb"\g<1>00.0\2", SAMPLES["route.geojson"])
    assert try_file("route.geojson", lanes, drives=True).drove.startswith("drove 30")


def test_a_robot_drives_along_imported_lanes() -> None:
    assert try_file("route.geojson", SAMPLES["route.geojson"], drives=True).drove.startswith("drove ")


def test_a_robot_that_cannot_drive_is_reported() -> None:
    stuck = {"map": "office", "parameters": {"global_costmap": {"robot_radius": 2.5}}}
    assert drives.drive(stuck, office(0)).startswith("no: ")


def test_a_file_of_no_kind_and_one_that_cannot_be_read_are_no_imports() -> None:
    assert try_file("notes.txt", b"hello", drives=True).error == "no: of no known kind"
    assert try_file("nav2.yaml", b"ros__parameters: [1", drives=True).error.startswith("no: invalid-parameter: ")


def test_a_report_passes_with_95_percent_of_the_files() -> None:
    good = [TriedFile("a", "map", 1, drove="drove 5.0 m in 9 s")] * 19
    assert ImportsReport([*good, TriedFile("b", "map", 1, drove="no: stuck")]).passed
    assert not ImportsReport([*good, *[TriedFile("b", "map", 1, error="no: damaged")] * 2]).passed
    report = ImportsReport(good[:1])
    assert report.rows()[0]["then"] == "drove 5.0 m in 9 s"
    assert report.sentences() == ["1 of 1 files were imported, and robots drove by them where they could"]
