"""3D planners in planning.md are those of the code, and its program runs."""

import subprocess
import sys

from ppaas.maps.octomap import binary_octomap, parse_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import MAX_VOXELS
from ppaas.planners.volume import create as create_in_space, planner_names as names_in_space
from ppaas.planners.weights import RELATIVE_ERROR
from tests.support.documents import blocks, text_of
from tests.support.sources import ROOT

PAGE = "docs/planning.md"


def test_the_3d_planners_are_those_installed():
    for name in names_in_space():
        assert f"- **`{name}`**: {create_in_space(name).purpose}\n" in text_of(PAGE)


def test_the_numbers_are_those_of_the_code():
    assert f"more than {MAX_VOXELS} voxels" in text_of(PAGE)
    assert "by less than 0.02 %; `cost` is recounted" in " ".join(text_of(PAGE).split())
    assert 2 * RELATIVE_ERROR < 0.0002


def test_the_program_runs():
    [program] = [code for code in blocks(PAGE, "python") if "inflate_voxels" in code]
    command = [sys.executable, "-c", program]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_the_octomap_of_the_example_is_written_as_read():
    text = (ROOT / "docs" / "examples" / "table.bt").read_bytes()
    assert binary_octomap(octree_of(parse_octomap(text).voxels())) == text
