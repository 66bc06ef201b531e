"""Pictures of other renderers are read as they are meant, and refused in one clear sentence."""

import numpy as np
import pytest

from alight.core.errors import OutputError
from alight.core.srgb import encode_srgb
from alight.films import Film, PartialFilm
from alight.films.fixed_point import to_limbs
from alight.lab.compare import Input, make_comparable, read_input
from alight.lab.compare.inputs import _parts, as_input
from alight.outputs import write_image


def film(seed=0, spp=4, size=(32, 24), value=0.5):
    """A film of lognormal noise."""
    w, h = size
    picture = Film(w, h, aovs={"albedo": ("R", "G", "B"), "depth": ("Z",)}, scene_hash="x")
    values = value * np.random.default_rng(seed).lognormal(0, 0.3, (spp, h, w, 3))
    limbs, _, _ = to_limbs(values.astype(np.float32))
    sums = np.stack([limbs[r::4].sum(axis=0) for r in range(4)], axis=2)
    counts = np.full((h, w, 4), spp // 4)
    layers = {"albedo": limbs.sum(axis=0), "depth": limbs.sum(axis=0)[:, :, :1]}
    picture.add_tile(PartialFilm(0, 0, sums, counts, 0, 0, (0, spp), layers))
    return picture


def picture(h=12, w=16):
    return np.random.default_rng(1).random((h, w, 3)).astype(np.float32)


def write_exr(path, channels):
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {k: np.ascontiguousarray(v) for k, v in channels.items()}) as file:
        file.write(str(path))


@pytest.mark.parametrize("suffix", [".exr", ".npy", ".pfm"])
def test_linear_files_keep_every_bit(tmp_path, suffix):
    path = write_image(tmp_path / f"a{suffix}", picture())
    found = read_input(path)
    assert np.array_equal(found.image, picture())
    assert (found.is_display, found.error, found.size) == (False, None, (16, 12))


@pytest.mark.parametrize("bits", [8, 16])
def test_display_files_are_decoded(tmp_path, bits):
    path = write_image(tmp_path / "a.png", picture(), bits=bits)
    found = read_input(path)
    assert found.is_display
    assert np.abs(encode_srgb(found.image) - encode_srgb(picture())).max() <= 0.5001 / (2**bits - 1)


def test_films_bring_their_standard_errors(tmp_path):
    one = film()
    found = read_input(one.save(tmp_path / "a.exr"))
    assert found.replicates == 4
    assert np.array_equal(found.samples, one.sample_count)
    assert np.allclose(found.error, one.standard_error, rtol=1e-6)
    layer = read_input(tmp_path / "a.exr", "albedo")
    assert layer.error is None
    assert np.array_equal(layer.image, np.stack([one.aov("albedo")[..., i] for i in range(3)], -1))
    depth = read_input(tmp_path / "a.exr", "depth")
    assert np.array_equal(depth.image[..., 2], one.aov("depth")[..., 0])


def test_layers_of_other_renderers_are_found(tmp_path):
    blue, red = np.full((4, 5), 2, np.float32), np.ones((4, 5), np.float32)
    combined = {f"View.Combined.{c}": v for c, v in zip("RGBA", (red, red, blue, red), strict=True)}
    normal = {f"View.Normal.{c}": red for c in "XYZ"}
    write_exr(tmp_path / "a.exr", combined | normal)
    assert np.array_equal(read_input(tmp_path / "a.exr").image[..., 2], blue)
    assert np.array_equal(read_input(tmp_path / "a.exr", "View.Normal").image[..., 0], red)
    write_exr(tmp_path / "y.exr", {"Y": blue})
    assert np.array_equal(read_input(tmp_path / "y.exr").image, np.stack([blue] * 3, -1))
    write_exr(tmp_path / "n.exr", normal)
    with pytest.raises(OutputError, match=r"no channels R, G, B or Y; name one of.*View\.Normal"):
        read_input(tmp_path / "n.exr")


def test_the_only_channel_of_a_layer_is_its_picture(tmp_path):
    """Whatever it is called, and whatever counts or covers beside it."""
    names = {"R", "G", "B", "fog.V", "fog.A", "fog.samples", "fog.more.W"}
    assert _parts(names, "fog", must=False) == ["fog.V"]
    rng = np.random.default_rng(120)
    main = {c: rng.random((4, 5)).astype(np.float32) for c in "RGBA"}
    for name in ("V", "Z", "depth"):
        layer = {f"fog.{c}": rng.random((4, 5)).astype(np.float32) for c in (name, "A")}
        layer["fog.samples"] = np.full((4, 5), 7, np.uint32)
        write_exr(tmp_path / "a.exr", main | layer)
        found = read_input(tmp_path / "a.exr", "fog").image
        assert np.array_equal(found, np.stack([layer[f"fog.{name}"]] * 3, -1))
    write_exr(tmp_path / "a.exr", main | layer | {"fog.W": main["R"]})
    with pytest.raises(OutputError, match=r"no colour in layer fog; it has fog\.A, fog\.W, "):
        read_input(tmp_path / "a.exr", "fog")


def test_grey_and_alpha_are_said(tmp_path):
    np.save(tmp_path / "grey.npy", picture()[..., 0])
    np.save(tmp_path / "alpha.npy", np.dstack([picture(), picture()[..., :1]]))
    grey, alpha = (read_input(tmp_path / f"{n}.npy") for n in ("grey", "alpha"))
    assert np.array_equal(grey.image[..., 2], picture()[..., 0])
    assert np.array_equal(alpha.image, picture())
    assert "grey" in grey.remarks[0]
    assert "alpha" in alpha.remarks[0]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.exr", None, "there is no such file"),
        (
            "text.png",
            b"hello",
            "it is not a PNG, JPEG, WebP, EXR, HDR, PFM, NPY, BMP, TGA or TIFF picture",
        ),
        ("empty.npy", b"", "it is not a PNG"),
        ("cut.png", b"\x89PNG\r\n\x1a\n\x00\x00", "cannot"),
        ("cut.exr", b"\x76\x2f\x31\x01\x00\x00", "broken"),
    ],
)
def test_what_is_no_picture_is_refused(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(OutputError, match=message) as caught:
        read_input(tmp_path / name)
    assert str(caught.value).startswith(f"cannot read {tmp_path / name}: ")


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((4, 4, 5)), "it has 5 channels; a picture has 1 or 3"),
        (np.zeros(7), r"it must have the shape"),
        (np.zeros((0, 4, 3)), "it has no pixels"),
        (np.full((4, 4, 3), "x"), "no numbers"),
    ],
)
def test_arrays_that_are_no_pictures_are_refused(tmp_path, array, message):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(OutputError, match=message):
        read_input(tmp_path / "a.npy")


def test_layers_must_exist_and_be_in_an_exr_file(tmp_path):
    film().save(tmp_path / "a.exr")
    with pytest.raises(OutputError, match='unknown layer "albdo"; did you mean "albedo"'):
        read_input(tmp_path / "a.exr", "albdo")
    np.save(tmp_path / "a.npy", picture())
    with pytest.raises(OutputError, match="only OpenEXR files have layers"):
        read_input(tmp_path / "a.npy", "albedo")


def test_crops_from_different_places_are_told(tmp_path):
    parts = {"a": (0, 0, 8, 8), "b": (8, 0, 8, 8)}
    films = {name: Film(16, 8, crop=crop) for name, crop in parts.items()}
    for name, part in films.items():
        part.save(tmp_path / f"{name}.exr")
    told = f"{tmp_path / 'b.exr'}: begins at 8,0 of its full picture, {tmp_path / 'a.exr'} at 0,0"
    read = [read_input(tmp_path / f"{name}.exr") for name in parts]
    assert [one.remarks for one in make_comparable(read)] == [[], [told]]
    assert [one.remarks for one in make_comparable([read[1], read[1]])] == [[], []]
    assert as_input(films["b"], "B", None).place == read[1].place == (8, 0)
    # An array does not say where it is from.
    plain = as_input(np.zeros((8, 8, 3), np.float32), "C", None)
    assert make_comparable([plain, read[1]])[1].remarks == []


def test_other_sizes_and_invalid_pixels_are_refused_with_their_place():
    a, b = Input("a", picture(), False), Input("b", picture(12, 15), False)
    with pytest.raises(OutputError, match="different sizes: a 16 x 12, b 15 x 12 pixels"):
        make_comparable([a, b])
    bad = Input("bad", picture(), False, error=np.ones((12, 16, 3)), replicates=4)
    bad.image[3, 5, 1], bad.image[7, 2, 0] = np.nan, np.inf
    with pytest.raises(OutputError, match=r"bad: 2 of 192 pixels.* first at 5,3 \(NaN\)"):
        make_comparable([a, bad])
    kept, cleared = make_comparable([a, bad], skip_invalid=True)
    for one in (kept, cleared):
        assert (one.image[3, 5] == 0).all()
        assert (one.image[7, 2] == 0).all()
    assert np.isnan(cleared.error).sum() == 6
    assert kept.remarks == []
    assert "2 pixels" in cleared.remarks[0]
    assert np.isnan(bad.image[3, 5, 1])


def test_beside_a_display_file_all_pictures_are_cut_at_one():
    shown = Input("shown", picture(), True)
    linear = Input("linear", 3 * picture(), False, np.ones((12, 16, 3), np.float32), 4)
    one, other = make_comparable([shown, linear])
    assert other.image.max() == 1.0
    assert other.error is None
    assert "cut to [0, 1]" in other.remarks[0]
    assert np.array_equal(one.image, shown.image)


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (FileNotFoundError("a"), "there is no such file"),
        (PermissionError("b"), "no permission to read it"),
        (OSError("c"), "c"),
        (ValueError("d"), "d"),
        (OutputError("is whole"), None),
    ],
)
def test_each_cause_has_its_own_words(tmp_path, monkeypatch, error, message):
    def failing(*_):
        raise error

    path = write_image(tmp_path / "a.png", picture())
    monkeypatch.setattr("alight.lab.compare.inputs.read_texels", failing)
    with pytest.raises(OutputError) as caught:
        read_input(path)
    assert str(caught.value) == (f"cannot read {path}: {message}" if message else str(error))
