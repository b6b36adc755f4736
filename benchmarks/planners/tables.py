"""Result tables of the planner benches: rows of text, by column."""

from collections.abc import Sequence
from typing import Any

from benchmarks.planners.timing import on_threads

Row = dict[str, str]

AIMS = {
    "empty": {"navfn": 35.0},
    "random 10 %": {"navfn": 20.0},
    "random 20 %": {"navfn": 13.0, "tcod": 60.0},
    "random 30 %": {"navfn": 8.0},
    "maze 1 wide": {"navfn": 1.5},
    "warehouse": {"navfn": 20.0},
    "depot": {"navfn": 20.0},
    "willow": {"navfn": 20.0},
}
"""Speed-up over other implementations to reach on two threads, by the beginning of a grid's name."""

SPREAD_AIM = 1.5
"""Largest ratio to reach between the times per cell of the slowest and the fastest grid size."""

ONE_THREAD = 0.55
"""Share of the speed-up on two threads that one thread is to reach."""


def field_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each number of threads."""
    return [
        {
            "grid": told["grid"],
            "reached": f"{told['reached']:,}",
            "threads": threads,
            "ms": _ms(seconds),
            "ns/cell": f"{told['ns_per_cell'][threads]:.2f}",
            "repeat, ms": _ms(told["again_seconds"][threads]),
            **({"after a pause, ms": _ms(told["paused_seconds"][threads])} if "paused_seconds" in told else {}),
            **_times_faster(told, seconds),
        }
        for threads, seconds in told["seconds"].items()
    ]


def beside_rows(told: dict[str, Any], others: Sequence[str]) -> list[Row]:
    """Return a row for each number of threads: speed-up over others, the aim, and the times of the others."""
    reached = told["reached"]
    times = {f"{name}, ns/cell": _ns(told["beside"].get(name), reached) for name in others}
    aims = next((aim for grid, aim in AIMS.items() if told["grid"].startswith(grid)), {})
    return [
        {
            "grid": told["grid"],
            "threads": threads,
            **{f"× {name}": "" for name in others},
            **_times_faster(told, seconds),
            "aim": ", ".join(f"{aim * _share(threads):.2g} × {name}" for name, aim in aims.items()),
            **times,
        }
        for threads, seconds in told["seconds"].items()
    ]


def scenario_rows(told: dict[str, Any]) -> list[Row]:
    """Return one row."""
    return [
        {
            "planner": told["planner"],
            **_answers(told),
            "index, s": f"{told['index_seconds']:.3g}",
            "index, MB": f"{told['index_bytes'] / 1e6:.3g}",
        }
    ]


def index_rows(told: dict[str, Any]) -> list[Row]:
    """Return one row."""
    return [
        {
            "grid": told["grid"],
            "planner": told["planner"],
            **{f"{on_threads(threads)}, s": f"{seconds:.2f}" for threads, seconds in told["seconds"].items()},
            "MB": f"{told['bytes'] / 1e6:.3g}",
            **_answers(told),
            **_plans(told),
        }
    ]


def _plans(told: dict[str, Any]) -> Row:
    """Return the columns of whole plans, which figures of earlier runs lack."""
    if "seen_us" not in told:
        return {}
    return {"plan, µs": f"{told['map_us']:.0f}", "with seen obstacles, µs": f"{told['seen_us']:.0f}"}


def compare_rows(told: dict[str, Any]) -> list[Row]:
    """Return the rows of the fields, followed by those of the paths."""
    rows = []
    for problem, key in (("field", "fields"), ("path", "paths")):
        for one in told[key]:
            rows.append(
                {
                    "problem": problem,
                    "implementation": one["who"],
                    "ms": _ms(one["seconds"]),
                    "× ours": _figure(one["ratio"]),
                    "ns/cell": _figure(one["ns_per_cell"]) if "ns_per_cell" in one else "",
                    "preparation, ms": _ms(one["prepare_seconds"]) if one["prepare_seconds"] else "",
                    "error": f"{round(100.0 * one['off'], 2) + 0.0:.2f} %",
                    "drivable": _walkable(one),
                    "solves": one["solves"],
                }
            )
    return rows


def scaling_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each kind of grid and number of threads: ns per reached cell, by size."""
    return [
        {"grid": kind, "threads": threads}
        | {f"{size}²": f"{ns:.2f}" for size, ns in zip(told["sizes"], values, strict=True)}
        | {"max / min": f"{told['spread'][kind][threads]:.2f}"}
        for kind, by_threads in told["ns_per_cell"].items()
        for threads, values in by_threads.items()
    ]


def growth_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each kind of grid and planner: the time of a plan [ms], by size, and how it grows."""
    return [
        {"grid": kind, "planner": name}
        | {f"{size}², ms": "" if s is None else _ms(s) for size, s in zip(told["sizes"], one["next"], strict=True)}
        | {"× dijkstra": _figure(max(filter(None, one["times"]), default=0.0))}
        | {"exponent": "" if one["exponent"] is None else f"{one['exponent']:.2f}", "wrong": str(one["wrong"])}
        for kind, by_planner in told["planners"].items()
        for name, one in by_planner.items()
    ]


def length_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each path length: planning time [ms], by curve."""
    return [
        {"path, m": f"{length:.1f}"}
        | {f"{name}, ms": _ms(seconds[number]) for name, seconds in told["seconds"].items()}
        for number, length in enumerate(told["length_m"])
    ]


def _answers(told: dict[str, Any]) -> Row:
    return {
        "queries": f"{told['queries']:,}" + (f" of {told['of']:,}" if "of" in told else ""),
        "wrong": str(told["wrong"]),
        **{f"{name}, µs": f"{told[key]:,.1f}" for name, key in _SPREAD.items()},
    }


def _times_faster(told: dict[str, Any], seconds: float) -> Row:
    return {f"× {name}": _figure(other / seconds) for name, other in told["beside"].items()}


def _share(threads: str) -> float:
    return ONE_THREAD if threads == "1" else 1.0


def _ns(seconds: float | None, reached: int) -> str:
    return "" if seconds is None else _figure(seconds / reached * 1e9)


def _walkable(one: dict[str, Any]) -> str:
    """Return whether a robot can use it: a field that reaches the same cells as ours, or a path that cuts no corner."""
    if "other_cells" in one:
        return "yes" if not one["other_cells"] else f"{one['other_cells']:,} cells differ"
    return "yes" if one["walkable"] else "cuts corners"


def _figure(value: float) -> str:
    """Return a number with three significant digits, and all digits from 1,000 on."""
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:.3g}"


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:,.4g}"


_SPREAD = {"mean": "mean_us", "p50": "p50_us", "p99": "p99_us"}
