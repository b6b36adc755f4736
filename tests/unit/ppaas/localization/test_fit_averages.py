"""Detection of scans that fit worse than before."""

from ppaas.localization.fit_averages import AMISS, FitAverages


def after(averages: FitAverages, *fits: float) -> bool:
    for fit in fits:
        averages.note(fit)
    return averages.amiss


def test_nothing_is_amiss_while_scans_fit_as_before() -> None:
    averages = FitAverages(0.001, 0.1)
    assert not averages.amiss
    assert not after(averages, *[0.8] * 100, *[0.8 * (1.0 - 0.9 * AMISS)] * 1000)


def test_scans_that_fit_worse_of_late_are_noticed_and_forgiven_when_they_fit_again() -> None:
    averages = FitAverages(0.001, 0.1)
    assert after(averages, *[0.8] * 50, 0.4, 0.4, 0.4)
    assert not after(averages, *[0.8] * 20)


def test_what_the_first_scan_happened_to_be_is_soon_outweighed() -> None:
    averages = FitAverages(0.001, 0.1)
    assert after(averages, 0.1, *[0.8] * 50, *[0.4] * 10)


def test_with_rates_of_zero_nothing_is_ever_amiss() -> None:
    assert not after(FitAverages(0.0, 0.0), *[0.8] * 50, *[0.0] * 50)


def test_what_is_forgotten_does_not_count() -> None:
    averages = FitAverages(0.001, 0.1)
    after(averages, *[0.8] * 50)
    averages.forget()
    assert not after(averages, *[0.2] * 50)
