"""Figures of the reuse bench."""

from benchmarks.service.plan_reuse import TIMES, _figures, _sample, _Taken


async def test_computed_and_reused_paths_are_sampled_separately() -> None:
    requests: list[bool] = []

    async def ask(reuse: bool) -> str:
        requests.append(reuse)
        return "reused" if reuse else "computed"

    taken = await _sample(ask, 3)
    assert requests == [False] * 4 + [True] * 3
    assert (len(taken.computed), len(taken.asked), dict(taken.origins)) == (3, 3, {"reused": 3})


def test_the_speed_up_is_reported_only_for_reused_paths() -> None:
    taken = _Taken([1.0, 2.0, 3.0], [0.1, 0.1, 0.4])
    taken.origins["reused"] = 3
    *_, sooner = _figures("navfn", taken)
    assert (sooner.value, sooner.unit, sooner.limit, sooner.kept) == (20.0, "×", TIMES, True)
    taken.origins["computed"] = 1
    assert [figure.unit for figure in _figures("navfn", taken)] == ["ms", "ms"]
