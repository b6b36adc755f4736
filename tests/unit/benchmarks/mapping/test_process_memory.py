from benchmarks.harness import process_usage


def test_a_forgotten_peak_is_that_of_what_follows():
    block = bytearray(64 << 20)
    block[::4096] = b"1" * (len(block) // 4096)
    assert process_usage.peak() >= process_usage.resident()
    del block
    process_usage.forget_peak()
    before = process_usage.peak()
    assert before <= process_usage.resident() + 4.0
    assert 0.0 < process_usage.of_files() < before
