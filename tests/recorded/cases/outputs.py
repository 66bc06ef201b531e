"""Files of pictures, read by other readers, and what a display shows."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from alight.outputs import apng, cryptomatte, exr, hdr, html, moving, pfm, png, white_balance, wraps
from alight.outputs.display import Display
from alight.outputs.image import FORMATS, read_image, read_picture, write_image
from alight.outputs.picture import Picture, as_picture
from alight.outputs.primaries import foreign_primaries
from alight.outputs.texels import read_texels
from tests.recorded.making import described, film_of, in_folder, outcome, rows


def picture(h: int = 9, w: int = 13) -> np.ndarray:
    """Uneven, with the odd pixel that no display can show."""
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    made = np.stack([x / w, (y / h) ** 2 * 3, 0.1 + 0.05 * x * y / h], -1).astype(np.float32)
    made[2, 3], made[4, 5], made[5, 6], made[6, 7] = (
        [-0.2, 0.4, 7],
        [np.nan, 0.2, 1],
        [np.inf, 0, 0.5],
        400,
    )
    return made


def layered() -> Picture:
    """A picture with alpha, shadow and layers."""
    image = np.nan_to_num(picture(), nan=0.2, posinf=3.0)
    alpha = np.linspace(0, 1, image[..., 0].size).reshape(image.shape[:2]).astype(np.float32)
    return Picture(image * alpha[..., None], alpha=alpha, shadow=0.3 * (1.0 - alpha))


DISPLAYS: dict[str, dict[str, Any]] = {
    "plain": {},
    "brighter": {"exposure": 1.5},
    "auto": {"exposure": "auto"},
    "aces": {"tone_map": "aces", "exposure": -0.5},
    "hable": {"tone_map": "hable"},
    "agx": {"tone_map": "agx"},
    "reinhard": {"tone_map": "reinhard"},
    "warm": {"white_balance": "3200K"},
    "by colour": {"white_balance": "1,0.8,0.6"},
    "auto white": {"white_balance": "auto"},
    "16 bits": {"bits": 16, "dpi": 144},
}


def displays() -> dict[str, Any]:
    """What a display shows of linear values."""
    found: dict[str, Any] = {}
    for name, words in DISPLAYS.items():
        display = Display(**words)
        found[name] = [
            described(display.apply(picture())),
            described(display.developed(picture()), 9),
        ]
    found["black"] = [described(Display(**w).apply(np.zeros((2, 2, 3)))) for w in DISPLAYS.values()]
    wrong = {
        "exposure": {"exposure": 101},
        "nan": {"exposure": float("nan")},
        "word": {"exposure": "bright"},
        "bits": {"bits": 10},
        "curve": {"tone_map": "acess"},
        "white": {"white_balance": "blue"},
    }
    found["wrong"] = {name: outcome(lambda w=w: Display(**w)) for name, w in wrong.items()}
    texts = (
        "none",
        "auto",
        "1000K",
        "3200K",
        "6504 K",
        "40000K",
        "900K",
        "1,1,1",
        "1,0.8",
        "0,0,0",
        "-1,1,1",
        "1, 2, .5",
        "K",
    )
    found["whites"] = rows(white_balance.parse_white, list(texts))
    found["black bodies"] = [
        white_balance.black_body_white(t) for t in (1200.0, 2856.0, 6504.0, 20000.0)
    ]
    found["adaptation"] = white_balance.adaptation(np.array([1.0, 0.7, 0.4])).tolist()
    found["grey world"] = [
        described(white_balance.grey_world(p)) for p in (picture()[:2], np.zeros((2, 2, 3)))
    ]
    return found


def _by_pillow(path: str) -> dict[str, Any]:
    from PIL import Image

    with Image.open(path) as image:
        image.load()
        info = {k: v for k, v in image.info.items() if k not in ("exif", "icc_profile")}
        return {
            "mode": image.mode,
            "size": list(image.size),
            "format": image.format,
            "info": described(info),
            "pixels": described(np.asarray(image).astype(np.float64), 12),
        }


def _by_openexr(path: str) -> dict[str, Any]:
    import OpenEXR

    with OpenEXR.File(path, separate_channels=True) as file:
        header = {k: described(str(v)) for k, v in sorted(file.header().items()) if k != "channels"}
        channels = {
            k: described(np.asarray(c.pixels), 9) for k, c in sorted(file.channels().items())
        }
        types = {k: str(c.pixels.dtype) for k, c in sorted(file.channels().items())}
    return {"header": header, "channels": channels, "types": types}


def files() -> dict[str, Any]:
    """Every format, as others read it."""
    from tests.recorded.cases.films import with_everything

    sources = {
        "array": picture(),
        "layered": layered(),
        "film": film_of((9, 7)),
        "all": with_everything(),
    }
    found: dict[str, Any] = {
        "formats": [
            [m.__name__, m.SUFFIXES, m.IS_DISPLAY, m.KEEPS_LAYERS, m.KEEPS_ALPHA, m.KEEPS_DPI]
            for m in FORMATS
        ]
    }
    with in_folder() as folder:
        for name, source in sources.items():
            for suffix in ("png", "exr", "npy", "pfm", "hdr"):
                path = f"{name}.{suffix}"
                write_image(path, source)
                read = {"png": _by_pillow, "exr": _by_openexr}.get(suffix)
                own = described(read_image(path), 12)
                found[path] = [read(path) if read else described(Path(path).read_bytes()[:60]), own]
            found[f"{name} as a picture"] = described(vars(read_picture(f"{name}.exr")))
        write_image("a.jpg", layered(), exposure=0.5, dpi=72)
        with_jpeg = _by_pillow("a.jpg")
        # Codecs differ by a level.
        found["a.jpg"] = [
            with_jpeg["mode"],
            with_jpeg["size"],
            with_jpeg["info"].get("dpi"),
            round(with_jpeg["pixels"]["numbers"][2] / 4),
        ]
        for name, words in DISPLAYS.items():
            write_image(f"{name}.png", picture(), **words)
            found[f"{name}.png"] = _by_pillow(f"{name}.png")
        for size in ((1, 1), (1, 40), (30, 1)):
            write_image("s.png", picture(50, 50)[: size[0], : size[1]])
            found[f"size {size}"] = _by_pillow("s.png")["pixels"]
        found["refused"] = {
            n: outcome(write_image, n, picture())
            for n in ("a.tif", "a", "none/a.png", "a.pngg", ".png", "a.PNG")
        }
        found["shapes"] = [
            outcome(lambda s=s: described(vars(as_picture(np.ones(s)))))
            for s in ((3, 4), (3, 4, 3), (3, 4, 1), (3, 4, 4), (3,), (0, 4, 3))
        ]
        broken = {
            "text.png": b"hello",
            "cut.exr": b"v/1\x01",
            "empty.npy": b"",
            "cut.hdr": b"#?RADIANCE\n\n",
            "cut.pfm": b"PF\n3 4\n-1.0\n",
            "cut.jpg": b"\xff\xd8\xff",
        }
        for name, data in broken.items():
            Path(name).write_bytes(data)
        found["broken"] = {
            n: str(outcome(read_image, n))[:90] for n in (*broken, "none.png", "x.abc")
        }
        found["headers"] = [
            described(exr.read_size("all.exr")),
            described(hdr.read_size(Path("all.hdr"))),
            described(pfm.read_size(Path("all.pfm"))),
        ]
        found["layers"] = [
            sorted(exr.read_layers("all.exr")[0]),
            described(exr.read_layers("all.exr")[1]),
        ]
        found["primaries"] = described(foreign_primaries(Path("all.exr")))
        found["wraps"] = outcome(wraps.read_wraps, Path("all.exr"))
        found["texels"] = {
            n: outcome(lambda n=n: described(read_texels(Path(n), lambda w, h: None)))
            for n in (
                "array.png",
                "16 bits.png",
                "array.exr",
                "layered.png",
                "array.hdr",
                "array.pfm",
                "array.npy",
            )
        }
        found["left"] = sorted(p.name for p in folder.iterdir() if p.name.startswith("."))
    return found


def animations() -> dict[str, Any]:
    """Moving pictures, frame by frame as Pillow reads them."""
    from PIL import Image, ImageSequence

    frames = [
        np.uint8(np.clip(40 * n + 20 * np.nan_to_num(picture()[:6, :8], posinf=2), 0, 255))
        for n in range(4)
    ]
    found: dict[str, Any] = {}
    with in_folder():
        for path, fps in (("a.apng", 24), ("b.apng", 7), ("a.gif", 24), ("b.gif", 90)):
            moving.write_moving(Path(path), iter(frames), fps, len(frames))
            with Image.open(path) as image:
                seen = [
                    [
                        described(
                            np.asarray(f.convert("RGB"))
                            .astype(np.float64)
                            .mean(axis=(0, 1))
                            .round(1)
                        ),
                        f.info.get("duration"),
                    ]
                    for f in ImageSequence.Iterator(image)
                ]
                found[path] = [image.n_frames, image.size, image.info.get("loop"), seen]
        with moving.MovingFile(Path("c.apng"), 10, 2) as made:
            made.add(frames[0])
            made.add(frames[3])
        found["two"] = described(np.frombuffer(Path("c.apng").read_bytes(), np.uint8).size > 100)
        found["chunks"] = _chunks(Path("c.apng").read_bytes())
        apng.write(Path("d.apng"), iter(frames[:1]), 30, 1)
        found["one"] = _chunks(Path("d.apng").read_bytes())
        found["short"] = outcome(apng.write, Path("e.apng"), iter(frames[:1]), 30, 3)
    found["plays"] = [
        [n, f, moving.played_fps(Path(n), f)]
        for n in ("a.gif", "a.GIF", "a.mp4", "a.apng")
        for f in (1, 7, 24, 30, 50, 60, 90)
    ]
    found["moves"] = [
        moving.is_moving(Path(n)) for n in ("a.gif", "a.MP4", "a.png", "a.apng", "a.webp")
    ]
    return found


def _chunks(data: bytes) -> list[Any]:
    found, at = [], 8
    while at < len(data):
        size, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8].decode()
        found.append(
            [kind, data[at + 8 : at + 8 + size].hex() if kind in ("IHDR", "acTL", "fcTL") else ""]
        )
        at += 12 + size
    return found


def parts() -> dict[str, Any]:
    """Encodings of single values, and HTML."""
    values = np.array(
        [[0, 0, 0], [1, 1, 1], [0.3, 1e-9, 5e3], [1e-40, 0, 0], [3e38, 1, 0], [0.999, 0.5, 0.2]],
        np.float32,
    )
    coded = hdr.encode_rgbe(values[None])
    data = png.encode_png(np.nan_to_num(picture()[:3, :4]).clip(0, 1), bits=8)
    from PIL import Image

    with Image.open(io.BytesIO(data)) as image:
        shown = np.asarray(image).astype(np.int64)
    ids = np.array([[[5, 9, 0, 0, 0, 0]]], np.uint32)
    return {
        "rgbe": coded.tolist(),
        "decoded": hdr.decode_rgbe(coded),
        "png": shown.tolist(),
        "chunks": _chunks(data),
        "html": [
            html.paragraph("a < b & c"),
            html.preformatted(["a", "<b>"]),
            html.preformatted([]),
            html.table([("a", 1), ("b", "<2>")], ("x", "y"), "cap & tion"),
            html.table([]),
            html.picture(b"png", 'na"me', 30),
            html.division("a", "", "b"),
        ],
        "figure": html.figure(picture()[:3, :4], "cap<tion", "auto").partition("base64,")[0],
        "planes": described(
            cryptomatte.planes_of(
                "cryptomatte_object", ids, np.ones(ids.shape, np.float32) * [0.5, 0.25, 0, 0, 0, 0]
            )
        ),
    }


CASES = {"displays": displays, "files": files, "animations": animations, "parts": parts}
