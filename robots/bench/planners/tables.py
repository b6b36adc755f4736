"""What people see of each bench of planners: rows of text, by column."""

from typing import Any

Row = dict[str, str]


def field_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each number of threads."""
    return [
        {
            "grid": told["grid"],
            "reached": f"{told['reached']:,}",
            "threads": threads,
            "ms": _ms(seconds),
            "ns a cell": f"{told['ns_per_cell'][threads]:.2f}",
            "again, ms": _ms(told["again_seconds"][threads]),
            **{f"× {name}": f"{other / seconds:.3g}" for name, other in told["beside"].items()},
        }
        for threads, seconds in told["seconds"].items()
    ]


def scenario_rows(told: dict[str, Any]) -> list[Row]:
    """Return one row."""
    return [
        {
            "planner": told["planner"],
            "queries": f"{told['queries']:,}",
            "wrong": str(told["wrong"]),
            **{f"{name}, µs": f"{told[key]:,.1f}" for name, key in _SPREAD.items()},
            "index, s": f"{told['index_seconds']:.3g}",
            "index, MB": f"{told['index_bytes'] / 1e6:.3g}",
        }
    ]


def compare_rows(told: dict[str, Any]) -> list[Row]:
    """Return the rows of the fields, and those of the paths."""
    rows = []
    for problem, key in (("field", "fields"), ("path", "paths")):
        for one in told[key]:
            rows.append(
                {
                    "problem": problem,
                    "who": one["who"],
                    "ms": _ms(one["seconds"]),
                    "× ours": f"{one['ratio']:.3g}",
                    "ns a cell": f"{one['ns_per_cell']:.3g}" if "ns_per_cell" in one else "",
                    "prepared, ms": _ms(one["prepare_seconds"]) if one["prepare_seconds"] else "",
                    "off": f"{round(100.0 * one['off'], 2) + 0.0:.2f} %",
                    "for a robot": _walkable(one),
                    "solves": one["solves"],
                }
            )
    return rows


def scaling_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each kind of grid and number of threads: ns a cell, by size."""
    return [
        {"grid": kind, "threads": threads}
        | {f"{size}²": f"{ns:.2f}" for size, ns in zip(told["sizes"], values, strict=True)}
        for kind, by_threads in told["ns_per_cell"].items()
        for threads, values in by_threads.items()
    ]


def length_rows(told: dict[str, Any]) -> list[Row]:
    """Return a row for each length: ms, by curve."""
    return [
        {"path, m": f"{length:.1f}"}
        | {f"{name}, ms": _ms(seconds[number]) for name, seconds in told["seconds"].items()}
        for number, length in enumerate(told["length_m"])
    ]


def _walkable(one: dict[str, Any]) -> str:
    """Tell whether a robot could do with it: a field that reaches the same cells, a path that cuts no corner."""
    if "other_cells" in one:
        return "yes" if not one["other_cells"] else f"{one['other_cells']:,} cells differ"
    return "yes" if one["walkable"] else "cuts corners"


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:,.4g}"


_SPREAD = {"mean": "mean_us", "p50": "p50_us", "p99": "p99_us"}
