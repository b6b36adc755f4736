#!/usr/bin/env bash
# WITH xacro 2.1.1 from PyPI, CPython 3.11 or newer
# EXPECTED a file with $(find PACKAGE) is expanded, or is refused with the name of the package that is not found: the wheel
#   requires pyyaml alone, and $(find …) is in the documentation of xacro.
# SEEN it fails with No module named 'ament_index_python', a package that comes with ROS 2 and is not required by the
#   wheel. Neither ROS_PACKAGE_PATH nor AMENT_PREFIX_PATH is looked at. Files without $(find …) are expanded.
# HERE robots/client/xacro_files.py gives xacro a function that finds packages in folders.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q xacro==2.1.1; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

mkdir -p "$folder/share/cart/urdf"
echo '<package><name>cart</name></package>' >"$folder/share/cart/package.xml"
head='<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cart">'
echo "$head<link name=\"wheel\"/></robot>" >"$folder/share/cart/urdf/wheel.xacro"
echo "$head<xacro:include filename=\"wheel.xacro\"/></robot>" >"$folder/share/cart/urdf/near.xacro"
echo "$head<xacro:include filename=\"\$(find cart)/urdf/wheel.xacro\"/></robot>" >"$folder/share/cart/urdf/found.xacro"

export ROS_PACKAGE_PATH="$folder/share" AMENT_PREFIX_PATH="$folder"
"$folder/venv/bin/python" -c 'import importlib.metadata as m; print("xacro", m.version("xacro"), "requires", m.requires("xacro"))'
status=0
"$folder/venv/bin/xacro" "$folder/share/cart/urdf/near.xacro" >"$folder/out" || status=1
echo "an include without find: exit status $status"
"$folder/venv/bin/xacro" "$folder/share/cart/urdf/found.xacro" >"$folder/out" 2>"$folder/err" && status=1
echo "an include with find: $(grep -m 1 . "$folder/err")"
grep -q "No module named 'ament_index_python'" "$folder/err" || status=1
exit "$status"
