"""Reading pictures as they are stored: whole numbers stay encoded, one grey channel stays one.

Pictures stand upright, as their EXIF data ask for (CIPA DC-008, tag 274), and OpenEXR files fill
their display windows. The first bytes of a file determine its format, not its name.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from alight.outputs import exr, hdr, npy, pfm

SUFFIXES = (
    ".png", ".jpg", ".jpeg", ".exr", ".hdr", ".pfm", ".npy", ".bmp", ".tga", ".tif", ".tiff",
    ".webp",
)  # fmt: skip
#: What messages call them.
KINDS = "PNG, JPEG, WebP, EXR, HDR, PFM, NPY, BMP, TGA or TIFF"

#: The library reads all channels of an EXR file at once; this is 1 GB.
MOST_NUMBERS = 2**28

#: Blocks of 16 MB that Pillow keeps for the next picture: as many as one of 4096 x 4096 takes. New
#: memory costs five times as much time as decoding a JPEG file into it.
KEPT_BLOCKS = 5
#: Rows that are copied from Pillow's memory at once.
STRIP = 64

#: Called with width and height before memory is asked for; raises ValueError to refuse.
SizeCheck = Callable[[int, int], None]

#: Called with what was changed in a picture.
Tell = Callable[[str], None]

#: What makes pictures upright, by their EXIF orientation: whether rows become columns, and whether
#: then the rows, and the columns, are reversed.
ORIENTATION = 0x0112
_UPRIGHT = {
    2: (False, False, True), 3: (False, True, True), 4: (False, True, False),
    5: (True, False, False), 6: (True, False, True), 7: (True, True, True), 8: (True, True, False),
}  # fmt: skip


def _nobody(text: str) -> None:
    """Ignore it."""


def read_texels(path: Path, check_size: SizeCheck, tell: Tell = _nobody) -> np.ndarray:
    """Read a picture.

    Parameters
    ----------
    path : Path
        PNG, JPEG, WebP, BMP, TGA, TIFF (uint8, uint16), OpenEXR, Radiance, PFM or NPY (float) file.
    check_size : callable
        Refuses sizes.
    tell : callable, optional
        Told what was changed: a picture turned upright, pixels put into a display window.

    Returns
    -------
    ndarray, shape (h, w) or (h, w, c)
        Top row first; alpha may be the last of 2 or 4 channels.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, is of another kind, or is broken.
    """
    if path.exists() and not path.is_file():
        raise ValueError("is not a file")
    with path.open("rb") as file:
        start = file.read(8)
    readers = [read for magic, read in _READERS if start.startswith(magic)]
    if not readers and path.suffix.lower() == ".tga":
        # The one kind whose files do not say what they are.
        readers = [_read_targa]
    if not readers:
        raise ValueError(f"is not a {KINDS} picture")
    try:
        return readers[0](path, check_size, tell)
    except (OSError, ValueError):
        raise
    except MemoryError:
        raise ValueError("takes more memory than there is") from None
    except Exception as error:
        # Decoders meet broken files in many ways: SyntaxError, struct.error, TokenError, ...
        raise ValueError(f"is broken ({error})") from None


def decode_texels(
    data: bytes | memoryview, check_size: SizeCheck, tell: Tell = _nobody
) -> np.ndarray:
    """Decode a PNG, JPEG or WebP picture in memory, as `read_texels` does those in files.

    Raises
    ------
    OSError, ValueError
        If it is of another kind, or broken.
    """
    if not bytes(data[:4]).startswith((b"\x89PNG", b"\xff\xd8\xff", b"RIFF")):
        raise ValueError("is not a PNG, JPEG or WebP picture")
    try:
        return _read_with_pillow(data, check_size, tell, ("PNG", "JPEG", "WEBP"))
    except (OSError, ValueError):
        raise
    except MemoryError:
        raise ValueError("takes more memory than there is") from None
    except Exception as error:
        raise ValueError(f"is broken ({error})") from None


class _Blocks:
    """How many `reusing_memory` are open: Pillow's memory is that of all threads."""

    def __init__(self) -> None:
        self._lock, self._open = threading.Lock(), 0
        # Pillow's, once it keeps memory: while another thread imports Pillow it has none of this.
        self._core: Any = None

    def open(self) -> None:
        with self._lock:
            self._open += 1

    def keep(self, core: Any) -> None:
        """Let Pillow keep memory, where this is wanted."""
        with self._lock:
            if self._open:
                core.set_blocks_max(KEPT_BLOCKS)
                self._core = core

    def close(self) -> None:
        """Give the memory back with the last that is open."""
        with self._lock:
            self._open -= 1
            if not self._open and self._core is not None:
                self._core.set_blocks_max(0)
                self._core.clear_cache()
                self._core = None


_blocks = _Blocks()


@contextmanager
def reusing_memory() -> Iterator[None]:
    """Let pictures that are read inside take the memory of those before them."""
    _blocks.open()
    try:
        yield
    finally:
        _blocks.close()


def _read_targa(path: Path, check_size: SizeCheck, tell: Tell) -> np.ndarray:
    return _read_with_pillow(path, check_size, tell, ("TGA",))


def _read_with_pillow(
    source: Path | bytes | memoryview,
    check_size: SizeCheck,
    tell: Tell,
    formats: tuple[str, ...] = ("PNG", "JPEG", "BMP", "TIFF", "WEBP"),
) -> np.ndarray:
    import io
    import warnings

    from PIL import Image, UnidentifiedImageError

    def opened() -> Any:
        return source.open("rb") if isinstance(source, Path) else io.BytesIO(source)

    with warnings.catch_warnings():
        # Pillow's own limits are above ours, but it reports them before we see the size.
        warnings.simplefilter("ignore")
        _blocks.keep(Image.core)
        try:
            # Of a file by its name, Pillow maps TIFF's grey pixels as wide as they are upright.
            with opened() as file, Image.open(file, formats=formats) as image:
                check_size(*image.size)
                if image.mode == "F":
                    raise ValueError("holds floats: EXR and PFM files may")
                pixels = _pixels_of(image, opened)
                return _upright(pixels, _orientation_of(image), tell)
        except UnidentifiedImageError:
            # Its own words name the open file, as Python writes it.
            raise ValueError("is no picture, or its beginning is damaged") from None
        except Image.DecompressionBombError:
            raise ValueError("has too many pixels") from None


def _orientation_of(image: Any) -> int:
    """How a picture lies that has been decoded; 1, upright, where it does not say, or nonsense."""
    try:
        return int(image.getexif().get(ORIENTATION, 1))
    except (OSError, SyntaxError, ValueError, TypeError, KeyError, struct.error):
        # What cameras and programs note beside a picture does not spoil it.
        return 1


def _upright(pixels: np.ndarray, orientation: int, tell: Tell) -> np.ndarray:
    if orientation not in _UPRIGHT:
        return pixels
    turns, rows, columns = _UPRIGHT[orientation]
    tell(f"turned upright, as its EXIF orientation says ({orientation})")
    pixels = pixels.swapaxes(0, 1) if turns else pixels
    return np.ascontiguousarray(pixels[:: -1 if rows else 1, :: -1 if columns else 1])


def _pixels_of(image: Any, again: Callable[[], Any]) -> np.ndarray:
    if image.mode.startswith("I"):
        return np.asarray(image).astype(np.uint16)
    wide = [tile for tile in image.tile if str(tile[3]).endswith((";16B", "; 16B"))]
    if wide and str(wide[0][3]).startswith("LA"):
        return _grey_of_sixteen_bits(again)
    if wide and image.mode in ("RGB", "RGBA"):
        return _sixteen_bits(image, again)
    if image.mode in ("1", "L"):
        return _as_array(image.convert("L") if image.mode == "1" else image)
    if image.mode in ("LA", "RGBA"):
        return _as_array(image)
    wanted = "RGBA" if "transparency" in image.info else "RGB"
    return _as_array(image if image.mode == wanted else image.convert(wanted))


def _as_array(image: Any) -> np.ndarray:
    """The pixels of an image of 8 bits, in strips: whole, Pillow copies them three times."""
    width, height, channels = *image.size, len(image.getbands())
    shape = (height, width, channels)[: 2 + (channels > 1)]
    pixels = np.zeros(shape, np.uint8)
    for top in range(0, height, STRIP):
        strip = np.asarray(image.crop((0, top, width, min(top + STRIP, height))))
        pixels[top : top + STRIP] = strip
    return pixels


def _sixteen_bits(image: Any, again: Callable[[], Any]) -> np.ndarray:
    """Both bytes of each number.

    Pillow keeps one byte of numbers of 16 bits in colour: the high one, or the low one if it takes
    them for little-endian, which PNG's are not.
    """
    from PIL import Image

    halves = [np.asarray(image, np.uint16)]
    with again() as file, Image.open(file, formats=("PNG",)) as swapped:
        swapped.tile = [t._replace(args=str(t[3]).replace("16B", "16L")) for t in swapped.tile]
        halves.append(np.asarray(swapped, np.uint16))
    return halves[0] << 8 | halves[1]


def _grey_of_sixteen_bits(again: Callable[[], Any]) -> np.ndarray:
    """Grey and alpha: four bytes a pixel, which Pillow takes for those of four channels."""
    from PIL import Image

    with again() as file, Image.open(file, formats=("PNG",)) as image:
        image.tile = [tile._replace(args="RGBA") for tile in image.tile]
        return np.ascontiguousarray(image).view(">u2").astype(np.uint16)


def _read_exr(path: Path, check_size: SizeCheck, tell: Tell) -> np.ndarray:
    data, display, count = exr.read_windows(path)
    width, height = data.size
    check_size(width, height)
    check_size(*display.size)
    if width * height * count > MOST_NUMBERS:
        raise ValueError(f"has too many channels for its size: {count} of {width} x {height}")
    channels, _ = exr.read_layers(path)
    names = [name for name in "RGB" if name in channels]
    if len(names) != 3:
        # Grey pictures have one channel, mostly called Y.
        names = ["Y"] if "Y" in channels else list(channels)
        if len(names) != 1:
            raise ValueError(f"has no channels R, G, B or Y; it has {', '.join(sorted(channels))}")
    first = channels[names[0]]
    texels = np.zeros((*first.shape, len(names)), np.float32)
    for i, name in enumerate(names):
        if channels[name].shape != first.shape:
            raise ValueError("has channels of different sizes")
        # One after the other: the largest pictures fill half of what a process may take.
        texels[..., i] = channels.pop(name)
    return texels if data == display else _in_display_window(texels, data, display, tell)


def _in_display_window(
    texels: np.ndarray, data: exr.Window, display: exr.Window, tell: Tell
) -> np.ndarray:
    """Put the pixels of a file where its display window has them; all around is black."""
    (x, y), (width, height) = data.low, data.size
    left, top = x - display.low[0], y - display.low[1]
    right, bottom = left + width, top + height
    whole = np.zeros((*display.size[::-1], *texels.shape[2:]), texels.dtype)
    shown = whole[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)]
    if not shown.size:
        raise ValueError("has no pixel in its display window")
    first_row, first_column = max(-top, 0), max(-left, 0)
    rows, columns = shown.shape[:2]
    shown[:] = texels[first_row : first_row + rows, first_column : first_column + columns]
    tell(
        f"its {width}x{height} pixels were placed in its display window of "
        f"{display.size[0]}x{display.size[1]}, at {left},{top}"
    )
    return whole


def _read_hdr(path: Path, check_size: SizeCheck, tell: Tell) -> np.ndarray:
    check_size(*hdr.read_size(path))
    return hdr.read(path)


def _read_pfm(path: Path, check_size: SizeCheck, tell: Tell) -> np.ndarray:
    check_size(*pfm.read_size(path))
    return pfm.read(path)


def _read_npy(path: Path, check_size: SizeCheck, tell: Tell) -> np.ndarray:
    array = npy.load_array(path, mapped=True)
    if array.ndim not in (2, 3):
        raise ValueError(f"must have the shape (h, w) or (h, w, 3), got {array.shape}")
    check_size(array.shape[1], array.shape[0])
    return np.array(array)


_READERS: tuple[tuple[bytes, Callable[[Path, SizeCheck, Tell], np.ndarray]], ...] = (
    (b"\x89PNG", _read_with_pillow),
    (b"\xff\xd8\xff", _read_with_pillow),
    (b"\x76\x2f\x31\x01", _read_exr),
    (b"#?", _read_hdr),
    (b"PF", _read_pfm),
    (b"Pf", _read_pfm),
    (b"\x93NUMPY", _read_npy),
    (b"BM", _read_with_pillow),
    (b"II*\x00", _read_with_pillow),
    (b"MM\x00*", _read_with_pillow),
    (b"RIFF", _read_with_pillow),
)
