import subprocess
import sys

import pytest

ALLOCATE = """
import ctypes, sys
from engine.runtimes.memory_tuning import process_memory
allocate, free = {functions}
allocate.restype, allocate.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
free.restype, free.argtypes = None, [ctypes.c_void_p]
blocks = [allocate({size}) for _ in range(2000)]
for block in blocks[::2]:
    free(block)
if "fill" in sys.argv:
    assert 1000 * {size} <= process_memory.fill() < 100 << 20
shared = {{block // 4096 for block in blocks}}
print(sum(allocate({size}) // 4096 in shared for _ in range(500)))
"""

INTERPRETER = "ctypes.pythonapi.PyObject_Malloc, ctypes.pythonapi.PyObject_Free"
LIBRARY = "ctypes.CDLL(None).malloc, ctypes.CDLL(None).free"
BLOCKS = [(INTERPRETER, 48), (INTERPRETER, 512), (LIBRARY, 600), (LIBRARY, 9000)]


@pytest.mark.parametrize(("functions", "size"), BLOCKS)
def test_new_blocks_are_not_placed_between_old_ones(functions, size):
    def between(*arguments: str) -> int:
        command = [sys.executable, "-c", ALLOCATE.format(functions=functions, size=size), *arguments]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    assert between() > 400
    assert between("fill") < 20
