"""Words of findings."""

import pytest

from ppaas.diagnosis.rules.finding import capital, count, hertz, names, nearest, percent, seconds, size


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (seconds(0.42), "0.4 s"), (seconds(200.0), "3 min"), (seconds(9e3), "2 h"),
        (seconds(3e5), "3 days"), (size(800), "800 bytes"), (size(12e3), "12 kB"),
        (size(1.44e6), "1.4 MB"), (hertz(10.02), "10 Hz"), (hertz(0.4), "0.4 Hz"),
        (percent(0.256), "26 %"), (count(1, "message"), "1 message"), (count(3, "time"), "3 times"),
        (names([]), "none"), (names("abcdefghijklmn"), "a, b, c, d, e, f, g, h, i, j, k, l and 2 more"),
        (capital("it is"), "It is."), (nearest("lasr", ["laser", "odom"]), "laser"),
        (nearest("zzz", ["laser", "odom"]), ""), (nearest("laser", ["r1/laser"]), "r1/laser"),
    ],
)  # fmt: skip
def test_values_are_put_in_words(text: str, expected: str) -> None:
    assert text == expected
