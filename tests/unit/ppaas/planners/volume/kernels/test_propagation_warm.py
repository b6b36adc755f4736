"""Reading, planning and collision checks need no kernels beyond those that ``warm`` compiles."""

import subprocess
import sys

from tests.support.sources import ROOT

PROGRAM = """
import itertools
from pathlib import Path

from engine.runtimes.compilation.kernel_modules import record_compilations
from ppaas.costmap.collision import collides_along
from ppaas.costmap.kernels import collision, voxels
from ppaas.costmap.volume import Box, Cylinder
from ppaas.costmap.voxels import VoxelCostmap, inflate_voxels
from ppaas.maps.kernels import octree
from ppaas.maps.octomap import binary_octomap, parse_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import VoxelGrid
from ppaas.planners.volume import PlanRequest3D, Pose3D, create
from ppaas.planners.volume.kernels import descent, propagation, setup

for module in (collision, voxels, octree, descent, propagation, setup):
    module.warm()
recorder = record_compilations()
text = Path("docs/examples/table.bt").read_bytes()
scene = parse_octomap(binary_octomap(octree_of(parse_octomap(text).voxels()))).voxels()
for writeable, ground in itertools.product((True, False), repeat=2):
    scene.data.flags.writeable = writeable
    costmap = inflate_voxels(VoxelGrid(scene.data, scene.info), Box(0.3, 0.2, 0.4), ground=ground, max_step=0.1)
    costmap.data.flags.writeable = writeable
    for name in ("astar3d", "dijkstra3d"):
        path = create(name).plan(costmap, PlanRequest3D(Pose3D(0.5, 1.5, 0.0), Pose3D(3.5, 1.5, 0.0)))
        assert collides_along(scene, Cylinder(0.15, 0.4), path.poses) is None
print(len(recorder.buffer))
"""


def test_no_kernel_is_compiled_after_warm():
    command = [sys.executable, "-c", PROGRAM]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=120)
    assert (ended.stdout, ended.stderr) == ("0\n", "")
