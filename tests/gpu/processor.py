"""A GPU that is the processor: its memory is ours, and its threads run one after the other."""

from typing import Any, Self

import numpy as np

from alight.rendering.executors import gpu_executor
from alight.rendering.tiles.pixel_kernel import render_pixel
from lanewise.jit import instantiate
from lanewise.machine_code import ObjectCode


class ProcessorGpu:
    """In the place of `alight.gpu.driver.Gpu`."""

    name, multiprocessors = "a processor", 1
    description = {"gpu": "a processor"}
    #: The kernel of the last PTX that was asked for.
    entry: Any = None

    def __init__(self) -> None:
        self.memory: dict[int, np.ndarray] = {}
        self.launches: list[int] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.memory.clear()

    def allocate(self, size: int) -> int:
        array = np.full(max(size, 1), 85, np.uint8)
        self.memory[array.ctypes.data] = array
        return array.ctypes.data

    def free(self, address: int) -> None:
        del self.memory[address]

    def write(self, address: int, array: np.ndarray) -> None:
        self.memory[address][: array.nbytes] = array.reshape(-1).view(np.uint8)

    def read(self, address: int, array: np.ndarray) -> None:
        array.reshape(-1).view(np.uint8)[:] = self.memory[address][: array.nbytes]

    def clear(self, address: int, size: int) -> None:
        self.memory[address][:size] = 0

    def load(self, ptx: bytes, entry: str) -> Any:
        assert entry
        return type(self).entry

    def launch(self, kernel: Any, block: int, kinds: Any, arguments: Any) -> None:
        assert len(kinds) == len(arguments)
        self.launches.append(arguments[-1])
        for thread in range(arguments[-1]):
            kernel(*arguments[:-1], thread)


def render_on_the_processor(monkeypatch: Any) -> None:
    """Have ``device="gpu"`` render here."""

    def code_of(module: str, name: str, program: Any, arguments: tuple) -> ObjectCode:
        kernel = instantiate(render_pixel, program)
        ProcessorGpu.entry = staticmethod(kernel.entry(arguments))
        return next(iter(kernel._codes.values()))

    monkeypatch.setattr(gpu_executor, "ptx_of", code_of)
    monkeypatch.setattr(gpu_executor, "Gpu", ProcessorGpu)
