import numpy as np
import pytest

from benchmarks.mapping.parts import pairs
from benchmarks.mapping.parts.merging import Drive, figures_of, halves, row as merged_row
from ppaas.mapping.serialization.mapping_file import pack_mapping
from tests.support.world.merge_drives import first_drive, first_mapping, second_mapping

REFUSED = {"halves": "a", "merged": False, "cpu_s": 3.0, "why": "too few places"}


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder, drive = tmp_path_factory.mktemp("maps"), first_drive()
    # The true poses stand in for those of the whole drive, which is not mapped.
    (folder / "ring.posegraph").write_bytes(b"".join(pack_mapping(first_mapping())))
    np.save(folder / "ring.npy", drive.true)
    return halves(Drive("ring", drive.log, drive.true), folder)


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
