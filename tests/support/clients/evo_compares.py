"""Reads trajectories with evo, compares them, and writes them again.

python evo_compares.py TRUTH FOUND FORM OUT; FORM is tum or kitti. Prints the numbers of poses, what evo's own check
finds, and the errors of FOUND after it is aligned with TRUTH, as one line of JSON; writes FOUND to OUT.
"""

import json
import sys

from evo.core import metrics, sync
from evo.tools import file_interface as files

READ = {"tum": files.read_tum_trajectory_file, "kitti": files.read_kitti_poses_file}
WRITE = {"tum": files.write_tum_trajectory_file, "kitti": files.write_kitti_poses_file}


def main(truth: str, found: str, form: str, out: str) -> None:
    """Print what evo finds."""
    true, read = READ[form](truth), READ[form](found)
    valid, details = read.check()
    WRITE[form](out, read)
    if form == "tum":
        true, read = sync.associate_trajectories(true, read)
    read.align(true)
    error = metrics.APE(metrics.PoseRelation.translation_part)
    error.process_data((true, read))
    answer = {
        "poses": read.num_poses,
        "valid": bool(valid),
        "details": {name: str(text) for name, text in details.items()},
        "rmse": float(error.get_statistic(metrics.StatisticsType.rmse)),
        "mean": float(error.get_statistic(metrics.StatisticsType.mean)),
    }
    sys.stdout.write(json.dumps(answer) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
