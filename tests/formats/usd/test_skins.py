"""OpenUSD: meshes stand as their skeletons hold them when the film begins."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.scene.flatten import flatten
from tests.formats import bare
from tests.formats.usd.stage import HEAD, SQUARE, shapes, world_points

pytest.importorskip("pxr")

#: A square whose upper side hangs at a joint that is 7 above where it was bound; the animation, if
#: it is played, turns it half around z and moves it along z, and bulges the shape. Where the mesh's
#: own transform puts it plays no part: it is bound in the space of the skeleton.
CHARACTER = """
%(kind)s "r" %(more)s
{
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "m" (prepend apiSchemas = ["SkelBindingAPI"])
    {
        double3 xformOp:translate = (0, 0, 3)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        %(square)s
        normal3f[] normals = [(1, 0, 0), (1, 0, 0), (1, 0, 0), (1, 0, 0)]
        int[] primvars:skel:jointIndices = [0, 0, 1, 1] (
            elementSize = 1
            interpolation = "vertex"
        )
        float[] primvars:skel:jointWeights = [1, 1, 1, 1] (
            elementSize = 1
            interpolation = "vertex"
        )
        rel skel:skeleton = <%(path)s/s>
        uniform token[] skel:blendShapes = ["bulge"]
        rel skel:blendShapeTargets = <%(path)s/m/bulge>
        def BlendShape "bulge"
        {
            uniform vector3f[] offsets = [(-1, 0, 0), (0.5, 0, 0)]
            uniform int[] pointIndices = [0, 2]
        }
    }
    def Skeleton "s" (prepend apiSchemas = ["SkelBindingAPI"])
    {
        uniform token[] joints = ["a", "a/b"]
        uniform matrix4d[] bindTransforms = [%(one)s, %(one)s]
        uniform matrix4d[] restTransforms = [%(one)s, %(risen)s]
        %(played)s
    }
    def SkelAnimation "moves"
    {
        uniform token[] joints = ["a", "a/b"]
        uniform token[] blendShapes = ["bulge"]
        float3[] translations.timeSamples = {
            1: [(0, 0, 0), (0, 0, 5)],
            3: [(0, 0, 0), (0, 0, 9)],
        }
        quatf[] rotations = [(1, 0, 0, 0), (0, 0, 0, 1)]
        half3[] scales = [(1, 1, 1), (1, 1, 1)]
        float[] blendShapeWeights.timeSamples = {
            1: [0],
            3: [1],
        }
    }
}
"""
ONE = "( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )"
RISEN = "( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 7, 0, 1) )"
STILL = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])


def character(played=True, kind="def SkelRoot", more="", path="/r", start=None):
    parts = {"one": ONE, "risen": RISEN, "square": SQUARE, "kind": kind, "more": more}
    parts["path"] = path
    parts["played"] = f"rel skel:animationSource = <{path}/moves>" if played else ""
    head = HEAD.format(up="Y", unit=1)
    if start is not None:
        times = f"startTimeCode = {start}\n    endTimeCode = 9\n)"
        head = head.replace("metersPerUnit = 1\n)", f"metersPerUnit = 1\n    {times}")
    return head + CHARACTER % parts


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""

    def run(text, **shown):
        (tmp_path / "a.usda").write_text(text)
        return bare.load(tmp_path / "a.usda", **shown)

    return run


def same_points(scene, expected):
    """The same points in the world, in any order."""
    found = sorted(world_points(scene).round(4).tolist())
    np.testing.assert_allclose(found, sorted(np.round(expected, 4).tolist()), atol=1e-3)


def test_without_an_animation_the_skeleton_rests(load):
    scene = load(character(played=False))
    lifted = np.array([0, 0, 7, 7])[:, None] * [0, 1, 0]
    same_points(scene, STILL + lifted + [10, 0, 0])
    assert not any("Skel" in line for line in scene.source.remarks.notes)


def test_an_animation_is_shown_at_its_first_time(load):
    scene = load(character())
    turned = STILL.copy()
    turned[2:] = STILL[2:] * [-1, -1, 1] + [0, 0, 5]
    same_points(scene, np.add(turned, [10, 0, 0]))
    (node,) = shapes(scene).values()
    is_above = node.shape.vertices[:, 2] > 0.0
    np.testing.assert_allclose(node.shape.normals[:, 0], np.where(is_above, -1, 1), atol=1e-6)


@pytest.mark.parametrize("start", [0, 1, 2, 3, 5])
def test_meshes_are_where_openusd_itself_bakes_them(load, tmp_path, start):
    from pxr import Gf, Usd, UsdGeom, UsdSkel

    scene = load(character(start=start))
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    stage.SetEditTarget(stage.GetSessionLayer())
    # It bakes at samples, between which points move straight.
    UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetPrimAtPath("/r")), Gf.Interval(0, 10))
    baked = UsdGeom.Mesh(stage.GetPrimAtPath("/r/m")).GetPointsAttr().Get(start)
    same_points(scene, np.add(baked, [10, 0, 3]))


@pytest.mark.parametrize(("start", "at"), [(None, 2.0), (1, 1.0)])
def test_seconds_count_from_the_first_time(load, start, at):
    # Both are the time code 2 at one time code a second: half way between the two samples.
    text = character(start=start).replace("    upAxis", "    timeCodesPerSecond = 1\n    upAxis")
    bulged = STILL + np.array([[-0.5, 0, 0], [0, 0, 0], [0.25, 0, 0], [0, 0, 0]])
    bulged[2:] = bulged[2:] * [-1, -1, 1] + [0, 0, 7]
    same_points(load(text, at=at), np.add(bulged, [10, 0, 0]))


def test_animations_of_other_formats_are_no_choice_of_a_stage(load):
    with pytest.raises(SceneError, match="--animation\n  only glTF files name their animations"):
        load(character(), animation="walk")


def test_instances_of_a_character_stand_in_its_pose(load):
    text = character(kind="class SkelRoot", more="", path="/r")
    text += """
def "a" (
    instanceable = true
    inherits = </r>
)
{
}
def "b" (
    instanceable = true
    inherits = </r>
)
{
    double3 xformOp:translate = (20, 0, 0)
}
"""
    scene = load(text)
    assert len(scene.prototypes) == 1
    places = [item.to_world[0, 3] for item in flatten(scene).shapes]
    assert sorted(places) == [10.0, 20.0]
    points = world_points(scene)
    assert points[:, 2].max() == pytest.approx(5.0)


def test_joints_that_are_not_there_are_said(load):
    scene = load(character().replace("[0, 0, 1, 1]", "[0, 0, 1, 2]"))
    same_points(scene, np.add(STILL, [10, 0, 3]))
    assert "/r/m: shown as it is bound to its skeleton" in scene.warnings
