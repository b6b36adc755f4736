"""The rules of the house, each a function from a source file to what breaks it."""

import ast
import re
from collections.abc import Iterator

from tests.support.sources import ALL_PACKAGES, ROOT, Source

MAX_FILE_LINES = 400
MAX_CENTRE_LINES = 800
CENTRES = frozenset(
    line.partition(":")[0]
    for line in (ROOT / "tests/architecture/centres").read_text(encoding="utf-8").splitlines()
    if not line.startswith("#")
)
"""State machines and protocols that read top to bottom; each may be ``MAX_CENTRE_LINES`` long."""
MAX_FUNCTION_LINES = 40
MAX_KERNEL_LINES = 80

# fmt: off
IO_MODULES = frozenset({
    "argparse", "asyncio", "socket", "selectors", "ssl", "subprocess", "multiprocessing", "threading", "_thread",
    "concurrent",
    "sqlite3", "http", "urllib", "websockets", "fastapi", "uvicorn", "starlette", "zenoh", "psutil", "signal", "shutil",
    "tempfile", "mmap",
})
FILE_METHODS = frozenset({
    "open", "read_bytes", "read_text", "write_bytes", "write_text", "mkdir", "unlink", "rename", "tofile",
})
ARRAY_FILES = frozenset({
    "load", "save", "savez", "savez_compressed", "loadtxt", "savetxt", "fromfile", "memmap",
})
# fmt: on
ALLOWED = {
    "ppaas/clock.py": {"time"},
    "ppaas/decoding.py": {"threading"},
    "ppaas/planners/field/tile_helpers.py": {"threading"},
    "ppaas/planners/helper_threads.py": {"concurrent", "threading"},
    "ppaas/planners/batch/workers.py": {"concurrent"},
}

PRIVATE = {"robots/bridges/dds/cyclone.py": {"cyclonedds._clayer"}}
"""Private modules that are imported all the same; ``pyproject.toml`` bounds the versions of their packages."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def imported_modules(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and top-level name of every import, wherever it stands."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name.partition(".")[0]) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.lineno, node.module.partition(".")[0]


def io_imports(source: Source) -> list[str]:
    """Return imports of what does I/O, of ``time`` outside the clock, and of threads outside the workers."""
    forbidden = (IO_MODULES | {"time"}) - ALLOWED.get(source.path, set())
    return [f"{source.path}:{line} imports {name}" for line, name in imported_modules(source.tree) if name in forbidden]


def private_imports(source: Source) -> list[str]:
    """Return imports of what another package keeps private and changes with any release."""
    found: list[tuple[int, str]] = []
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found += [(node.lineno, f"{node.module}.{alias.name}") for alias in node.names]
    private = re.compile(rf"(?!(?:{'|'.join(ALL_PACKAGES)})\.)\w.*\._(?!_)")
    kept = PRIVATE.get(source.path, set())
    return [f"{source.path}:{line} imports {name}" for line, name in found if private.match(name) and name not in kept]


READERS = frozenset((
    "ppaas/kernel_cache/sources.py", "ppaas/kernel_cache/shipped.py", "ppaas/imports/maps/gis/raster.py",
    "ppaas/maps/exports/geotiff.py",
))  # fmt: skip
"""Modules of the domain that read files of the installation, or open files in the memory of GDAL."""


def io_calls(source: Source) -> list[str]:
    """Return calls that open, read or write files, or print; `READERS` may."""
    if source.path in READERS:
        return []
    calls = (node for node in ast.walk(source.tree) if isinstance(node, ast.Call))
    named = ((call.lineno, io_call_name(call.func)) for call in calls)
    return [f"{source.path}:{line} calls {name}" for line, name in named if name]


def io_call_name(function: ast.expr) -> str | None:
    """Return how a call is spelled if it does I/O."""
    match function:
        case ast.Name("open" | "print" | "input" as name):
            return name
        case ast.Attribute(ast.Name("np" | "numpy"), name) if name in ARRAY_FILES:
            return f"numpy.{name}"
        case ast.Attribute(_, name) if name in FILE_METHODS:
            return f".{name}"
    return None


def typed_decodes(source: Source) -> list[str]:
    """Return calls in which msgspec may describe a type while another thread does: ``ppaas.decoding`` has those."""
    if source.path == "ppaas/decoding.py":
        return []
    calls = (node for node in ast.walk(source.tree) if isinstance(node, ast.Call))
    return [
        f"{source.path}:{call.lineno} calls {ast.unparse(call.func)} with a type"
        for call in calls
        if ast.unparse(call.func) == "msgspec.convert"
        or (
            ast.unparse(call.func) in ("msgspec.json.decode", "msgspec.msgpack.decode")
            and "type" in {keyword.arg for keyword in call.keywords}
        )
    ]


CHANGING_METHODS = frozenset(
    {
        "add",
        "append",
        "appendleft",
        "clear",
        "discard",
        "extend",
        "insert",
        "pop",
        "popitem",
        "popleft",
        "remove",
        "update",
    }
)
"""Methods that change what they are called on."""


def long_file(source: Source) -> list[str]:
    """Return the file if it is too long."""
    lines = len(source.text.splitlines())
    most = MAX_CENTRE_LINES if source.path in CENTRES else MAX_FILE_LINES
    return [f"{source.path}: {lines} lines, at most {most}"] if lines > most else []


def code_lines(function: Function) -> int:
    """Count the lines of a function from ``def`` on, its docstring left out: to say much of it is no fault."""
    lines = (function.end_lineno or function.lineno) - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function, clean=False) is not None:
        lines -= (first.end_lineno or first.lineno) - first.lineno + 1
    return lines


def long_functions(source: Source) -> list[str]:
    """Return the functions that are too long; a kernel may be twice as long."""
    most = MAX_KERNEL_LINES if "/kernels/" in source.path else MAX_FUNCTION_LINES
    functions = (node for node in ast.walk(source.tree) if isinstance(node, Function))
    return [
        f"{source.path}:{function.lineno} {function.name}: {code_lines(function)} lines"
        for function in functions
        if code_lines(function) > most
    ]


def swallowed_errors(source: Source) -> list[str]:
    """Return where any error at all is caught and nothing done."""
    return [
        f"{source.path}:{node.lineno} swallows every error"
        for node in ast.walk(source.tree)
        if (isinstance(node, ast.ExceptHandler) and catches_all(node.type) and does_nothing(node.body))
        or (isinstance(node, ast.Call) and names(node.func) == {"suppress"} and any(map(catches_all, node.args)))
    ]


def working_assertions(source: Source) -> list[str]:
    """Return the assertions that change something: containers run without assertions."""
    return [
        f"{source.path}:{node.lineno} asserts by .{call.func.attr}()"
        for node in ast.walk(source.tree)
        if isinstance(node, ast.Assert)
        for call in ast.walk(node.test)
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) and call.func.attr in CHANGING_METHODS
    ]


def names(expression: ast.expr | None) -> set[str]:
    """Return the last names of an expression or of a tuple of them."""
    match expression:
        case ast.Name(name) | ast.Attribute(_, name):
            return {name}
        case ast.Tuple(elements):
            return set().union(*map(names, elements))
    return set()


def catches_all(caught: ast.expr | None) -> bool:
    """Tell whether an ``except`` names nothing, or the base of everything."""
    return caught is None or bool(names(caught) & {"Exception", "BaseException"})


def does_nothing(body: list[ast.stmt]) -> bool:
    """Tell whether a block has no effect."""
    return all(isinstance(line, ast.Pass | ast.Continue) or is_constant(line) for line in body)


def is_constant(line: ast.stmt) -> bool:
    """Tell whether a line is nothing but a constant, as ``...`` is."""
    return isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant)
