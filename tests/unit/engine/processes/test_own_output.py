"""Standard output that a program takes for its answers."""

import subprocess
import sys

PROGRAM = """
import os
from engine.processes.helper_program import take_standard_output
answers = take_standard_output()
print("printed", flush=True)
os.system("echo by a child")
answers.write(b"an answer")
answers.flush()
"""


def test_answers_alone_are_on_standard_output() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stdout == "an answer"
    assert done.stderr == "printed\nby a child\n"
