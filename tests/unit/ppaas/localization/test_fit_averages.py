"""Detection of scans that fit worse than before."""

from ppaas.localization.fit_averages import AMISS, FitAverages


def after(averages: FitAverages, *fits: float) -> bool:
    for fit in fits:
        averages.note(fit)
    return averages.amiss


def test_steady_fits_are_not_amiss() -> None:
    averages = FitAverages(0.001, 0.1)
    assert not averages.amiss
    assert not after(averages, *[0.8] * 100, *[0.8 * (1.0 - 0.9 * AMISS)] * 1000)


def test_recent_worse_fits_are_amiss_until_scans_fit_again() -> None:
    averages = FitAverages(0.001, 0.1)
    assert after(averages, *[0.8] * 50, 0.4, 0.4, 0.4)
    assert not after(averages, *[0.8] * 20)


def test_first_fit_is_soon_outweighed() -> None:
    averages = FitAverages(0.001, 0.1)
    assert after(averages, 0.1, *[0.8] * 50, *[0.4] * 10)


def test_zero_rates_disable_the_detection() -> None:
    assert not after(FitAverages(0.0, 0.0), *[0.8] * 50, *[0.0] * 50)


def test_forget_resets_the_averages() -> None:
    averages = FitAverages(0.001, 0.1)
    after(averages, *[0.8] * 50)
    averages.forget()
    assert not after(averages, *[0.2] * 50)
