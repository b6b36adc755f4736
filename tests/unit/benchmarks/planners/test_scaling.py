"""The spread of a scaling bench compares grids from 512² on."""

from rich.progress import Progress

from benchmarks.planners import scaling


def test_the_spread_is_the_ratio_of_times_of_large_grids() -> None:
    with Progress(disable=True) as progress:
        result = scaling.measure(["empty"], [64, 512, 600], [1], progress)
    _, first, second = result["ns_per_cell"]["empty"]["1"]
    assert result["spread"]["empty"]["1"] == max(first, second) / min(first, second)
