from benchmarks.mapping import process_memory


def test_a_forgotten_peak_is_that_of_what_follows():
    block = bytearray(64 << 20)
    block[::4096] = b"1" * (len(block) // 4096)
    assert process_memory.peak() >= process_memory.resident()
    del block
    process_memory.forget_peak()
    before = process_memory.peak()
    assert before <= process_memory.resident() + 4.0
    assert 0.0 < process_memory.of_files() < before
