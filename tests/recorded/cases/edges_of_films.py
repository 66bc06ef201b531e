"""What films, archives, tables of coverage and files of pictures refuse, and how they are read."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np

from alight.films import (
    Film,
    PartialFilm,
    archive,
    coverage,
    denoising,
    ledger,
    merging,
    storage,
    tiles,
)
from alight.films.coverage import SurfaceSums
from alight.outputs import atomic, exr, image, primaries, texels
from tests.recorded.making import described, film_of, in_folder, outcome


def tables() -> dict[str, Any]:
    """Tables of coverage: packed and read back, out of order, of other films."""
    good = SurfaceSums(np.array([0, 0, 2]), np.array([1, 3, 0]), np.array([[0, 5], [1, 0], [2, 9]]))
    packed = coverage.pack_sums("c", good)
    changes: dict[str, dict[str, Any]] = {
        "good": {},
        "none": {"c.pixels": None},
        "length": {"c.low": np.array([1, 2])},
        "type": {"c.high": np.array([1.0, 2.0, 3.0])},
        "order": {"c.pixels": np.array([2, 0, 0])},
        "same": {"c.surfaces": np.array([3, 3, 0])},
        "low": {"c.low": np.array([-1, 0, 0])},
        "large": {"c.low": np.array([1 << 40, 0, 0])},
        "pixel": {"c.pixels": np.array([0, 0, 4])},
        "surface": {"c.surfaces": np.array([1, 4, 0])},
        "last": {"c.surfaces": np.array([1, 3, 3])},
        "negative": {"c.surfaces": np.array([-1, 3, 0])},
    }
    found: dict[str, Any] = {}
    for name, change in changes.items():
        arrays = {key: one for key, one in (packed | change).items() if one is not None}
        found[name] = outcome(coverage.unpack_sums, "c", arrays, 4, 4)
    grown = coverage.Coverage([("a", "m"), ("b", "n")])
    for _ in range(3):
        grown.add(good)
    copied = grown.copy()
    grown.add(good)
    found["grown"] = [described(grown.sums), described(copied.sums), grown.names]
    others = {
        "same": coverage.Coverage([("a", "m"), ("b", "n")]),
        "none": None,
        "more": coverage.Coverage([("a", "m")] * 3),
        "object": coverage.Coverage([("a", "m"), ("c", "n")]),
        "material": coverage.Coverage([("a", "o"), ("b", "n")]),
    }
    for name, other in others.items():
        found[f"names {name}"] = outcome(coverage.check_same_names, grown, other, "cannot merge")
    return found


def added() -> dict[str, Any]:
    """Tiles that do not fit, replicates alone, and the room that films have."""
    aovs = {"albedo": ("R", "G", "B")}
    film = film_of((12, 8), replicates=2, spp=0, aovs=aovs)
    plane = np.arange(192).reshape(8, 4, 3, 2)
    part = PartialFilm(
        8,
        0,
        np.arange(384).reshape(8, 4, 2, 3, 2),
        np.ones((8, 4, 2), np.int64),
        1,
        2,
        (0, 2),
        {"albedo": plane},
    )
    alone = part._replace(sums=part.sums[:, :, :1], counts=part.counts[:, :, :1])
    parts = {
        "good": part,
        "replicate 1": alone._replace(replicate=1, ranges=(2, 1)),
        "replicate 2": alone._replace(replicate=2),
        "shape": alone,
        "no AOVs": part._replace(aovs=None),
        "AOVs": part._replace(aovs={"depth": plane}),
        "left": part._replace(x0=-1),
        "right": part._replace(x0=16),
        "below": part._replace(y0=8),
        "askew": part._replace(x0=7),
        "coverage": part._replace(coverage=coverage.no_sums()),
        "many": part._replace(counts=part.counts + (1 << 40)),
    }
    found: dict[str, Any] = {}
    for name, one in parts.items():
        answer = outcome(film.add_tile, one)
        found[name] = [answer, described(film.counts), described(film.aov("albedo"))]
    found["shapes"] = [
        outcome(tiles.check_shape, *values)
        for values in (
            (4, 3, None, 2),
            (0, 3, None, 2),
            (4, 3, (1, 1, 3, 2), 1),
            (4, 3, (1, 1, 4, 2), 1),
            (4, 3, (0, 0, 1), 1),
            (4, 3, (0, 0, 1, "1"), 1),
            (4, 3, None, 0),
            (4.5, 3, None, 1),
        )
    ]
    even, uneven = film_of((16, 8), spp=8), film_of((16, 8), spp=8)
    uneven.add_tile(
        part._replace(
            x0=0,
            sums=np.ones((8, 8, 4, 3, 2), np.int64),
            counts=np.ones((8, 8, 4), np.int64),
            ranges=(8, 4),
            aovs=None,
        )
    )
    found["spp"] = [
        outcome(merging.check_samples, one, spp) for one in (even, uneven) for spp in (8, 9)
    ]
    found["biases"] = [
        ledger.Bias("a", "b", effect, error).line
        for effect, error in ((None, None), (0.0, None), (0.02, 0.1), (-0.3, None))
    ]
    return found


def archives() -> dict[str, Any]:
    """Archives: what they keep, and what is wrong with a file."""
    arrays = {
        "none": np.zeros((0, 3), np.int64),
        "even": np.full((3, 5), -7, np.int64),
        "small": np.arange(6, dtype=np.uint8),
        "floats": np.linspace(0, 1, 7).astype(np.float32),
        "noise": np.random.default_rng(1).integers(-(1 << 40), 1 << 40, 999),
    }
    found: dict[str, Any] = {}
    with in_folder({"text.alight": "hello", "folder/a": "x"}):
        path = Path("a.alight")
        archive.write_archive(path, {"a": [1, None]}, arrays)
        data = path.read_bytes()
        found["read"] = described(archive.read_archive(path))
        start = len(archive.MAGIC) + 32

        def signed(body: bytes) -> bytes:
            return archive.MAGIC + hashlib.sha256(body).digest() + body

        for name, changed in {
            "cut": data[:-1],
            "short": data[:9],
            "bit": data[:-1] + bytes([data[-1] ^ 1]),
            "empty": b"",
            "version": signed(b"\xff" + data[start + 1 :]),
            "other": b"x" + data[1:],
        }.items():
            path.write_bytes(changed)
            found[name] = outcome(archive.read_archive, path)
        for name in ("none.alight", "folder", "text.alight", 3):
            found[str(name)] = outcome(archive.read_archive, name)
        found["type"] = outcome(archive.write_archive, path, {}, {"x": np.zeros(2, np.complex64)})
        first, second = film_of(spp=8), film_of(spp=8, seed=2)
        described_films, held = storage.pack_films([first, second])
        archive.write_archive(path, {"films": described_films}, held)
        found["two"] = outcome(Film.load, path)
        archive.write_archive(path, {"films": described_films[:1]}, held)
        found["one"] = described(Film.load(path).image)
        for key in ("width", "seed", "replicates"):
            broken = [{k: v for k, v in described_films[0].items() if k != key}]
            archive.write_archive(path, {"films": broken}, held)
            found[f"no {key}"] = outcome(lambda: described(Film.load(path).image))
    return found


def denoised() -> dict[str, Any]:
    """What a denoiser is given, and what is said of what it did; a stand-in brightens."""
    asked: list[Any] = []

    def run(noisy: np.ndarray, **features: Any) -> np.ndarray:
        asked.append([described(noisy), described(features)])
        return noisy * 1.25

    package, module = ModuleType("pyoidn"), SimpleNamespace(denoise=run)
    aovs = {"albedo_through": ("R", "G", "B"), "normal_through": ("X", "Y", "Z")}
    stubs = {"pyoidn": package, "pyoidn.denoise": module}
    found: dict[str, Any] = {}
    with (
        mock.patch.dict(sys.modules, stubs),
        mock.patch("importlib.util.find_spec", lambda name: name),
        mock.patch("importlib.metadata.version", lambda name: f"1 of {name}"),
    ):
        for name, film in {
            "plain": film_of((5, 4)),
            "one": film_of((5, 4), aovs={"normal_through": aovs["normal_through"]}),
            "both": film_of((5, 4), aovs=aovs),
            "black": film_of((5, 4), spp=0),
        }.items():
            picture, bias = denoising.denoise(film)
            kept = {
                key: text for key, text in picture.attributes.items() if key in ("error", "biases")
            }
            found[name] = [described(picture.image), sorted(picture.layers), kept, bias.line]
            found[name].append(described(picture.layers["noisy.R"]))
        found["asked"] = asked
        found["no film"] = outcome(denoising.denoise, "a.alight")
    with (
        mock.patch("importlib.util.find_spec", lambda name: None),
        mock.patch("alight.films.denoising.install_command", lambda *words: " ".join(words)),
    ):
        found["no denoiser"] = outcome(denoising.check_denoiser)
    return found


def pictures() -> dict[str, Any]:
    """EXR files with windows, primaries and channels of their own, and files that cannot be."""
    import OpenEXR

    plane = np.arange(12, dtype=np.float32).reshape(3, 4)
    windows = {
        "same": ((2, 1, 5, 3), (2, 1, 5, 3)),
        "inside": ((2, 1, 5, 3), (0, 0, 7, 4)),
        "over": ((-2, -1, 1, 1), (0, 0, 3, 3)),
        "beside": ((9, 9, 12, 11), (0, 0, 3, 3)),
        "cut": ((1, 1, 4, 3), (2, 2, 3, 3)),
    }
    sets = {
        "Rec. 709": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
        "other white": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.34, 0.35),
        "Rec. 2020": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329),
        "ACES": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767),
        "own": (0.6, 0.3, 0.3, 0.5, 0.2, 0.1, 0.3, 0.3),
        "flat": (0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3),
    }
    channels = {
        "RGB": {c: plane + i for i, c in enumerate("RGB")},
        "Y": {"Y": plane, "A": plane},
        "one": {"depth": plane},
        "two": {"a": plane, "b": plane},
        "RG": {"R": plane, "G": plane},
    }
    found: dict[str, Any] = {}
    path = Path("a.exr")

    def written(header: dict[str, Any], held: dict[str, np.ndarray]) -> Any:
        with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, **header}, held) as file:
            file.write(str(path))
        told: list[str] = []
        answer = outcome(texels.read_texels, path, lambda width, height: None, told.append)
        return [answer, told]

    with in_folder(
        {
            "b.exr": b"v/1\x01\x02\0\0\0x",
            "c.exr": "x",
            "folder/x": "",
            "d.pfm": "Pf\n0 3\n-1\n",
            "e.hdr": "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd",
            "f.hdr": "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\nabcd",
        }
    ):
        for name, (data, display) in windows.items():
            header = {
                "dataWindow": (data[:2], data[2:]),
                "displayWindow": (display[:2], display[2:]),
            }
            found[name] = written(header, {"Y": plane})
        for name, held in channels.items():
            found[f"channels {name}"] = written({}, held)
        for name, numbers in sets.items():
            written({"chromaticities": tuple(numbers)}, channels["RGB"])
            found[f"primaries {name}"] = outcome(primaries.foreign_primaries, path)
        for name in ("b.exr", "c.exr", "folder", "d.pfm", "e.hdr", "f.hdr", "none.exr"):
            found[f"broken {name}"] = [
                str(outcome(read, Path(name)))[:90]
                for read in (image.read_image, primaries.foreign_primaries)
            ]
        found["numbers"] = outcome(exr.read, path)
    return found


def beside() -> dict[str, Any]:
    """Temporary files: those of writers that are gone are removed, others stay."""
    here = atomic._machine()
    gone = 2**22 - 3
    names = [
        f".alight-{here}-{gone}-a.tmp",
        f".alight-{here}-{os.getpid()}-b.tmp",
        f".alight-elsewhere-{gone}-c.tmp",
        f".alight-{here}-word-d.tmp",
        "mine.tmp",
    ]
    with in_folder(dict.fromkeys(names, "x") | {"folder/x": ""}) as folder:
        with mock.patch("os.kill", _kill_of(gone)):
            atomic.remove_abandoned(folder)
            running = [atomic._is_running(number) for number in (gone, 1, 7)]
        left = [
            name.replace(here, "HERE").replace(str(os.getpid()), "ME")
            for name in sorted(path.name for path in folder.iterdir())
        ]
        found = [
            outcome(atomic.check_folder, name) for name in ("folder", "none/a", "new", "mine.tmp")
        ]
        with mock.patch("os.access", lambda path, how: False):
            found.append(outcome(atomic.check_folder, "mine.tmp"))
    return {"left": left, "running": running, "folders": found}


def _kill_of(gone: int) -> Any:
    def kill(process: int, number: int) -> None:
        if process == gone:
            raise ProcessLookupError
        if process == 1:
            raise PermissionError

    return kill


CASES = {
    "tables": tables,
    "added": added,
    "archives": archives,
    "denoised": denoised,
    "pictures": pictures,
    "beside": beside,
}
