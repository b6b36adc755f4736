import json

import pytest

from robots.cli.output import cell, show

MAPS = [
    {"id": "house", "version": "0123456789abcdef", "origin": [-1.0, 2.0, 0.5], "readers": []},
    {"id": "a-longer-name", "version": None, "origin": [], "readers": ["ann", "*"]},
]


def test_columns_are_as_wide_as_their_widest_cell(capsys: pytest.CaptureFixture[str]) -> None:
    show(MAPS, ("id", "version", "origin", "readers"), as_json=False)
    assert capsys.readouterr().out.splitlines() == [
        "id             version       origin      readers",
        "house          0123456789ab  -1, 2, 0.5  -",
        "a-longer-name  -             -           ann, *",
    ]


def test_one_object_is_a_table_of_one_row(capsys: pytest.CaptureFixture[str]) -> None:
    container = {"id": "c1", "map": {"id": "house", "version": "v"}, "cores": 0.5, "pss": 3 << 20, "kind": "robot"}
    show(container, ("id", "map", "cores", "pss"), as_json=False)
    assert capsys.readouterr().out == "id  map    cores  pss\nc1  house  0.5    3.0 MiB\n"


def test_memory_is_shown_in_units(capsys: pytest.CaptureFixture[str]) -> None:
    show({"memory": 24 << 30, "memory_used": 512 << 20}, ("memory", "memory_used"), as_json=False)
    assert capsys.readouterr().out.splitlines()[1] == "24.0 GiB  512.0 MiB"


def test_an_empty_list_prints_a_sentence_or_an_empty_json_list(capsys: pytest.CaptureFixture[str]) -> None:
    show([], ("id",), as_json=False, if_none="no maps")
    show([], ("id",), as_json=True, if_none="no maps")
    assert capsys.readouterr().out == "no maps\n[]\n"


def test_json_contains_the_whole_answer(capsys: pytest.CaptureFixture[str]) -> None:
    show(MAPS, ("id",), as_json=True)
    assert json.loads(capsys.readouterr().out) == MAPS


def test_the_progress_of_kernels_is_a_count() -> None:
    assert cell("kernels", {"done": 12, "total": 107, "compiling": ["lattice/driving"]}) == "12 of 107"
    assert cell("kernels", None) == "-"
