"""Builds the packages of messages that ROS's wheels lack, with the generators of those wheels.

``python -m tests.support.ros2.build_messages RELEASE ENVIRONMENT WORKSPACE``, by the Python of this project: the
environment has the wheels of the release, and the workspace gets the packages. It needs CMake and a C++ compiler.
"""

import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from ppaas.wire.ros.definitions import DEFINITIONS
from ppaas.wire.ros.rmf_definitions import RMF

TF2 = {"tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms"}
USED = (
    *(
        f"nav2_msgs/msg/{name}"
        for name in ("Particle", "ParticleCloud", "Route", "RouteEdge", "RouteNode", "SpeedLimit")
    ),
    "nav2_msgs/msg/WaypointStatus",
    *(f"nav2_msgs/action/{name}" for name in ("ComputePathToPose", "ComputeRoute", "FollowPath", "FollowWaypoints")),
    "nav2_msgs/action/NavigateToPose",
    *(f"nav2_msgs/srv/{name}" for name in ("ClearEntireCostmap", "IsPathValid")),
)
"""Definitions of ``nav2_msgs`` that the robots of the tests use: each takes the compiler some seconds."""

PACKAGES = ("tf2_msgs", "nav2_msgs", "rmf_fleet_msgs")
DEPENDENCIES = ("builtin_interfaces", "std_msgs", "geometry_msgs", "nav_msgs", "action_msgs")

CMAKE = """cmake_minimum_required(VERSION 3.8)
project({package})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{found}
rosidl_generate_interfaces(${{PROJECT_NAME}} {files} DEPENDENCIES {dependencies})
ament_package()
"""

PACKAGE = """<package format="3"><name>{package}</name><version>0.0.0</version><description>For tests</description>
<maintainer email="tests@example.org">tests</maintainer><license>Apache-2.0</license>
<buildtool_depend>ament_cmake</buildtool_depend><buildtool_depend>rosidl_default_generators</buildtool_depend>
{depends}<member_of_group>rosidl_interface_packages</member_of_group>
<export><build_type>ament_cmake</build_type></export></package>
"""


def main(release: str, environment: Path, workspace: Path) -> None:
    """Build the packages."""
    mend_paths(environment)
    definitions = TF2 | {name: DEFINITIONS[release][name] for name in (*USED, *RMF)}
    for package in PACKAGES:
        source = workspace / "src" / package
        write(source, package, {name: text for name, text in definitions.items() if name.startswith(f"{package}/")})
        build(source, environment, workspace)


def mend_paths(environment: Path) -> None:
    """Replace the paths of the computer that built the wheels by paths of this environment.

    Installers link files to a cache that all environments of a computer share, so each file is replaced, not written
    to; and the path of an environment that wrote into the cache once is replaced too.
    """
    include, numpy = includes_of(environment)
    for file in (environment / "share").rglob("*.cmake"):
        text = file.read_text()
        mended = re.sub(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+", include, text)
        mended = re.sub(r'[^";]+/lib/python3\.\d+/site-packages/numpy/_core/include', numpy, mended)
        if mended != text:
            file.unlink()
            file.write_text(mended)


def includes_of(environment: Path) -> tuple[str, str]:
    """Return the folders of the C headers of an environment's Python and of its numpy."""
    python = environment / "bin" / "python"
    asked = "import numpy, sysconfig; print(sysconfig.get_paths()['include'], numpy.get_include())"
    include, numpy = subprocess.run([python, "-c", asked], check=True, capture_output=True, text=True).stdout.split()
    return include, numpy


def write(folder: Path, package: str, definitions: Mapping[str, str]) -> None:
    """Write the sources of a package."""
    files = []
    for name, text in definitions.items():
        _, kind, short = name.split("/")
        (folder / kind).mkdir(parents=True, exist_ok=True)
        file = folder / kind / f"{short}.{kind}"
        file.write_text("\n".join(line.strip() for line in text.strip().splitlines()) + "\n")
        files.append(f'"{kind}/{file.name}"')
    found = "\n".join(f"find_package({one} REQUIRED)" for one in DEPENDENCIES)
    words = {"package": package, "found": found, "files": " ".join(files), "dependencies": " ".join(DEPENDENCIES)}
    (folder / "CMakeLists.txt").write_text(CMAKE.format(**words))
    depends = "".join(f"<depend>{one}</depend>" for one in DEPENDENCIES)
    (folder / "package.xml").write_text(PACKAGE.format(package=package, depends=depends))


def build(source: Path, environment: Path, workspace: Path) -> None:
    """Configure, build and install a package."""
    folder = workspace / "build" / source.name
    env = os.environ | {
        "AMENT_PREFIX_PATH": f"{workspace}:{environment}",
        "CMAKE_PREFIX_PATH": f"{workspace}:{environment}",
        "LD_LIBRARY_PATH": f"{environment}/lib",
        "PATH": f"{environment}/bin:{os.environ['PATH']}",
        "CXXFLAGS": "-O0",
    }
    options = [f"-DCMAKE_INSTALL_PREFIX={workspace}", f"-DPython3_EXECUTABLE={environment}/bin/python"]
    commands: tuple[list[str | Path], ...] = (
        ["cmake", "-S", source, "-B", folder, *options],
        ["cmake", "--build", folder, "--parallel", "2"],
        ["cmake", "--install", folder],
    )
    for command in commands:
        done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
        if done.returncode:
            sys.exit(f"{' '.join(map(str, command))} failed:\n{(done.stdout + done.stderr)[-4000:]}")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]).absolute(), Path(sys.argv[3]).absolute())
