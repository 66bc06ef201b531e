"""A table as kernels see it: a pointer and a size, without reference counts.

Arrays passed into kernels that are not inlined cost atomic reference counting at every call; a
`View` does not own its memory, so the compiled code never counts. The Python object keeps the
array alive.
"""

from __future__ import annotations

import numpy as np


class View:
    """Flat read-write window on a C-contiguous array.

    Parameters
    ----------
    array : ndarray
        float32, float64, uint32, int32 or int64, C-contiguous. Kernels index it flat, without
        bounds.

    Attributes
    ----------
    array, shaped : ndarray
        The same memory flat, and in the shape that was given.
    """

    __slots__ = ("address", "array", "shaped", "size")

    def __init__(self, array: np.ndarray):
        if not array.flags.c_contiguous:
            raise ValueError("a View needs a C-contiguous array")
        self.shaped = array
        self.array = array.reshape(-1)
        self.size = self.array.size
        self.address = self.array.ctypes.data

    @property
    def dtype(self) -> np.dtype:
        """Element type."""
        return self.array.dtype

    def __getitem__(self, index):
        """Read a number; as machine code, without counting from the end."""
        return self.array[_checked(index)]

    def __setitem__(self, index, value):
        """Write a number."""
        self.array[_checked(index)] = value

    def __reduce__(self):
        return View, (self.shaped,)


def part_of(view, first, size):
    """The numbers from `first` on as a table of their own, which shares their memory."""
    return View(view.array[first : first + size])


def _checked(index):
    if isinstance(index, int | np.integer) and index < 0:
        raise IndexError(f"index {index} is out of bounds: it must not be negative")
    return index
