import numpy as np
import pytest

from benchmarks.mapping.parts import pairs
from benchmarks.mapping.parts.lifelong import mapped as mapped_hours
from benchmarks.mapping.parts.lifelong import rows
from benchmarks.mapping.parts.merging import DriveLog, figures_of, halves
from benchmarks.mapping.parts.merging import row as merged_row
from ppaas.mapping.serialization.mapping_file import pack_mapping
from tests.support.world.merge_drives import first_drive, first_mapping, second_mapping
from tests.support.world.ring_drive import ring_drive

REFUSED = {"halves": "a", "merged": False, "cpu_s": 3.0, "why": "too few places"}


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder, drive = tmp_path_factory.mktemp("maps"), first_drive()
    # The true poses stand in for those of the whole drive, which is not mapped.
    (folder / "ring.posegraph").write_bytes(b"".join(pack_mapping(first_mapping())))
    np.save(folder / "ring.npy", drive.true)
    return halves(DriveLog("ring", drive.log, drive.true), folder)


def test_halves_of_a_drive_are_merged_and_compared(result):
    assert result["merged"]
    assert result["against_truth"]["mean_m"] < 0.02
    found = {figure.name: figure for figure in figures_of(result)}
    assert found["halves of ring: time"].limit == 5.0
    assert merged_row(result)["against truth m"].startswith("0.0")


def test_a_refused_merge_misses_its_bar_with_the_reason():
    (figure,) = figures_of(REFUSED)
    assert figure.kept is False and figure.note == "too few places"
    assert merged_row(REFUSED)["refused"] == "too few places"


def test_maps_of_one_place_would_count_as_falsely_merged():
    maps = {"a": first_mapping(), "b": second_mapping()}
    found = pairs.tried("a", "b", maps)
    assert found["merged"] and not found["why"]
    assert pairs.row(found)["merged"] == "yes"


def test_each_hour_is_measured() -> None:
    first, second = mapped_hours(ring_drive(), 50.0)
    assert (first["hour"], second["hour"]) == (1, 2)
    assert 0 < first["key_frames"] < second["key_frames"]
    assert 0.0 < first["log_mb"] < second["log_mb"]
    assert max(first["error_m"], second["error_m"]) < 0.1


def test_growth_is_that_since_the_hour_before() -> None:
    hour = {"memory_mb": 200.0, "key_frames": 10, "edges": 9, "log_mb": 0.1, "error_m": 0.01, "cpu_s": 1.0}
    table = rows([{"hour": 1, **hour}, {"hour": 2, **hour, "memory_mb": 201.5}])
    assert [row["growth MB"] for row in table] == ["+0.0", "+1.5"]
    assert table[1]["memory MB"] == "201.5"
