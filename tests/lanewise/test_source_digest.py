"""A digest changes with every constant that kernels see, wherever it stands."""

import sys
from types import ModuleType

import pytest

from lanewise.source_digest import digest_of

START = "from lanewise.jit import kernel, specialised\n"

#: What a script says before its kernel, and what the kernel reads of it.
SEEN = {
    "number": ("K = {k}", "K"),
    "record of lanes": (
        "from lanewise.vec3 import Vec3\nV = Vec3({k}.0, 1.0, 1.0)", "V.x",
    ),
    "default of a record": (
        "from collections import namedtuple\nR = namedtuple('R', 'x y', defaults=[{k}])",
        "R(1.0).y",
    ),
    "enumeration": ("from enum import IntEnum\nclass M(IntEnum):\n    A = {k}", "M.A + 0"),
    "helper": ("@kernel\ndef g(x):\n    return x * {k}", "g(1.0)"),
    "default": ("@kernel\ndef g(x, y={k}):\n    return x * y", "g(1.0)"),
    "closure": (
        """
def write(k):
    @kernel
    def g(x):
        return x * k
    return g
g = write({k})""", "g(1.0)",
    ),
    "function of Numba": ("import numba\n@numba.njit\ndef g(x):\n    return x * {k}", "g(1.0)"),
    "default by keyword": (
        "import numba\n@numba.njit\ndef g(x, *, y={k}):\n    return x * y", "g(1.0)",
    ),
    "module": ("import seen_consts", "seen_consts.K"),
    "module in a package": ("import seen_package.consts", "seen_package.consts.K"),
    "factory of another module": ("from seen_consts import made", "made(1.0)"),
    "function of Numba elsewhere": ("from seen_consts import compiled", "compiled(1.0)"),
}  # fmt: skip

OTHER = """
import numba
K = {k}
@specialised
def made(program):
    @kernel
    def text(x):
        return x * {k}
    return text
@numba.njit
def compiled(x):
    return x * {k}
"""


def module(name, text):
    """A module of that name, as if it had been imported."""
    made = sys.modules[name] = ModuleType(name)
    exec(compile(text, f"{name}.py", "exec"), made.__dict__)
    return made


@pytest.mark.parametrize("case", SEEN)
def test_a_digest_changes_with_what_the_kernel_sees(case, monkeypatch):
    text, read = SEEN[case]
    found = []
    for k in (2, 2, 5):
        consts = module("seen_consts", START + OTHER.format(k=k))
        package = module("seen_package", "")
        monkeypatch.setitem(sys.modules, "seen_package.consts", consts)
        package.consts = consts
        script = module(
            "seen_script", f"{START}{text.format(k=k)}\n@kernel\ndef root(t):\n    t[0] = {read}\n"
        )
        found.append(digest_of({"root": script.root}))
    for name in ("seen_consts", "seen_package", "seen_script"):
        del sys.modules[name]
    assert found[0] == found[1] != found[2]
