"""Rules for the English of docstrings and documents, each a function from a text to the lines that break it."""

import ast
import re
from collections.abc import Iterator

from tests.support.sources import Source

QUESTION = re.compile(r"(What|Who|Whose|How|Where|Whether|Why|When|Which)\b")
"""First words that make a docstring a riddle: it should say what the module is or does, subject first."""
DIALECT = re.compile(r"\b(whoever|whomever|is told of|are told of|tells of)\b", re.IGNORECASE)
"""Words that stand for an actor with a name: the client, the caller, the process."""
STILTED = re.compile(r"\b(those of|that of|anew)\b", re.IGNORECASE)
"""Words that stand for a noun or a verb: "that of the robot" for "the robot's frame", "plan anew" for "replan"."""
CODE = re.compile(r"^( *)```.*?^\1```$|`[^`\n]*`", re.MULTILINE | re.DOTALL)
"""Blocks and spans of code, which show what a program prints."""


def question_for_a_docstring(source: Source) -> list[str]:
    """Return the module if its docstring opens with a question word."""
    text = ast.get_docstring(source.tree) or ""
    return [f"{source.path}: {text.splitlines()[0]}"] if QUESTION.match(text) else []


def dialect(path: str, text: str) -> list[str]:
    """Return the lines of a text with words that hide who acts."""
    return [f"{path}:{number}: {found}" for number, found in dialect_lines(text)]


def stilted(path: str, text: str) -> list[str]:
    """Return the lines of a document, without its code, that have words of `STILTED`."""
    plain = CODE.sub(lambda code: "\n" * code[0].count("\n"), text)
    lines = enumerate(plain.splitlines(), 1)
    return [f"{path}:{number}: {found[0]}" for number, line in lines if (found := STILTED.search(line))]


def dialect_lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the number and the word of each line that has one."""
    for number, line in enumerate(text.splitlines(), 1):
        if found := DIALECT.search(line):
            yield number, found[0]
