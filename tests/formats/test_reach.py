"""What a scene may read: its own folder, or a larger one that its user names, in every format."""

import inspect
import os
from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from alight.cli.main import app
from alight.core.errors import SceneError
from alight.formats import load, loads, save
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.scenes.made_up import without_floor
from alight.lab.arms import load_arms
from alight.lab.sheet import render_tile, tiles
from alight.lab.study import StudyError
from alight.lab.study_file import load_study
from alight.scene import content_hash, flatten
from alight.scene.content import describe_content
from tests.formats.gltf.maker import Maker
from tests.formats.usd.stage import MATERIAL, SQUARE, stage_text

OBJ = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n"
XML = """<scene version="3.0.0"><shape type="rectangle"><bsdf type="diffuse"><texture type="bitmap"
name="reflectance"><string name="filename" value="PICTURE"/></texture></bsdf></shape></scene>"""
PBRT = """WorldBegin
Texture "t" "spectrum" "imagemap" "string filename" "PICTURE"
Material "diffuse" "texture reflectance" "t"
Shape "sphere"
"""
NATIVE = """alight: 1
camera: {type: pinhole}
nodes: {a: {shape: sphere, bsdf: {type: diffuse, reflectance: {type: bitmap, file: "PICTURE"}}}}
"""
FORMATS = ("a.obj", "a.gltf", "a.xml", "a.pbrt", "a.yaml", "a.usda")


def write(folder, name, picture="../textures/wood.png"):
    """Write a scene that shows a picture; the path of its file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    if name == "a.obj":
        path.write_bytes(OBJ)
        (folder / "a.mtl").write_text(f"newmtl m\nmap_Kd {picture}\n")
    elif name == "a.gltf":
        made = Maker()
        made.json["images"] = [{"uri": picture}]
        made.json["textures"] = [{"source": 0}]
        material = made.material(pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
        made.node(mesh=made.square(material))
        path.write_bytes(made.gltf())
    elif name == "a.usda":
        pytest.importorskip("pxr")
        color = "color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>"
        path.write_text(stage_text(MATERIAL % (color, SQUARE)).replace("p.png", picture))
    else:
        text = {"a.xml": XML, "a.pbrt": PBRT, "a.yaml": NATIVE}[name]
        path.write_text(text.replace("PICTURE", picture))
    return path


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A current folder with ``project/scenes`` and ``project/textures``."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "project" / "textures").mkdir(parents=True)
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "project" / "textures" / "wood.png")
    return Path("project")


def refusal(path, **options):
    with pytest.raises(SceneError) as caught:
        flatten(load(path, **options))
    return " ".join(str(caught.value).split())


def pictures_of(scene):
    flatten(scene)
    return [key for key in describe_content(scene) if key.startswith("file ") and "png" in key]


@pytest.mark.parametrize("name", FORMATS)
def test_a_picture_beside_the_folder_needs_a_root(name, project):
    path = write(project / "scenes", name)
    said = refusal(path)
    assert "leads out of the folder of the scene" in said
    assert said.endswith("--root project")
    for root in (project, project.absolute(), "project/scenes/..", "."):
        assert pictures_of(load(path, root=root)) == ["file ../textures/wood.png"]
    # Nothing tells whether there is such a file.
    (project / "textures" / "wood.png").unlink()
    assert refusal(path) == said
    assert "no such" in refusal(path, root=project)


@pytest.mark.parametrize("name", FORMATS)
def test_links_do_not_lead_out(name, project):
    scenes = project / "scenes"
    scenes.mkdir()
    (scenes / "link.png").symlink_to("../textures/wood.png")
    path = write(scenes, name, "link.png")
    said = refusal(path)
    # Where a link leads is not told.
    assert "by a link" in said and "--root" not in said and "wood" not in said
    assert pictures_of(load(path, root=project))
    (project / "textures").rename("elsewhere")
    (project / "textures").symlink_to("../elsewhere")
    assert "by a link" in refusal(path, root=project)
    assert pictures_of(load(path, root="."))


@pytest.mark.parametrize("name", FORMATS)
def test_absolute_paths_count_by_where_they_lead(name, project):
    scenes, picture = project / "scenes", (project / "textures" / "wood.png").absolute()
    path = write(scenes, name, picture.as_posix())
    assert "--root project" in refusal(path)
    assert pictures_of(load(path, root=project)) == ["file ../textures/wood.png"]
    (scenes / "wood.png").write_bytes(picture.read_bytes())
    path = write(scenes, name, (scenes / "wood.png").absolute().as_posix())
    assert pictures_of(load(path)) == ["file wood.png"]


@pytest.mark.skipif(os.name == "nt", reason="there these are paths of this computer")
def test_paths_of_another_computer():
    for name in ("C:/a.png", "C:\\a.png", "\\\\server\\share\\a.png"):
        with pytest.raises(OutOfReachError, match="another computer"):
            Reach().inside(name)


def test_backslashes_are_slashes(project):
    picture = "..\\\\textures\\\\wood.png"
    path = write(project / "scenes", "a.yaml", picture)
    assert "--root project" in refusal(path)
    assert pictures_of(load(path, root=project)) == ["file ../textures/wood.png"]
    # A folder whose name holds one must not take a way up away.
    (project / "scenes" / "a\\b").mkdir()
    path = write(project / "scenes", "a.yaml", "a\\\\b/../../textures/wood.png")
    assert "no such file" in refusal(path)


@pytest.mark.parametrize(
    ("scene", "picture", "root"),
    [
        ("project/scenes/deep/a.yaml", "../../textures/steel.png", "project"),
        ("project/scenes/a.yaml", "../wood.png", "project"),
        ("project/a.yaml", "../wood.png", "."),
        ("a.yaml", "../wood.png", ".."),
        ("project/a.yaml", "x/../../wood.png", "."),
        ("project/a.yaml", "../" * 15 + "wood.png", None),
        ("project/a.yaml", "/wood.png", None),
    ],
)
def test_the_smallest_root_is_named_but_no_whole_disk(scene, picture, root, project):
    path = Path(scene)
    said = refusal(write(path.parent, "a.yaml", picture))
    assert said.endswith(f'"{picture}"' if root is None else f"--root {root}")
    if root is not None:
        assert "no such file" in refusal(path, root=root)


def test_what_lies_outside_is_not_looked_at(project, monkeypatch):
    seen, stat = [], os.lstat
    reach = Reach(project, None)
    monkeypatch.setattr(os, "lstat", lambda path, **o: seen.append(str(path)) or stat(path, **o))
    for name in ("../secret/a.png", "/etc/a.png", "../secret/../project/textures/wood.png"):
        try:
            reach.inside(name)
        except OutOfReachError:
            continue
    assert not [path for path in seen if "secret" in path or "etc" in path]


def test_folders_may_be_named_through_links(project):
    scenes = write(project / "scenes", "a.yaml").parent
    Path("short").symlink_to(scenes)
    # The folder above the link is another one than that above its end.
    assert refusal("short/a.yaml").endswith(f"--root {project.resolve()}")
    assert pictures_of(load("short/a.yaml", root=project))
    Path("alias").symlink_to(project)
    picture = Path("alias/textures/wood.png").absolute().as_posix()
    path = write(scenes, "a.yaml", picture)
    assert pictures_of(load(path, root="alias"))


@pytest.mark.parametrize(
    ("root", "words"),
    [
        ("project/textures", "must be a folder that holds the scene file"),
        ("nowhere", 'must be a folder, got "nowhere"'),
        ("project/scenes/a.obj", "must be a folder, got"),
    ],
)
def test_roots_that_are_none(root, words, project):
    path = write(project / "scenes", "a.obj")
    assert words in refusal(path, root=root)
    done = CliRunner().invoke(app, ["info", str(path), "--root", root])
    assert done.exit_code == 2 and f"{path}  --root\n  {words}" in done.output


def test_texts_without_a_file_lie_in_the_current_folder(project, monkeypatch):
    text = NATIVE.replace("PICTURE", "../textures/wood.png")
    (project / "scenes").mkdir()
    monkeypatch.chdir("project/scenes")
    with pytest.raises(SceneError, match=r"scene:3:\d+  nodes.a.bsdf.reflectance.file\n.*--root"):
        loads(text)
    assert loads(text, root="..").source.folder == Path()


def test_what_the_user_names_may_lie_anywhere(project):
    path = write(project / "scenes", "a.yaml", "wood.png")
    (project / "textures" / "wood.png").replace(project / "scenes" / "wood.png")
    Image.new("RGB", (4, 2)).save("sky.png")
    for sky in ("../../sky.png", Path("sky.png").absolute().as_posix()):
        scene = load(path, [f'environment={{type: environment, file: "{sky}"}}'])
        assert len(pictures_of(scene)) == 2


def test_a_saved_scene_needs_no_root(project):
    scene = load(write(project / "scenes", "a.obj"), root=project)
    for target in ("project/scenes/b.yaml", "project/b.yaml", "elsewhere/b.yaml"):
        Path(target).parent.mkdir(exist_ok=True)
        save(scene, target)
        assert content_hash(load(target)) == content_hash(scene)
    # Only what lies elsewhere is copied, once.
    assert pictures_of(load("project/b.yaml")) == ["file textures/wood.png"]
    assert [p.name for p in Path("elsewhere").iterdir() if p.suffix == ".png"] == ["b-0-wood.png"]


# ---------------------------------------------------------------------------- OpenUSD's layers


@pytest.mark.parametrize("arc", ["references", "payload", "subLayers"])
def test_layers_outside_are_not_read(arc, project):
    pytest.importorskip("pxr")
    scenes, outside = project / "scenes", project / "layers" / "out.usda"
    scenes.mkdir()
    outside.parent.mkdir()
    # Through a layer in between, which lies inside.
    (scenes / "b.usda").write_text(stage_text('def "m" (references = @./c.usda@</x>) { }'))
    named = "@../layers/out.usda@"
    text = f'#usda 1.0\n(\n subLayers = [{named}]\n)\ndef Sphere "x"\n{{\n}}\n'
    if arc != "subLayers":
        text = stage_text(f'def "x" ({arc} = {named}) {{ }}')
    (scenes / "c.usda").write_text(text)
    said = refusal(scenes / "b.usda")
    assert '"../layers/out.usda"; for a file that you trust: --root project' in said
    for content in ("SECRET {", '#usda 1.0\n(defaultPrim = "x")\ndef Sphere "x"\n{\n}\n'):
        outside.write_text(content)
        assert refusal(scenes / "b.usda") == said
    scene = without_floor(load(scenes / "b.usda", root=project))
    assert [node.shape.type_name() for _, _, node in scene.walk() if node.shape] == ["sphere"]


# ---------------------------------------------------------------------------- commands


def test_every_command_that_loads_a_scene_takes_a_root():
    without = []
    for command in app.registered_commands:
        names = inspect.signature(command.callback).parameters
        if {"scene", "scenes"} & set(names) or command.callback.__name__ == "study":
            without += [] if "root" in names else [command.callback.__name__]
    assert not without


@pytest.mark.parametrize(
    "words",
    [
        ("info",), ("convert", "out.yaml"), ("trace", "--pixel", "1,1", "--size", "4x4"),
    ],
)  # fmt: skip
def test_commands_hand_the_root_on(words, project):
    path = write(project / "scenes", "a.obj")
    call = [words[0], str(path), *words[1:]]
    refused = CliRunner().invoke(app, call)
    assert refused.exit_code == 2 and "--root project" in refused.output
    done = CliRunner().invoke(app, [*call, "--root", "project"])
    assert done.exit_code == 0, done.output


def test_sheets_and_studies_hand_the_root_on(project, monkeypatch):
    path = write(project / "scenes", "a.yaml")
    assert "--root project" in render_tile(str(path), (16, 16), spp=1).message
    # What is refused is refused before the render.
    monkeypatch.setattr(tiles, "render", lambda *_, **__: (_ for _ in ()).throw(OSError("loaded")))
    assert render_tile(str(path), (16, 16), spp=1, root=project).message == "loaded"
    Path("study.yaml").write_text(f"scenes: [{path}]\narms: {{one: {{}}, two: {{}}}}\n")
    for root in (None, project):
        study = load_study("study.yaml", root)
        if root is None:
            with pytest.raises(StudyError, match="--root project"):
                load_arms(study, study.scenes[0], quick=True)
        else:
            assert set(load_arms(study, study.scenes[0], quick=True)) == {"one", "two"}


def test_the_folder_that_was_named_last_is_searched_first(project):
    for name in ("a", "b"):
        (project / name).mkdir()
        (project / name / "p.png").touch()
    reach = Reach(project)
    for name in ("a", "b"):
        reach.add(name)
    assert reach.find("p.png") == project / "b" / "p.png"
    (project / "p.png").touch()
    (project / "b" / "p.png").unlink()
    assert reach.find("p.png") == project / "a" / "p.png"
