"""Every format: what is written is read back, and broken files give one clear message."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from alight.core.errors import OutputError
from alight.core.srgb import decode_srgb, encode_srgb
from alight.films import Film, PartialFilm
from alight.films.fixed_point import to_limbs
from alight.outputs import FORMATS, hdr, npy, read_image, write_image
from alight.outputs.exr import read_layers
from alight.outputs.image import read_picture
from alight.outputs.picture import Picture, as_picture


def picture(height=13, width=17):
    rng = np.random.default_rng(1)
    return (rng.lognormal(-1, 2, (height, width, 3))).astype(np.float32)


def film(crop=None):
    film = Film(
        24, 16, crop=crop, aovs={"depth": ("Z",), "albedo": ("R", "G", "B")},
        scene_hash="abc", seed=3, options={"max_depth": 8}, version="9.9", fingerprint="f",
    )  # fmt: skip
    _, _, w, h = film.crop
    values = np.random.default_rng(2).lognormal(-1, 1, (8, h, w, 3)).astype(np.float32)
    limbs, _, _ = to_limbs(values)
    sums = np.stack([limbs[r::4].sum(axis=0) for r in range(4)], axis=2)
    counts = np.full((h, w, 4), 2)
    aovs = {"depth": limbs.sum(axis=0)[:, :, :1], "albedo": limbs.sum(axis=0)}
    film.add_tile(PartialFilm(*film.crop[:2], sums, counts, 0, 0, (0, 8), aovs))
    return film


@pytest.mark.parametrize("suffix", [".exr", ".npy", ".pfm"])
def test_linear_formats_keep_every_bit(tmp_path, suffix):
    path = write_image(tmp_path / f"a{suffix}", picture())
    assert read_image(path).tobytes() == picture().tobytes()


def test_suffixes_may_be_upper_case(tmp_path):
    assert read_image(write_image(tmp_path / "A.NPY", picture())).shape == (13, 17, 3)


@pytest.mark.parametrize("exposure", [-3.0, 5.0])
def test_exposure_does_not_change_linear_formats(tmp_path, exposure):
    path = write_image(tmp_path / "a.exr", picture(), exposure=exposure, tone_map="aces")
    assert (read_image(path) == picture()).all()


# ---------------------------------------------------------------------------- EXR


def test_exr_holds_error_aovs_samples_and_provenance(tmp_path):
    made = film()
    made.save(tmp_path / "a.exr")
    channels, attributes = read_layers(tmp_path / "a.exr")
    assert (np.stack([channels[c] for c in "RGB"], axis=-1) == made.image).all()
    error = np.stack([channels[f"standard_error.{c}"] for c in "RGB"], axis=-1)
    assert (error == made.standard_error).all()
    assert channels["samples"].dtype == np.uint32
    assert (channels["samples"] == 8).all()
    assert (channels["depth.Z"] == made.aov("depth")[..., 0]).all()
    assert (channels["albedo.G"] == made.aov("albedo")[..., 1]).all()
    assert (channels["unsure"] == made.interval().unsure).all()
    whole = {"samples", "unsure"}
    assert all(channels[c].dtype == np.float32 for c in channels if c not in whole)
    wanted = {"version": "9.9", "scene_hash": "abc", "seed": "3", "spp": "8.0", "invalid": "0",
              "options": "{'max_depth': 8}", "fingerprint": "f"}  # fmt: skip
    assert wanted.items() <= attributes.items()


def test_unknown_error_stays_unknown_in_exr(tmp_path):
    Film(8, 8).save(tmp_path / "a.exr")
    channels, _ = read_layers(tmp_path / "a.exr")
    assert np.isnan(channels["standard_error.R"]).all()


def test_exr_of_a_crop_knows_its_place(tmp_path):
    import OpenEXR

    film(crop=(8, 3, 5, 7)).save(tmp_path / "a.exr")
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        header = file.header()
        window = [tuple(int(v) for v in corner) for corner in header["dataWindow"]]
        display = [tuple(int(v) for v in corner) for corner in header["displayWindow"]]
    assert window == [(8, 3), (12, 9)]
    assert display == [(0, 0), (23, 15)]


def test_grey_exr_is_read(tmp_path):
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    grey = picture()[..., 0].copy()
    with OpenEXR.File(header, {"Y": grey}) as file:
        file.write(str(tmp_path / "a.exr"))
    assert (read_image(tmp_path / "a.exr") == grey[..., None]).all()


# ---------------------------------------------------------------------------- PNG, JPEG


def test_png_values_are_srgb_rounded_to_nearest(tmp_path):
    linear = np.array([[0.0, 0.0031308, 0.5], [1.0, 2.0, -1.0], [0.2140411, 0.001, 1e9]])[None]
    write_image(tmp_path / "a.png", linear)
    stored = np.asarray(Image.open(tmp_path / "a.png"))
    assert stored[0].tolist() == [[0, 10, 188], [255, 255, 0], [127, 3, 255]]


def test_nan_is_black_and_infinity_white_in_png(tmp_path):
    write_image(tmp_path / "a.png", np.array([[np.nan, np.inf, -np.inf]])[None])
    assert np.asarray(Image.open(tmp_path / "a.png"))[0, 0].tolist() == [0, 255, 0]


def decoded_png(data):
    """Pixels of a PNG by the book: shape (h, w, 3), without the help of Pillow."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, chunks = 8, []
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        (check,) = struct.unpack_from(">I", data, at + 8 + length)
        assert check == zlib.crc32(kind + body)
        chunks.append((kind, body))
        at += 12 + length
    w, h, bits, colour = struct.unpack(">IIBB", chunks[0][1][:10])
    assert colour == 2
    size = 3 * bits // 8
    lines = zlib.decompress(b"".join(body for kind, body in chunks if kind == b"IDAT"))
    rows = np.frombuffer(lines, np.uint8).reshape(h, 1 + w * size)
    result = np.zeros((h, w * size), np.uint8)
    for y in range(h):
        kind, line = rows[y, 0], rows[y, 1:]
        if kind == 1:
            line = np.add.accumulate(line.reshape(w, size), dtype=np.uint8).ravel()
        elif kind == 2 and y:
            line = line + result[y - 1]
        result[y] = line
    return result.view(">u2" if bits == 16 else np.uint8).reshape(h, w, 3), chunks


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("source", ["noise", "ramp", "columns"])
def test_png_of_either_depth_is_exact(tmp_path, bits, source):
    ramp = np.linspace(0, 1, 40 * 30 * 3).reshape(30, 40, 3)
    columns = np.repeat(picture(1, 40), 30, axis=0)
    linear = {"noise": picture(30, 40), "ramp": ramp, "columns": columns}[source]
    write_image(tmp_path / "a.png", linear, bits=bits)
    stored, _ = decoded_png((tmp_path / "a.png").read_bytes())
    wanted = np.rint(encode_srgb(np.clip(linear.astype(np.float32), 0, 1)) * (2**bits - 1))
    assert (np.abs(stored - wanted) <= (0 if bits == 8 else 1)).all()
    eight = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)
    assert (np.abs(eight - stored.astype(int) // (1 if bits == 8 else 256)) <= 1).all()


def test_png_holds_provenance(tmp_path):
    film().save(tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        image.load()
        assert image.text["alight.scene_hash"] == "abc"


def test_png_is_read_as_linear(tmp_path):
    write_image(tmp_path / "a.png", np.full((2, 2), 0.2))
    np.testing.assert_allclose(read_image(tmp_path / "a.png"), 0.2, atol=0.003)


@pytest.mark.parametrize("bits", [8, 16])
def test_what_a_png_holds_is_read_to_its_last_bit(tmp_path, bits):
    linear = np.random.default_rng(2).random((30, 40, 3))
    write_image(tmp_path / "a.png", linear, bits=bits)
    again = encode_srgb(read_image(tmp_path / "a.png"))
    np.testing.assert_allclose(again, encode_srgb(linear), atol=0.51 / (2**bits - 1))


@pytest.mark.parametrize("mode", ["L", "LA", "I;16", "P", "RGBA"])
def test_pngs_of_every_kind_are_read_as_their_colours(tmp_path, mode):
    """Grey of 16 bits is not white, and colours are those before alpha."""
    grey = np.arange(0, 256, 5, np.uint8)[None]
    if mode == "I;16":
        image = Image.fromarray(grey.astype(np.uint16) * 257)
    else:
        image = Image.fromarray(grey).convert(mode)
    image.save(tmp_path / "a.png")
    wanted = np.repeat(grey[..., None], 3, axis=2) / 255.0
    np.testing.assert_allclose(read_image(tmp_path / "a.png"), decode_srgb(wanted), atol=1e-6)


def test_jpeg_is_near_the_picture(tmp_path):
    ramp = np.linspace(0, 1, 64)[None, :, None] * np.ones((64, 1, 3))
    write_image(tmp_path / "a.jpg", ramp)
    assert np.abs(read_image(tmp_path / "a.jpg") - ramp).max() < 0.02


# ---------------------------------------------------------------------------- Radiance


def test_hdr_keeps_the_largest_channel_to_eight_bits(tmp_path):
    values = picture() * np.float32(10.0) ** np.arange(-8, 9, dtype=np.float32)[None, :, None]
    write_image(tmp_path / "a.hdr", values)
    largest = values.max(axis=2, keepdims=True)
    assert (np.abs(read_image(tmp_path / "a.hdr") - values) <= largest / 256 * 1.0001).all()


def test_hdr_of_exact_values_and_corner_cases():
    cases = np.array(
        [[0, 0, 0], [1, 0.5, 0.25], [255.6, 0, 0], [np.nan, -1, 2.0**-140], [1e38, 0, 0]]
    )
    back = hdr.decode_rgbe(hdr.encode_rgbe(cases[None]))[0]
    assert back[:2].tolist() == cases[:2].tolist()
    assert back[2].tolist() == [256, 0, 0]
    assert back[3].tolist() == [0, 0, 0]
    assert back[4, 0] == pytest.approx(1e38, rel=1 / 256)


def run_length_encoded(rgbe):
    """The "new" encoding, with runs and literals of every length that lines may have."""
    h, w, _ = rgbe.shape
    out = bytearray()
    for y in range(h):
        out += bytes((2, 2, w >> 8, w & 255))
        for c in range(4):
            line, x = rgbe[y, :, c], 0
            while x < w:
                run = 1
                while x + run < w and run < 127 and line[x + run] == line[x]:
                    run += 1
                if run > 2:
                    out += bytes((128 + run, line[x]))
                else:
                    run = min(run + 5, w - x, 128)
                    out += bytes((run, *line[x : x + run]))
                x += run
    return bytes(out)


def test_run_length_encoded_hdr_is_read(tmp_path):
    values = picture(9, 300)
    values[:, 20:220] = [0.5, 0.25, 3.0]
    rgbe = hdr.encode_rgbe(values)
    head = b"#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 9 +X 300\n"
    (tmp_path / "a.hdr").write_bytes(head + run_length_encoded(rgbe))
    assert (read_image(tmp_path / "a.hdr") == hdr.decode_rgbe(rgbe) / 2).all()
    write_image(tmp_path / "flat.hdr", values)
    assert (read_image(tmp_path / "flat.hdr") == hdr.decode_rgbe(rgbe)).all()


def test_truncated_and_mutated_hdr_never_crash(tmp_path):
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X 20\n"
    good = head + run_length_encoded(hdr.encode_rgbe(picture(9, 20)))
    rng, path = np.random.default_rng(4), tmp_path / "a.hdr"
    for i in range(300):
        data = bytearray(good)
        for _ in range(3):
            data[rng.integers(len(data))] = rng.integers(256)
        path.write_bytes(data[: rng.integers(len(data)) if i % 2 else None])
        try:
            assert read_image(path).ndim == 3
        except OutputError as error:
            assert str(error).startswith("cannot read")


# ---------------------------------------------------------------------------- messages


@pytest.mark.parametrize("module", FORMATS, ids=lambda module: module.__name__.rpartition(".")[2])
@pytest.mark.parametrize("content", [b"", b"x", b"#?RADIANCE\n\n", b"PF\n99999 99999\n-1\nabc"])
def test_files_that_are_no_pictures_give_one_message(tmp_path, module, content, capfd):
    path = tmp_path / f"a{module.SUFFIXES[0]}"
    path.write_bytes(content)
    with pytest.raises(OutputError, match=r"^cannot read .*a\." + module.SUFFIXES[0][1:]):
        read_image(path)
    assert capfd.readouterr().err == ""


def test_a_cut_openexr_file_is_told_of_once(tmp_path, capfd):
    path = write_image(tmp_path / "a.exr", picture(9, 20))
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(OutputError, match=r"^cannot read .*broken OpenEXR file"):
        read_image(path)
    # The library writes to standard output, where results stand that programs read.
    assert capfd.readouterr() == ("", "")


def test_a_missing_file_is_named(tmp_path):
    for module in FORMATS:
        with pytest.raises(OutputError, match="there is no such file"):
            read_image(tmp_path / f"none{module.SUFFIXES[0]}")
    with pytest.raises(OutputError, match=r'unknown suffix "\.pgn"; did you mean "\.png"'):
        read_image("a.pgn")


@pytest.mark.parametrize(
    "wrong", [np.zeros((4, 4, 2)), np.zeros(3), np.zeros((0, 4, 3)), np.array([["a"]]), "text"]
)
def test_arrays_that_are_no_pictures_are_refused(wrong):
    with pytest.raises(OutputError, match="a picture must"):
        as_picture(wrong)


def test_pictures_pass_through():
    made = Picture(picture())
    assert as_picture(made) is made
    assert as_picture(np.ones((2, 3, 1))).image.shape == (2, 3, 3)


def covered():
    """A picture whose pixels are covered wholly, by half, and not at all."""
    alpha = np.array([[1.0, 0.5, 0.0]], np.float32)
    return Picture(np.float32([[[0.5] * 3, [0.25] * 3, [0.0] * 3]]), alpha=alpha)


@pytest.mark.parametrize("bits", [8, 16])
def test_png_keeps_straight_alpha_and_exr_what_is_multiplied_by_it(bits, tmp_path):
    write_image(tmp_path / "a.png", covered(), bits=bits)
    with Image.open(tmp_path / "a.png") as image:
        assert image.mode == "RGBA"
        found = np.asarray(image)[0]
    assert found[:, 3].tolist() == [255, 128, 0]
    half = round(255 * float(encode_srgb(np.float64(0.5))))
    assert found[:, 0].tolist() == [half, half, 0]
    write_image(tmp_path / "a.exr", covered())
    channels, _ = read_layers(tmp_path / "a.exr")
    assert channels["A"][0].tolist() == [1.0, 0.5, 0.0]
    assert channels["R"][0].tolist() == [0.5, 0.25, 0.0]


def test_shadows_are_black_where_nothing_covers(tmp_path):
    """Over white, blended as browsers do, the share of the light that comes through is shown."""
    open_share = np.float64([[0.25, 0.5, 1.0]])
    covered = np.float32([[0.0, 0.5, 1.0]])
    shadow = np.float32((1.0 - covered) * (1.0 - open_share))
    image = np.float32(covered[..., None] * [0.2, 0.4, 0.6])
    picture = Picture(image, {"shadow.A": shadow}, alpha=covered, shadow=shadow)
    write_image(tmp_path / "a.png", picture, bits=16)
    shown = blended_over_white(picture)
    edge = 0.5 * encode_srgb(np.float64([0.2, 0.4, 0.6])) + 0.5 * encode_srgb(np.float64(0.5))
    np.testing.assert_allclose(shown[0, 0], encode_srgb(np.float64(0.25)), atol=1e-6)
    np.testing.assert_allclose(shown[0, 1], edge, atol=1e-6)
    np.testing.assert_allclose(shown[0, 2], encode_srgb(np.float64([0.2, 0.4, 0.6])), atol=1e-6)
    with Image.open(tmp_path / "a.png") as file:
        assert file.mode == "RGBA" and np.asarray(file)[0, 2, 3] == 255
    write_image(tmp_path / "a.exr", picture)
    channels, _ = read_layers(tmp_path / "a.exr")
    np.testing.assert_array_equal(channels["A"], covered + shadow)
    again = read_picture(tmp_path / "a.exr")
    np.testing.assert_allclose(again.alpha, covered, atol=1e-6)
    np.testing.assert_allclose(blended_over_white(again), shown, atol=1e-6)


def blended_over_white(picture):
    colors, alpha = picture.over_display(encode_srgb(picture.straight.astype(np.float64)))
    return colors * alpha[..., None] + (1.0 - alpha[..., None])


@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_files_keep_the_pixels_of_an_inch(suffix, tmp_path):
    write_image(tmp_path / f"a.{suffix}", picture(), dpi=300)
    with Image.open(tmp_path / f"a.{suffix}") as image:
        assert image.info["dpi"] == pytest.approx((300, 300), rel=1e-3)


def test_a_film_has_alpha_only_where_its_picture_has_no_background():
    for hides in (False, True):
        film = Film(8, 8, aovs={"alpha": ("A",)}, options={"hide_emitters": hides})
        assert (film.alpha is not None) == hides == ("alpha.A" not in film.picture().layers)


def test_a_pfm_that_was_cut_says_how_many_bytes_there_are(tmp_path):
    whole = write_image(tmp_path / "a.pfm", np.ones((2, 3, 3), np.float32)).read_bytes()
    pixels = 2 * 3 * 3 * 4
    for missing in range(1, pixels + 1):
        (tmp_path / "b.pfm").write_bytes(whole[:-missing])
        with pytest.raises(OutputError, match=f"early: {pixels - missing} bytes.*not {pixels}"):
            read_image(tmp_path / "b.pfm")


def test_an_array_that_was_read_stays_as_it_is_when_its_file_changes(tmp_path):
    """Only where it is asked for do the numbers stay in the file."""
    path = tmp_path / "a.npy"
    np.save(path, np.ones((2, 3, 3), np.float32))
    read, mapped = npy.load_array(path), npy.load_array(path, mapped=True)
    picture = read_image(path)
    np.load(path, mmap_mode="r+")[:] = 2.0
    assert (read == 1.0).all() and (picture == 1.0).all() and (mapped == 2.0).all()
