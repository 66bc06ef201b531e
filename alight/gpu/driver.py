"""The CUDA driver, by ctypes: nothing to install but what makes the GPU work at all.

The functions are those of NVIDIA's CUDA Driver API reference manual; those of the toolkit are not
needed, since PTX becomes machine code in the driver.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from alight.core.errors import DeviceError

#: Arguments of kernels as C sees them, by their LLVM types.
C_TYPES = {
    "i8": ctypes.c_int8,
    "i32": ctypes.c_int32,
    "i64": ctypes.c_int64,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    "ptr": ctypes.c_uint64,
}

#: CUresult: out of memory; no GPU that may be used.
OUT_OF_MEMORY, NO_DEVICE = 2, 100

#: CUdevice_attribute: multiprocessors; major and minor number of the compute capability.
_MULTIPROCESSORS, _MAJOR, _MINOR = 16, 75, 76

#: CUjit_option: a buffer for what the driver says of PTX that it refuses, and its size.
_ERROR_LOG, _ERROR_LOG_SIZE = 5, 6
_LOG_BYTES = 4096

#: Turing, and the first driver that takes PTX 8.3 (of CUDA 12.3).
LEAST_CAPABILITY, LEAST_DRIVER = (7, 5), 12030


def load_library() -> Any:
    """The driver's library.

    Raises
    ------
    OSError
    """
    return ctypes.CDLL("nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1")


class Driver:
    """The functions of the driver's library, whose errors are raised.

    Raises
    ------
    DeviceError
        If there is no driver, or it finds no GPU.
    """

    def __init__(self) -> None:
        try:
            self._library = load_library()
        except OSError:
            raise DeviceError(
                "no NVIDIA driver is installed here (its library libcuda is not found); "
                "the processor renders without it"
            ) from None
        try:
            self.call("cuInit", 0)
        except DeviceError as error:
            raise (_none_found() if error.code == NO_DEVICE else error) from None

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function.

        Raises
        ------
        DeviceError
            If it fails.
        """
        code = getattr(self._library, name)(*arguments)
        if code:
            raise DeviceError(f"the GPU's driver cannot go on: {self._said_of(code)}", code)

    def _said_of(self, code: int) -> str:
        text = ctypes.c_char_p()
        self._library.cuGetErrorString(code, ctypes.byref(text))
        return f"{(text.value or b'an unknown error').decode()} (CUDA error {code})"

    def number(self, name: str, *arguments: Any) -> int:
        """What a function writes to its first argument."""
        found = ctypes.c_int()
        self.call(name, ctypes.byref(found), *arguments)
        return found.value


class Gpu:
    """The first GPU that the driver shows; a context, at whose end its memory is given back.

    ``CUDA_VISIBLE_DEVICES`` chooses another one.

    Raises
    ------
    DeviceError
        If there is none, or it or its driver is too old.
    """

    def __init__(self) -> None:
        self._driver = driver = Driver()
        self.driver_version = driver.number("cuDriverGetVersion")
        if not driver.number("cuDeviceGetCount"):
            raise _none_found()
        self._device = driver.number("cuDeviceGet", 0)
        name = ctypes.create_string_buffer(256)
        driver.call("cuDeviceGetName", name, len(name), self._device)
        self.name = name.value.decode(errors="replace")
        self.capability = (self._attribute(_MAJOR), self._attribute(_MINOR))
        self.multiprocessors = self._attribute(_MULTIPROCESSORS)
        if self.capability < LEAST_CAPABILITY:
            raise DeviceError(
                f"{self.name} has compute capability {_dotted(self.capability)}; "
                f"kernels need {_dotted(LEAST_CAPABILITY)} or more"
            )
        if self.driver_version < LEAST_DRIVER:
            raise DeviceError(
                f"the driver of {self.name} supports CUDA {_version(self.driver_version)}; "
                f"kernels need {_version(LEAST_DRIVER)} or later"
            )
        self._context = ctypes.c_void_p()
        self._held: set[int] = set()

    def _attribute(self, which: int) -> int:
        return self._driver.number("cuDeviceGetAttribute", which, self._device)

    @property
    def description(self) -> dict[str, str]:
        """What decides the bits of its results beside PTX."""
        return {
            "gpu": f"{self.name}, compute capability {_dotted(self.capability)}",
            "gpu driver": f"CUDA {_version(self.driver_version)}",
        }

    def __enter__(self) -> Self:
        """Take hold of the GPU."""
        context = ctypes.byref(self._context)
        self._driver.call("cuDevicePrimaryCtxRetain", context, self._device)
        return self

    def __exit__(self, *raised: object) -> None:
        """Give back its memory; a GPU that is lost has nothing to give back."""
        try:
            for address in list(self._held):
                self.free(address)
            self._driver.call("cuDevicePrimaryCtxRelease_v2", self._device)
        except DeviceError:
            if raised[0] is None:
                raise

    def _call(self, name: str, *arguments: Any) -> None:
        # Current is what the calling thread works with.
        self._driver.call("cuCtxSetCurrent", self._context)
        self._driver.call(name, *arguments)

    # ------------------------------------------------------------------------ memory

    def allocate(self, size: int) -> int:
        """The address of `size` bytes.

        Raises
        ------
        DeviceError
            If so much is not free.
        """
        address = ctypes.c_uint64()
        try:
            self._call("cuMemAlloc_v2", ctypes.byref(address), ctypes.c_size_t(max(size, 1)))
        except DeviceError as error:
            if error.code != OUT_OF_MEMORY:
                raise
            raise DeviceError(
                f"{self.name} has no {size / 1e6:.1f} MB of memory free for the render", error.code
            ) from None
        self._held.add(address.value)
        return address.value

    def free(self, address: int) -> None:
        """Give memory back."""
        self._held.discard(address)
        self._call("cuMemFree_v2", ctypes.c_uint64(address))

    def write(self, address: int, array: np.ndarray) -> None:
        """Copy a C-contiguous array to the GPU."""
        if array.nbytes:
            source, size = ctypes.c_void_p(array.ctypes.data), ctypes.c_size_t(array.nbytes)
            self._call("cuMemcpyHtoD_v2", ctypes.c_uint64(address), source, size)

    def read(self, address: int, array: np.ndarray) -> None:
        """Copy from the GPU into a C-contiguous array; waits for what was launched."""
        if array.nbytes:
            target, size = ctypes.c_void_p(array.ctypes.data), ctypes.c_size_t(array.nbytes)
            self._call("cuMemcpyDtoH_v2", target, ctypes.c_uint64(address), size)

    def clear(self, address: int, size: int) -> None:
        """Write zeros."""
        zero, count = ctypes.c_ubyte(0), ctypes.c_size_t(size)
        self._call("cuMemsetD8_v2", ctypes.c_uint64(address), zero, count)

    # ------------------------------------------------------------------------ code

    def load(self, ptx: bytes, entry: str) -> Any:
        """Have the driver compile PTX; gives the kernel `entry`."""
        log = ctypes.create_string_buffer(_LOG_BYTES)
        options = (ctypes.c_int * 2)(_ERROR_LOG, _ERROR_LOG_SIZE)
        values = (ctypes.c_void_p * 2)(ctypes.addressof(log), _LOG_BYTES)
        module, function = ctypes.c_void_p(), ctypes.c_void_p()
        try:
            self._call("cuModuleLoadDataEx", ctypes.byref(module), ctypes.c_char_p(ptx),
                       2, options, values)  # fmt: skip
        except DeviceError as error:
            said = log.value.decode(errors="replace").strip()
            raise DeviceError(f"{error}\n{said}" if said else str(error), error.code) from None
        self._call("cuModuleGetFunction", ctypes.byref(function), module, entry.encode())
        return function

    def launch(
        self, kernel: Any, block: int, kinds: Sequence[str], arguments: Sequence[Any]
    ) -> None:
        """Run as many threads as the last argument says, and wait for them.

        Parameters
        ----------
        kernel : from `load`
        block : int
            Threads of a block.
        kinds : sequence of str
            Keys of `C_TYPES`, one for each argument.
        arguments : sequence of int or float
        """
        held = [C_TYPES[kind](value) for kind, value in zip(kinds, arguments, strict=True)]
        pointers = (ctypes.c_void_p * len(held))(*map(ctypes.addressof, held))
        blocks = -(-arguments[-1] // block)
        self._call("cuLaunchKernel", kernel, blocks, 1, 1, block, 1, 1, 0, None, pointers, None)
        self._call("cuCtxSynchronize")


def _none_found() -> DeviceError:
    hidden = "CUDA_VISIBLE_DEVICES" in os.environ
    why = "; CUDA_VISIBLE_DEVICES hides what there is" if hidden else ""
    return DeviceError(f"the NVIDIA driver finds no GPU{why}", NO_DEVICE)


def _dotted(capability: tuple[int, int]) -> str:
    return ".".join(map(str, capability))


def _version(number: int) -> str:
    """CUDA's version from the number that the driver gives it."""
    return f"{number // 1000}.{number % 1000 // 10}"
