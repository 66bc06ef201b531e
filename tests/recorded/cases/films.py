"""Films: what they say of their samples, what is kept of them, what does not fit together."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.films import Film, PartialFilm, fixed_point, ledger, merging, notebook, storage
from alight.films.archive import pack_archive, unpack_archive
from alight.films.coverage import SurfaceSums
from alight.films.mattes import MATTES, header_of, planes_of, ranks_of
from alight.films.sample_ranges import SampleRanges, cells_of, cells_with
from alight.outputs import cryptomatte
from tests.recorded.making import (
    add_samples,
    add_values,
    described,
    film_of,
    in_folder,
    outcome,
    rows,
)

AOVS = {"albedo": ("R", "G", "B"), "depth": ("Z",), "alpha": ("A",), "id": ("S", "T", "M")}


def with_everything() -> Film:
    """A film with layers, mattes, a window, and samples that are none."""
    film = Film(
        29,
        19,
        crop=(3, 5, 22, 13),
        replicates=3,
        seed=9,
        aovs={**AOVS, **dict.fromkeys(MATTES, ())},
        surfaces=[("house/door", "oak"), ("house/wall", "chalk"), ("ball", "oak"), ("", "")],
        scene_hash="5ce7e",
        options={"type": "path", "max_depth": 7},
        fingerprint="f",
        version="v",
    )
    draw = np.random.default_rng(5)
    values = draw.random((5, 13, 22, 3)).astype(np.float32) ** 3 * [1.0, 0.2, 4.0]
    values[1, 2, 3, 0], values[4, 4, 4, 2], values[0, 0, 0, 1] = np.nan, np.inf, 3e11
    limbs, invalid, saturated = fixed_point.to_limbs(values.astype(np.float32))
    sums, counts = np.zeros((13, 22, 3, 3, 2), np.int64), np.zeros((13, 22, 3), np.int64)
    for i in range(5):
        sums[:, :, i % 3] += limbs[i]
        counts[:, :, i % 3] += 1
    pixels = draw.integers(0, 13 * 22, 500)
    weights = fixed_point.to_limbs(draw.random(500))[0]
    coverage = SurfaceSums.gathered(pixels, draw.integers(0, 4, 500), weights)
    whole = limbs.sum(axis=0)
    layers = {n: np.ascontiguousarray(whole[..., : len(c), :]) for n, c in AOVS.items()}
    film.add_tile(
        PartialFilm(
            3,
            5,
            sums,
            counts,
            int(invalid.any(-1).sum()),
            int(saturated.sum()),
            (0, 5),
            layers,
            coverage,
        )
    )
    film.recorded = (ledger.Bias("depth", "paths end after 7 edges", 0.01, 0.002),)
    film.stats = {"seconds": {"render": 1.5}, "spp": 5.0, "rays": 12}
    film.scene_warnings = ("it is dark",)
    return film


def _facts(film: Film) -> dict[str, Any]:
    return {
        "mean": described(film.mean),
        "image": described(film.image),
        "error": described(film.standard_error),
        "counts": described(film.sample_count),
        "spp": film.spp,
        "layers": {n: described(film.aov(n)) for n in film.aov_channels},
        "alpha": described(film.alpha),
        "alpha error": described(film.alpha_error),
        "biases": [described(b) for b in film.biases],
        "lines": [b.line for b in film.biases],
        "states": [b.state() for b in film.biases],
        "warnings": film.warnings,
        "provenance": described(film.provenance),
        "unsure": described(film.unsure),
        "cells": sorted({repr(c) for c in film.cells.ravel()}),
        "invalid": film.invalid,
        "saturated": film.saturated,
        "repr": repr(film) if "0x" not in repr(film) else "",
    }


def readings() -> dict[str, Any]:
    """What films say of their samples."""
    films = {
        "everything": with_everything(),
        "plain": film_of(),
        "no samples": film_of(spp=0),
        "one replicate": film_of(replicates=1),
        "uneven": film_of(spp=7, size=(9, 4)),
        "layers": film_of(aovs={"direct": ("R", "G", "B"), "indirect": ("R", "G", "B")}, spp=4),
    }
    found = {name: outcome(_facts, film) for name, film in films.items()}
    black = Film(5, 4)
    add_values(black, np.zeros((4, 4, 5, 3), np.float32), 0)
    found["black"] = outcome(_facts, black)
    film = films["everything"]
    found["masks"] = rows(
        lambda name, layer: film.mask(name, layer),
        [
            (n, one)
            for n in ("house", "house/door", "ball", "oak", "hous", "")
            for one in (*MATTES, "x")
        ],
    )
    found["ranks"] = [described(ranks_of(film, layer)) for layer in MATTES]
    found["planes"] = described(planes_of(film))
    found["header"] = header_of(film)
    found["unknown layer"] = outcome(film.aov, "albeda")
    picture = film.picture()
    found["picture"] = described({k: v for k, v in vars(picture).items() if not k.startswith("_")})
    found["without layers"] = sorted(vars(film.picture(layers=False)))
    return found


def kept() -> dict[str, Any]:
    """Files of films, read by the archive's reader, and as pictures."""
    found: dict[str, Any] = {}
    film = with_everything()
    films, arrays = storage.pack_films([film, film_of((5, 3))])
    found["packed"] = described(films)
    found["arrays"] = {k: described(v, 6) for k, v in arrays.items()}
    data = b"".join(pack_archive({"films": films}, arrays))
    archive = unpack_archive("it", memoryview(data))
    found["content is the same"] = described(archive.content) == described({"films": films})
    found["bytes"] = len(data) // 100
    broken = {
        "short": data[:40],
        "text": b"hello",
        "empty": b"",
        "changed": data[:90] + b"?" + data[91:],
        "longer": data + b"x",
        "version": data[:48] + b"\x07" + data[49:],
    }
    found["broken"] = {k: outcome(unpack_archive, "it", memoryview(v)) for k, v in broken.items()}
    with in_folder(broken) as folder:
        film.save("a.alight")
        again = Film.load("a.alight")
        found["read"] = _facts(again)
        found["same sums"] = bool(np.array_equal(again.sums, film.sums))
        found["refused"] = {n: outcome(Film.load, n) for n in (*broken, "none.alight", ".")}
        found["saved"] = {
            name: outcome(film.save, name)
            for name in ("a.exr", "a.png", "a.txt", "none/a.exr", "a.npy", "a", "a.jpg")
        }
        found["files"] = sorted(p.name for p in folder.iterdir())
    return found


def merged() -> dict[str, Any]:
    """Films that fit together, and those that do not."""
    one = film_of(spp=6, scene_hash="a", options={"x": 1})
    others = {
        "more": {"spp": 0},
        "seed": {"seed": 2},
        "size": {"size": (21, 14)},
        "crop": {"crop": (0, 0, 9, 9)},
        "replicates": {"replicates": 5},
        "scene": {"scene_hash": "b"},
        "options": {"options": {"x": 2, "y": 1}},
        "fingerprint": {"fingerprint": "other"},
        "aovs": {"aovs": {"depth": ("Z",)}},
        "surfaces": {"surfaces": [("a", "b")]},
        "version": {"version": "9"},
    }
    found = {}
    for name, words in others.items():
        given = {"scene_hash": "a", "options": {"x": 1}, "spp": 0, **words}
        other = film_of(**{**given, "spp": 0})
        if name not in ("more", "surfaces"):
            add_samples(other, 6, 3)
        found[name] = outcome(lambda other=other: _facts(Film.merge(one, other)))
    found["twice"] = outcome(Film.merge, one, one)
    found["named"] = outcome(merging.merge, [one, film_of(seed=4)], ["a.alight", "b.alight"])
    found["none"] = outcome(Film.merge)
    found["alone"] = outcome(lambda: _facts(Film.merge(one)))
    copy = one.snapshot()
    add_samples(one, 6, 2)
    found["snapshot"] = [copy.spp, one.spp, one.empty_like().spp]
    return found


def refused() -> dict[str, Any]:
    """Shapes and tiles that cannot be."""
    shapes = {
        "width": (0, 3),
        "negative": (4, -1),
    }
    found = {n: outcome(lambda s=s: described(Film(*s).crop)) for n, s in shapes.items()}
    for name, words in {
        "crop": {"crop": (1, 1, 9, 9)},
        "empty crop": {"crop": (1, 1, 0, 2)},
        "replicates": {"replicates": 0},
        "many": {"replicates": 2000},
        "channels": {"channels": ("R",)},
    }.items():
        found[name] = outcome(lambda words=words: described(Film(8, 4, **words).crop))
    tiles = {
        "outside": (8, 0, 8, 8, (0, 4)),
        "within": (4, 0, 8, 8, None),
        "askew": (4, 0, 8, 8, (0, 4)),
        "twice": (0, 0, 8, 8, (2, 4)),
        "shape": (0, 0, 8, 9, (9, 4)),
        "good": (0, 0, 8, 8, (7, 4)),
        "negative": (0, 0, 8, 8, (-1, 4)),
    }
    for name, (x, y, w, h, ranges) in tiles.items():
        film = film_of((12, 8), spp=4)

        def add(
            film: Film = film, x: int = x, y: int = y, w: int = w, h: int = h, r: Any = ranges
        ) -> Any:
            film.add_tile(
                PartialFilm(
                    x, y, np.ones((h, w, 4, 3, 2), np.int64), np.ones((h, w, 4), np.int64), 0, 0, r
                )
            )
            return [film.spp, [repr(c) for c in film.cells.ravel()]]

        found[f"tile {name}"] = outcome(add)
    marked = film_of((20, 9), crop=(0, 0, 10, 9), spp=0)
    marked.mark_samples(3, 5)
    marked.mark_samples(8, 1)
    found["marked"] = [repr(c) for c in marked.cells.ravel()]
    found["twice marked"] = outcome(marked.mark_samples, 4, 1)
    return found


def ranges() -> dict[str, Any]:
    """Sets of samples, and cells."""
    sets = [
        [(0, 4)],
        [(4, 9), (0, 2)],
        [(2, 4), (10, 12), (4, 5)],
        [],
        [(5, 5)],
        [(3, 1)],
        [(0, 3), (2, 5)],
    ]
    found: dict[str, Any] = {
        "made": rows(
            lambda s: [repr(SampleRanges(s)), str(SampleRanges(s)), SampleRanges(s).count],
            {repr(s): (s,) for s in sets},
        )
    }
    good = [SampleRanges(s) for s in sets[:5]]
    found["overlaps"] = [[repr(a.overlap(b)) for b in good] for a in good]
    found["unions"] = [[str(outcome(a.union, b)) for b in good] for a in good]
    found["cells"] = [
        str(cells_of(*w)) for w in ((0, 0, 8, 8), (7, 3, 2, 30), (16, 8, 1, 1), (5, 5, 0, 0))
    ]
    pairs = np.array([[[0, 4], [2, 3]], [[9, 0], [0, 4]]])
    found["with"] = [repr(c) for c in cells_with(pairs).ravel()]
    return found


def numbers() -> dict[str, Any]:
    """Fixed point, ids of mattes, biases in words."""
    values = np.array(
        [0, 1, -1, 1e-9, 3.14159, -2.5e5, 6e10, 7e10, -9e10, np.nan, np.inf, 2.0**-20], np.float32
    )
    limbs, invalid, saturated = fixed_point.to_limbs(values)
    many = limbs * 1001
    fixed_point.carry(many)
    biases = [
        ledger.Bias("a", "something"),
        ledger.Bias("b", "dark", -0.25),
        ledger.Bias("c", "bright", 1e-5, 3e-6),
        ledger.Bias("d", "both", 0.4, 0.1),
    ]
    return {
        "limbs": limbs.tolist(),
        "invalid": invalid.tolist(),
        "saturated": saturated.tolist(),
        "carried": many.tolist(),
        "floats": fixed_point.to_float(many),
        "total": fixed_point.total(np.stack([many, many]), 0).tolist(),
        "hashes": [
            cryptomatte.murmur_hash(b, s)
            for b in (b"", b"a", b"house/door", b"1234567")
            for s in (0, 9)
        ],
        "ids": [cryptomatte.id_of(n) for n in ("", "a", "oak", "Größe")],
        "headers": cryptomatte.header_of("cryptomatte_object", ["b", "a"]),
        "colours": cryptomatte.colors_of(np.array([[0, 5, 2**31]], np.uint32)),
        "lines": [b.line for b in biases],
        "relative": [b.relative(0.5).line for b in biases],
        "black": [described(b.relative(0.0)) for b in biases],
        "joined": [described(b) for b in ledger.joined([biases, biases[1:3], ()])],
        "counted": [
            [b.line for b in ledger.counted(i, s, n)]
            for i, s, n in ((0, 0, 5), (1, 0, 9), (7, 3, 9))
        ],
    }


def shown() -> dict[str, Any]:
    """What notebooks show."""
    film = with_everything()
    html = notebook.html_of(film)
    head, _, rest = html.partition("base64,")
    return {
        "html": head + "PNG" + rest.partition('"')[2],
        "warnings": notebook.html_of_warnings(film),
        "repr": film._repr_html_().count("<"),
    }


CASES = {
    "readings": readings,
    "kept": kept,
    "merged": merged,
    "refused": refused,
    "ranges": ranges,
    "numbers": numbers,
    "shown": shown,
}
