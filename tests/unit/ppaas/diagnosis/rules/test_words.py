"""Words of findings."""

import pytest

from ppaas.diagnosis.rules import words


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (words.seconds(0.42), "0.4 s"), (words.seconds(200.0), "3 min"), (words.seconds(9e3), "2 h"),
        (words.seconds(3e5), "3 days"), (words.size(800), "800 bytes"), (words.size(12e3), "12 kB"),
        (words.size(1.44e6), "1.4 MB"), (words.hertz(10.02), "10 Hz"), (words.hertz(0.4), "0.4 Hz"),
        (words.percent(0.256), "26 %"), (words.count(1, "message"), "1 message"), (words.count(3, "time"), "3 times"),
        (words.names([]), "none"), (words.names("abcdefghijklmn"), "a, b, c, d, e, f, g, h, i, j, k, l and 2 more"),
        (words.capital("it is"), "It is."), (words.nearest("lasr", ["laser", "odom"]), "laser"),
        (words.nearest("zzz", ["laser", "odom"]), ""), (words.nearest("laser", ["r1/laser"]), "r1/laser"),
    ],
)  # fmt: skip
def test_values_are_put_in_words(text: str, expected: str) -> None:
    assert text == expected
