"""OpenUSD: packages, what is refused or left out with words, and what the command line says."""

import zipfile

import pytest
from PIL import Image
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import SceneError
from tests.formats.usd.stage import MATERIAL, SQUARE, stage_text, usd_loader

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


@pytest.mark.parametrize("slash", ["/", "\\"])
def test_pictures_inside_of_packages_are_read(tmp_path, slash):
    (tmp_path / "in").mkdir()
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "in" / "p.png")
    text = "color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>"
    text = (MATERIAL % (text, SQUARE)).replace("@p.png@", f"@in{slash}p.png@")
    (tmp_path / "a.usda").write_text(stage_text(text))
    with zipfile.ZipFile(tmp_path / "a.usdz", "w", zipfile.ZIP_STORED) as package:
        for name in ("a.usda", "in/p.png"):
            data = (tmp_path / name).read_bytes()
            info = zipfile.ZipInfo(name)
            # The format wants the data at multiples of 64 bytes.
            start = package.fp.tell() + 30 + len(name) + 4
            info.extra = b"\x86\x19" + ((-start) % 64).to_bytes(2, "little") + bytes((-start) % 64)
            package.writestr(info, data)
    (tmp_path / "in" / "p.png").unlink()
    scene = alight.load(tmp_path / "a.usdz")
    texels = scene.bsdfs["m"].bsdf.base_color.b.pixels
    assert (texels.width, texels.height) == (2, 2)


_SCALE = "float3 xformOp:scale = (%s, 1, 1)"
_RESET = 'uniform token[] xformOpOrder = ["!resetXformStack!"]'


def _moved(step, inside):
    """A prim with one step of a transform."""
    kind = step.split()[1]
    return f'def Xform "x" {{ {step}\nuniform token[] xformOpOrder = ["{kind}"]\n{inside} }}'


PICTURE = MATERIAL % ("color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>", SQUARE)
MISTAKES = {
    "type": ('def Cube "c" { token size = "x" }', "/c size must be of type double, got string"),
    "unknown type": ('def Cube "c" { uble size = 1 }', "/c size must be of type double"),
    "transform": (
        (
            'def Xform "x" { float xformOp:translate = 1\n'
            'uniform token[] xformOpOrder = ["xformOp:translate"] }'
        ),
        "OpenUSD: Invalid combination of opType (TypeTranslate)",
    ),
    "axis": ('def Plane "p" { uniform token axis = "W" }', '/p unknown axis "W"'),
    "list": ('def Sphere "s" { double[] radius = [1] }', "radius must be of type double, got"),
    "indices": (
        f'def Mesh "m" {{{SQUARE}}}'.replace("2, 3]", "2, 9]"),
        "/m faceVertexIndices must be points, 0 to 3, got 9",
    ),
    "counts": (
        f'def Mesh "m" {{{SQUARE}}}'.replace("[4]", "[5]"),
        "/m faceVertexIndices must have 5 numbers, got 4",
    ),
    "points": (
        f'def Mesh "m" {{{SQUARE}}}'.replace("(2, 1, 0)", "(2, nan, 0)"),
        "/m points must be finite",
    ),
    "not finite": (
        'def Camera "c" { float verticalAperture = nan }',
        "/c verticalAperture must be finite, got nan",
    ),
    "syntax": ("def Mesh {", "is not an OpenUSD stage"),
    "reference": ('def "m" (references = @gone.usda@) { }', "does not fit together"),
    "reach": ('def "m" (references = @../out.usda@) { }', "layer leads out of the folder"),
    "picture": (PICTURE, '/m/picture no such picture: "p.png"'),
    "kind of an input": (
        PICTURE.replace("float4 inputs:scale = (0.5, 0.5, 0.5, 1)", "float inputs:scale = 2"),
        "/m/picture inputs:scale must be 4 numbers, got 2.0",
    ),
    "text for a number": (
        PICTURE.replace("float2 inputs:scale = (2, 3)", 'string inputs:rotation = "x"'),
        '/m/place inputs:rotation must be a number, got "x"',
    ),
    "unknown type of an input": (
        PICTURE.replace("float4 inputs:scale", "flota4 inputs:scale"),
        "/m/picture inputs:scale is of a type that OpenUSD does not know",
    ),
    "far away": (
        _moved("double3 xformOp:translate = (1e300, 0, 0)", f'def Mesh "m" {{{SQUARE}}}'),
        "/x its transform must be affine, of numbers of at most 1e+15 in size",
    ),
    "far away in two steps": (
        _moved(_SCALE % "1e14", _moved(_SCALE % "1e14", f'def Mesh "m" {{{SQUARE}}}')),
        "/x/x stands where the world needs numbers not of at most 1e+15 in size",
    ),
    "back from nothing": (
        _moved(_SCALE % "0", f'def Mesh "m" {{{SQUARE}{_RESET}}}'),
        "/x/m cannot undo the transforms above it: they flatten it to nothing",
    ),
    "far instance": (
        (
            'def PointInstancer "p" { rel prototypes = [</p/m>]; int[] protoIndices = [0]\n'
            f'point3f[] positions = [(inf, 0, 0)]\n def Mesh "m" {{{SQUARE}}} }}'
        ),
        "/p the transform of instance 0 must hold numbers of at most 1e+15 in size",
    ),
    "exposure": (
        'def SphereLight "l" { float inputs:exposure = 1e5 }',
        "/l color * intensity * 2^100000 must be finite, got [inf, inf, inf]",
    ),
    "radius": (
        'def DiskLight "l" { double inputs:radius = 1e200; bool inputs:normalize = 1 }',
        "must be between 1e-15 and 1e+15 in size, got 1e+200",
    ),
    "prototype": (
        'def PointInstancer "p" { int[] protoIndices = [3]; point3f[] positions = [(0, 0, 0)] }',
        "/p protoIndices must be in",
    ),
}


@pytest.mark.parametrize(("text", "message"), MISTAKES.values(), ids=MISTAKES.keys())
def test_mistakes_are_refused_with_their_prim(tmp_path, text, message):
    folder = tmp_path / "scene"
    folder.mkdir()
    (tmp_path / "out.usda").write_text(stage_text('def "x" { }'))
    if text != PICTURE:
        Image.new("RGB", (2, 2)).save(folder / "p.png")
    (folder / "a.usda").write_text(stage_text(text))
    with pytest.raises(SceneError) as caught:
        alight.load(folder / "a.usda")
    assert message in " ".join(str(caught.value).split())


@pytest.mark.parametrize("suffix", [".usd", ".usda", ".usdc", ".usdz"])
@pytest.mark.parametrize("data", [b"", b"garbage", b"PXR-USDC" + bytes(4)])
def test_files_that_are_no_stage_are_refused(suffix, data, tmp_path):
    (tmp_path / f"a{suffix}").write_bytes(data)
    with pytest.raises(SceneError, match="is not an OpenUSD stage: "):
        alight.load(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("inside", [b'def "\xff" { }', b'string a = "\xff"', b"# \xff\n@\xff@"])
def test_bytes_that_are_no_text_are_refused(inside, tmp_path):
    """OpenUSD quotes them in its message, which then is no text either."""
    (tmp_path / "a.usda").write_bytes(stage_text("HERE").encode().replace(b"HERE", inside))
    with pytest.raises(SceneError, match="is not an OpenUSD stage: "):
        alight.load(tmp_path / "a.usda")


def test_names_in_binary_files_must_be_text(tmp_path):
    (tmp_path / "a.usda").write_text(stage_text('def Sphere "abcdefghijkl" { }'))
    Sdf = pytest.importorskip("pxr.Sdf")
    Sdf.Layer.FindOrOpen(str(tmp_path / "a.usda")).Export(str(tmp_path / "b.usdc"))
    data = (tmp_path / "b.usdc").read_bytes()
    assert data.count(b"abcdefghijkl") == 1
    (tmp_path / "c.usdc").write_bytes(data.replace(b"abcdefghijkl", b"\xffbcdefghijkl"))
    with pytest.raises(SceneError, match=r"text must be in UTF-8|is not an OpenUSD stage"):
        alight.load(tmp_path / "c.usdc")


@pytest.mark.parametrize("unit", ["inf", "nan", "0", "-1"])
def test_units_that_are_no_lengths_are_refused(unit, tmp_path):
    (tmp_path / "a.usda").write_text(stage_text('def Sphere "s" { }', unit=unit))
    with pytest.raises(SceneError, match="metersPerUnit\n  must be > 0 and at most 1e\\+12"):
        alight.load(tmp_path / "a.usda")


@pytest.mark.parametrize("kind", ["string[]", "coler3f[]"])
def test_primvars_without_numbers_are_left_out_and_said(load, kind):
    color = f'{kind} primvars:displayColor = ["a", "b", "c", "d"]' if kind[0] == "s" else ""
    color = color or f"{kind} primvars:displayColor = [(0, 0, 1)]"
    scene = load(f'def Mesh "m" {{{SQUARE}{color} (interpolation = "vertex")}}')
    (bsdf,) = scene.bsdfs.values()
    assert bsdf.bsdf.reflectance == pytest.approx((0.18, 0.18, 0.18))
    assert any("primvars:displayColor holds no rows of" in line for line in scene.warnings)


def test_the_command_line_says_what_was_read(tmp_path):
    (tmp_path / "a.usda").write_text(stage_text(f'def Mesh "m" {{{SQUARE}}}'))
    result = CliRunner().invoke(app, ["info", str(tmp_path / "a.usda")])
    assert result.exit_code == 0, result.output
    assert "the file has no light" in result.output
    assert "the file has no camera" in result.output
