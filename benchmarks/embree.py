"""Embree through the shared library inside the ``embreex`` wheel: build, and rays one by one.

Embree's own interface is called from a compiled loop, so that what is timed is `rtcIntersect1` and
not Python. Enumeration values and the layout of ``RTCRayHit`` are from Embree 4's headers.
"""

import ctypes
import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

TRIANGLES = 0  # RTC_GEOMETRY_TYPE_TRIANGLE
INDEX_BUFFER, VERTEX_BUFFER = 0, 1
UINT3, FLOAT3 = 0x5003, 0x9003  # RTC_FORMAT_*
ROBUST = 1 << 2  # RTC_SCENE_FLAG_ROBUST
MEDIUM_QUALITY = 1  # RTC_BUILD_QUALITY_MEDIUM, the default
NONE = 0xFFFFFFFF  # RTC_INVALID_GEOMETRY_ID


@lru_cache(maxsize=1)
def library() -> ctypes.CDLL:
    """Load the library and declare the argument types that pointers need."""
    import embreex

    folder = Path(embreex.__file__).parent.parent / "embreex.libs"
    ctypes.CDLL(str(next(folder.glob("libtbb*"))), mode=ctypes.RTLD_GLOBAL)
    embree = ctypes.CDLL(str(next(folder.glob("libembree4*"))))
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    for name, result, arguments in (
        ("rtcNewDevice", pointer, [ctypes.c_char_p]),
        ("rtcNewScene", pointer, [pointer]),
        ("rtcNewGeometry", pointer, [pointer, ctypes.c_int]),
        (
            "rtcSetNewGeometryBuffer",
            pointer,
            [pointer, ctypes.c_int, ctypes.c_uint, ctypes.c_int, size, size],
        ),
        ("rtcCommitGeometry", None, [pointer]),
        ("rtcAttachGeometry", ctypes.c_uint, [pointer, pointer]),
        ("rtcReleaseGeometry", None, [pointer]),
        ("rtcSetSceneFlags", None, [pointer, ctypes.c_int]),
        ("rtcSetSceneBuildQuality", None, [pointer, ctypes.c_int]),
        ("rtcCommitScene", None, [pointer]),
        ("rtcReleaseScene", None, [pointer]),
        ("rtcReleaseDevice", None, [pointer]),
        # Pointers as integers: what a compiled loop can pass.
        ("rtcIntersect1", None, [size, size, size]),
    ):
        function = getattr(embree, name)
        function.restype, function.argtypes = result, arguments
    return embree


class EmbreeScene:
    """One triangle mesh.

    Parameters
    ----------
    vertices : (n, 3) float32, metres
    faces : (m, 3) int32
    threads : int
        For the build.
    robust : bool
        Embree's watertight mode.

    Attributes
    ----------
    build_seconds : float
        Time of committing geometry and scene, without copying the buffers.
    """

    def __init__(
        self, vertices: np.ndarray, faces: np.ndarray, threads: int = 2, robust: bool = True
    ) -> None:
        embree = library()
        self._device = embree.rtcNewDevice(f"threads={threads}".encode())
        self._scene = embree.rtcNewScene(self._device)
        embree.rtcSetSceneBuildQuality(self._scene, MEDIUM_QUALITY)
        embree.rtcSetSceneFlags(self._scene, ROBUST if robust else 0)
        geometry = embree.rtcNewGeometry(self._device, TRIANGLES)
        for kind, layout, table in (
            (VERTEX_BUFFER, FLOAT3, np.ascontiguousarray(vertices, np.float32)),
            (INDEX_BUFFER, UINT3, np.ascontiguousarray(faces, np.uint32)),
        ):
            target = embree.rtcSetNewGeometryBuffer(geometry, kind, 0, layout, 12, len(table))
            ctypes.memmove(target, table.ctypes.data, table.nbytes)
        start = time.perf_counter()
        embree.rtcCommitGeometry(geometry)
        embree.rtcAttachGeometry(self._scene, geometry)
        embree.rtcCommitScene(self._scene)
        self.build_seconds = time.perf_counter() - start
        embree.rtcReleaseGeometry(geometry)

    def close(self) -> None:
        """Give the memory back."""
        library().rtcReleaseScene(self._scene)
        library().rtcReleaseDevice(self._device)

    def intersect(
        self, origins: np.ndarray, directions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Closest hits: t (n,) float32 (infinite for a miss), triangle (n,) int32 (-1)."""
        t = np.zeros(len(origins), np.float32)
        triangle = np.zeros(len(origins), np.int32)
        # RTCRayHit must be aligned to 16 bytes; 64 is a cache line.
        memory = np.zeros(64, np.float32)
        skip = -memory.ctypes.data % 64 // 4
        record = memory[skip : skip + 32]
        _loop()(
            self._scene, record.ctypes.data, record, record.view(np.uint32), origins, directions,
            t, triangle,
        )  # fmt: skip
        return t, triangle


@lru_cache(maxsize=1)
def _loop() -> Callable[..., None]:
    """Compile the loop over rays."""
    import numba

    intersect1 = library().rtcIntersect1

    @numba.njit(nogil=True)
    def loop(scene, address, record, bits, origins, directions, t, triangle):
        for i in range(len(origins)):
            for k in range(3):
                record[k] = origins[i, k]
                record[4 + k] = directions[i, k]
            record[3] = 0.0  # tnear
            record[7] = 0.0  # time
            record[8] = np.inf  # tfar
            bits[9] = NONE  # mask
            bits[10] = 0  # id
            bits[11] = 0  # flags
            bits[17] = NONE  # primID
            bits[18] = NONE  # geomID
            bits[19] = NONE  # instID
            intersect1(scene, address, 0)
            t[i] = record[8]
            triangle[i] = np.int32(bits[17])

    return loop
