import subprocess
import sys

from engine.runtimes.memory_tuning import stub_modules
from tests.support.sources import ROOT


def run(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, capture_output=True, text=True)
    return done.stdout


def test_numba_is_imported_with_stubs_and_later_imports_get_the_real_modules():
    code = """
import sys
import numpy as np
from engine.runtimes.memory_tuning.stub_modules import HTML, MASKED, POLYNOMIAL, stubbed
with stubbed(HTML, POLYNOMIAL):
    import numba
print(*(name for name in (HTML, MASKED, POLYNOMIAL) if name in sys.modules))
import html
print(html.escape("<"), np.ma.masked_all(1).mask, np.polynomial.Polynomial([2.0]).degree())
"""
    assert run(code) == "\n&lt; [ True] 0\n"


def test_a_kernel_is_compiled_and_called_without_masked_arrays():
    code = """
import sys
import numba
import numpy as np
from engine.runtimes.memory_tuning.stub_modules import MASKED, stubbed
first = numba.njit(lambda cells: cells[0])
cells = np.ones(3)
cells.flags.writeable = False
with stubbed(MASKED):
    print(first(cells))
print(MASKED in sys.modules)
try:
    first(np.ma.masked_all(1))
except numba.errors.TypingError:
    print("refused")
"""
    assert run(code) == "1.0\nFalse\nrefused\n"


def test_uvloop_runs_with_a_stub_and_later_imports_get_the_real_module():
    code = """
import sys
from engine.runtimes.memory_tuning.stub_modules import TLS, stubbed, without_extras
with without_extras():
    import asyncio
    with stubbed(TLS):
        import uvloop
    print(sys.modules[TLS])
print(TLS in sys.modules, "_hashlib" in sys.modules)
async def echo():
    server = await asyncio.start_server(lambda reader, writer: writer.write(b"x"), "127.0.0.1", 0)
    reader, _ = await asyncio.open_connection(*server.sockets[0].getsockname())
    return await reader.read(1)
print(uvloop.run(echo()))
import ssl
print(ssl.create_default_context().verify_mode.name)
"""
    assert run(code) == "None\nFalse False\nb'x'\nCERT_REQUIRED\n"


def test_modules_imported_before_stay():
    import html

    with stub_modules.stubbed(stub_modules.HTML):
        assert sys.modules["html"] is html
        assert html.escape("<") == "&lt;"
    assert sys.modules["html"] is html


def test_unused_extras_are_hidden_only_inside_the_context():
    code = """
from engine.runtimes.memory_tuning import stub_modules
with stub_modules.without_extras():
    for name in stub_modules.UNUSED_EXTRAS:
        try:
            __import__(name)
        except ImportError:
            print("no", name)
import typing_extensions, yaml
"""
    assert run(code).split() == [word for name in stub_modules.UNUSED_EXTRAS for word in ("no", name)]


def test_an_extra_that_is_loaded_already_stays(monkeypatch):
    monkeypatch.setitem(sys.modules, "yaml", sys)
    with stub_modules.without_extras():
        assert sys.modules["yaml"] is sys
    assert sys.modules["yaml"] is sys
