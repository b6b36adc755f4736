"""Packages that are installed into a folder, as a stranger's would be beside this project."""

import os
import subprocess
import sys
from pathlib import Path

from tests.support.sources import ROOT


def install(target: Path, *packages: Path) -> dict[str, str]:
    """Install packages into a folder of their own; return an environment in which Python finds them."""
    command = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--offline", "--no-cache", "--no-deps"]
    options = ["--no-build-isolation", "--python", sys.executable, "--target", str(target)]
    subprocess.run([*command, *options, *map(str, packages)], check=True, timeout=120)
    return os.environ | {"PYTHONPATH": os.pathsep.join((str(target), str(ROOT)))}
