"""evo reads the trajectories that are written here, finds the same errors, and writes some that are read here.

``make test-clients`` installs evo, whose licence keeps it out of the environment of the project.
"""

import asyncio
import json
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ppaas.mapping.relations import score_by_truth
from ppaas.mapping.trajectories import TrajectoryFormat, format_trajectory, parse_trajectory
from tests.support.sources import ROOT

pytestmark = pytest.mark.clients

EVO = ROOT / "build" / "clients" / "evo"
SCRIPT = ROOT / "tests" / "support" / "clients" / "evo_compares.py"


async def compared(*words: object) -> dict[str, Any]:
    """Return what evo prints."""
    if not EVO.exists():
        pytest.skip("evo is not installed: run make test-clients")
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(SCRIPT), *map(str, words), stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(EVO)},
    )  # fmt: skip
    out, errors = await process.communicate()
    assert process.returncode == 0, errors.decode()
    found: dict[str, Any] = json.loads(out)
    return found


@pytest.mark.parametrize("form", ["tum", "kitti"])
async def test_evo_finds_the_same_errors_in_our_trajectories(form: TrajectoryFormat, tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    turns = np.cumsum(random.normal(0.0, 0.05, 400))
    true = np.column_stack((np.cumsum(0.1 * np.cos(turns)), np.cumsum(0.1 * np.sin(turns)), turns))
    true[:, 2] = np.arctan2(np.sin(true[:, 2]), np.cos(true[:, 2]))
    found = true + random.normal(0.0, 0.02, true.shape)
    stamps = 1_700_000_000.0 + np.arange(400) / 10.0
    files = {name: tmp_path / f"{name}.{form}" for name in ("truth", "found", "out")}
    order = slice(None, None, -1 if form == "tum" else 1)  # stamps of TUM ascend, whatever the order of the log is
    files["truth"].write_text(format_trajectory(stamps, true, form))
    files["found"].write_text(format_trajectory(stamps[order], found[order], form))
    answer = await compared(files["truth"], files["found"], form, files["out"])
    assert (answer["poses"], answer["valid"]) == (400, True), answer["details"]
    ours = score_by_truth(*(parse_trajectory(files[name].read_text()) for name in ("truth", "found"))).summary()
    assert (answer["rmse"], answer["mean"]) == pytest.approx((ours["rmse_m"], ours["mean_m"]), abs=1e-5)
    again = parse_trajectory(files["out"].read_text())
    np.testing.assert_allclose(again.poses, found, atol=1e-5)
