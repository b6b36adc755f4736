"""Files of other programs that are generated: small ones, or ones of about 10 MB."""

import io
import struct
from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.imports.more_samples import drawings, mower, packed_cloud, raster

Sample = tuple[str, bytes]
"""Name and content."""

PARAMETERS = """\
{robot}:
  controller_server:
    ros__parameters:
      controller_frequency: 20.0
      FollowPath:
        plugin: "dwb_core::DWBLocalPlanner"
        max_vel_x: 0.3
        min_vel_x: 0.0
        max_vel_theta: 1.0
        acc_lim_x: 2.5
        sim_time: 1.7
  amcl:
    ros__parameters:
      alpha1: 0.2
      max_particles: 2000
      laser_model_type: "likelihood_field"
"""

MAPPING = """\
slam_toolbox:
  ros__parameters:
    mode: mapping
    resolution: 0.05
    max_laser_range: 12.0
    minimum_travel_distance: 0.3
    do_loop_closing: true
"""


def samples(*, large: bool) -> list[Sample]:
    """Return one file of each kind.

    Parameters
    ----------
    large : bool
        Whether files have about 10 MB; parameter files have 2 MiB, the limit of their size.
    """
    robots, side, cells, points = (5_000, 110, 1_070, 830_000) if large else (1, 6, 200, 20_000)
    rooms, packed, pixels, corners = (1_900, 2_300_000, 7_800, 200_000) if large else (9, 20_000, 200, 200)
    return [
        ("nav2.yaml", "".join(PARAMETERS.format(robot=f"robot{each}") for each in range(robots)).encode()),
        ("slam.yaml", MAPPING.encode()),
        ("route.geojson", msgspec.json.encode(_route_graph(side))),
        ("plant.lif.json", msgspec.json.encode(_layout(side))),
        ("flat.json", msgspec.json.encode(_flat(cells))),
        ("mower.json", mower(corners)),
        *_clouds(points),
        ("hall.laz", packed_cloud(_hall(packed))),
        ("hall.tif", raster(pixels)),
        *drawings(rooms),
    ]


def _edges(side: int) -> Iterator[tuple[int, int]]:
    """Return the numbers of neighbours in a square of nodes, in both directions."""
    for node in range(side * side):
        if node % side < side - 1:
            yield from ((node, node + 1), (node + 1, node))
        if node < side * (side - 1):
            yield from ((node, node + side), (node + side, node))


def _place(node: int, side: int) -> list[float]:
    return [2.0 * (node % side), 2.0 * (node // side)]


def _route_graph(side: int) -> dict[str, object]:
    count = side * side
    nodes = [
        {
            "type": "Feature",
            "properties": {"id": node, "frame": "map"},
            "geometry": {"type": "Point", "coordinates": _place(node, side)},
        }
        for node in range(count)
    ]
    edges = [
        {
            "type": "Feature",
            "properties": {"id": count + number, "startid": start, "endid": end, "metadata": {"speed_limit": 80.0}},
            "geometry": {"type": "MultiLineString", "coordinates": [[_place(start, side), _place(end, side)]]},
        }
        for number, (start, end) in enumerate(_edges(side))
    ]
    return {"type": "FeatureCollection", "name": "graph", "features": [*nodes, *edges]}


def _layout(side: int) -> dict[str, object]:
    properties = [{"vehicleTypeId": "cart", "maxSpeed": 1.0, "rotationAllowed": True}]
    nodes = [
        {
            "nodeId": f"n{node}",
            "nodePosition": dict(zip("xy", _place(node, side), strict=True)),
            "vehicleTypeNodeProperties": [{"vehicleTypeId": "cart"}],
        }
        for node in range(side * side)
    ]
    edges = [
        {
            "edgeId": f"e{number}", "startNodeId": f"n{start}", "endNodeId": f"n{end}",
            "vehicleTypeEdgeProperties": properties,
        }
        for number, (start, end) in enumerate(_edges(side))
    ]  # fmt: skip
    about = {
        "projectIdentification": "bench", "creator": "bench", "exportTimestamp": "2026-11-30T00:00:00Z",
        "lifVersion": "1.0.0",
    }  # fmt: skip
    hall = {"layoutId": "hall", "layoutVersion": "1", "nodes": nodes, "edges": edges, "stations": []}
    return {"metaInformation": about, "layouts": [hall]}


def _flat(cells: int) -> dict[str, object]:
    """Return a map of Valetudo: a square floor with walls around it, whose pixels are listed one by one."""
    inside = [value for x in range(1, cells - 1) for y in range(1, cells - 1) for value in (x, y)]
    last = cells - 1
    around = [(x, y) for x in range(cells) for y in (0, last)] + [(x, y) for y in range(1, last) for x in (0, last)]
    layers = [
        {"type": "floor", "pixels": inside, "metaData": {"area": 0}, "__class": "MapLayer"},
        {"type": "wall", "pixels": [value for pair in around for value in pair], "metaData": {}, "__class": "MapLayer"},
    ]
    return {
        "__class": "ValetudoMap", "metaData": {"version": 2}, "pixelSize": 5,
        "size": {"x": 5 * cells, "y": 5 * cells}, "layers": layers, "entities": [],
    }  # fmt: skip


def _hall(count: int) -> NDArray[np.float32]:
    """Return points of a hall of 20 × 12 m [m]: floor and walls."""
    rng = np.random.default_rng(0)
    floor = np.column_stack((rng.uniform(0, 20, count // 2), rng.uniform(0, 12, count // 2), np.zeros(count // 2)))
    along = rng.uniform(0, 64, count - count // 2)
    corners = np.array([[0, 0], [20, 0], [20, 12], [0, 12], [0, 0]], float)
    starts = np.array([0.0, 20.0, 32.0, 52.0, 64.0])
    walls = np.column_stack([np.interp(along, starts, corners[:, axis]) for axis in (0, 1)])
    return np.concatenate((floor, np.column_stack((walls, rng.uniform(0, 2.5, len(along)))))).astype(np.float32)


def _clouds(count: int) -> list[Sample]:
    """Return the hall as clouds."""
    points = _hall(count)
    header = (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n"
    )
    begin = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n"
    )
    return [
        ("hall.pcd", header.encode() + points.tobytes()),
        ("hall.ply", begin.encode() + points.tobytes()),
        ("hall.xyz", _text(points)),
        ("hall.las", _las(points)),
    ]


def _text(points: NDArray[np.float32]) -> bytes:
    written = io.BytesIO()
    np.savetxt(written, points[::2], fmt="%.4f")
    return written.getvalue()


def _las(points: NDArray[np.float32]) -> bytes:
    """Return a file of LAS 1.2 with records of format 0, in millimetres."""
    low, high = points.min(axis=0).astype(float), points.max(axis=0).astype(float)
    header = struct.pack(
        "<4sHHIHH8sBB32s32sHHHIIBHI5I12d",
        b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"bench", b"bench", 1, 2026, 227, 227, 0, 0, 20, len(points), 0, 0, 0, 0, 0,
        0.001, 0.001, 0.001, 0.0, 0.0, 0.0, high[0], low[0], high[1], low[1], high[2], low[2],
    )  # fmt: skip
    kind = np.dtype([("place", "<i4", 3), ("rest", "u1", 8)])
    records = np.zeros(len(points), kind)
    records["place"] = np.round(points * 1000.0)
    return header + records.tobytes()
