"""A driver's library without a GPU, and with whatever faults are asked for."""

import ctypes
from typing import Any

from alight.gpu import driver


class Library:
    """In the place of libcuda: what it says of the GPU, and which functions fail with which code.

    Parameters
    ----------
    count, version : int
        GPUs, and the driver's version.
    capability : (int, int)
    failing : dict of str to int
        Codes of functions that fail.
    """

    def __init__(
        self, count: int = 1, version: int = 13000, capability: tuple[int, int] = (9, 0),
        failing: dict[str, int] | None = None,
    ) -> None:  # fmt: skip
        self._numbers = {"cuDeviceGetCount": count, "cuDriverGetVersion": version, "cuDeviceGet": 0}
        self._attributes = {16: 4, 75: capability[0], 76: capability[1]}
        self._failing = failing or {}
        self.called: list[str] = []

    def __getattr__(self, name: str) -> Any:
        def call(*arguments: Any) -> int:
            self.called.append(name)
            if name in self._numbers:
                arguments[0]._obj.value = self._numbers[name]
            elif name == "cuDeviceGetAttribute":
                arguments[0]._obj.value = self._attributes[arguments[1]]
            elif name == "cuDeviceGetName":
                arguments[0].value = b"Model 3"
            elif name == "cuGetErrorString":
                arguments[1]._obj.value = b"it is tired"
            elif name == "cuMemAlloc_v2":
                arguments[0]._obj.value = 64 * len(self.called)
            elif name == "cuModuleLoadDataEx" and name in self._failing:
                log = ctypes.cast(arguments[4][0], ctypes.c_char_p)
                ctypes.memmove(log, b"line 3: what?\0", 14)
            return self._failing.get(name, 0)

        return call


def have(monkeypatch: Any, library: Library | None) -> None:
    """Have this library; or none."""

    def load() -> Any:
        if library is None:
            raise OSError("libcuda.so.1: cannot open shared object file")
        return library

    monkeypatch.setattr(driver, "load_library", load)
