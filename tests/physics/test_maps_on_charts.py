"""Normal maps bend along the axes of their picture, on every shape and on charts of every kind."""

import numpy as np
import pytest

from alight.accel import intersect_closest
from alight.bsdfs.adapters.normal_map import NormalMap
from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.matte.diffuse import Diffuse
from alight.core.vec import Vec3
from alight.formats import loads
from alight.scene import matrix
from alight.shapes.derivatives import uv_derivatives
from alight.shapes.surfaces import make_surface
from alight.textures.bitmap import Bitmap
from lanewise.jit import instantiate
from tests.rendering.many_paths import prepared
from tests.shapes.test_tangents import SURFACES
from tests.shapes.tracing import PLACEMENTS, directions, finite, rows, unit, vec

N = 800
#: Colours of a map, and the normal in them: x along u, y along v.
TEXEL, NORMAL = (0.7, 0.65, 0.9), np.array([0.4, 0.3, 0.8])
SCENE = """
alight: 1
camera: {type: pinhole}
environment: {type: constant}
nodes: {thing: {shape: rectangle, bsdf: {type: diffuse}}}
"""


def hit_surfaces(shape, placement, follow_uv, texture=TEXEL):
    """The tables of a bent thing, a way to run kernels there, and what rays find."""
    scene = loads(SCENE, "charts")
    bsdf = NormalMap(
        texture=texture,
        bsdf=Diffuse(reflectance=1.0),
        rims="black",
        fading=False,
        follow_uv=follow_uv,
    )
    thing = scene.nodes["thing"].replaced(shape=shape, bsdf=bsdf, transform=matrix(placement))
    compiled = prepared(scene.replaced(nodes={"thing": thing}))

    def run(kernel, *arguments):
        with np.errstate(all="ignore"):
            return instantiate(kernel, compiled.program, compiled=False)(
                compiled.tables, *arguments
            )

    rng = np.random.default_rng(5)
    target = unit(rng.normal(size=(3, N)))
    if shape.type_name() != "sphere":
        target = rng.uniform(-0.7, 0.7, (3, N))
        target[2] *= 0.0 if shape.type_name() != "cylinder" else 1.0
    d = directions(N, rng)
    o, d = vec(placement[:3, :3] @ target + placement[:3, 3:] - 3.0 * d), vec(d)
    hit = run(intersect_closest, o, d, np.full(N, np.inf, np.float32), np.ones(N, bool))
    found = np.isfinite(hit.t)
    return run, run(make_surface, finite(hit), o, d, found), found


@pytest.mark.parametrize("follow_uv", [True, False], ids=["along v", "right-handed"])
@pytest.mark.parametrize("placement", ["moved", "sheared", "mirrored"])
@pytest.mark.parametrize("shape", SURFACES.values(), ids=SURFACES)
def test_the_normal_leans_along_u_and_v(shape, placement, follow_uv):
    run, surface, found = hit_surfaces(shape, PLACEMENTS[placement], follow_uv)
    along, across = (rows(v) for v in run(uv_derivatives, surface))
    check_normals(run, surface, found, along, across, follow_uv)


#: What KHR_texture_transform and UsdTransform2d do to pictures.
LOOKUPS = {
    "quarter turn": {"rotate": 90},
    "half turn": {"rotate": 180},
    "some turn": [{"scale": [2.0, 0.7]}, {"rotate": 30}, {"translate": [0.3, 0.1]}],
    "mirrored along u": {"scale": [-1.0, 1.0]},
    "mirrored along v": {"scale": [1.0, -2.0]},
    "mirrored along both": {"scale": -1.0},
    "skewed": {"matrix": [[1.0, 0.4, 0.0], [0.3, -0.8, 0.0]]},
    "larger": {"scale": 3.0},
}


@pytest.mark.parametrize("to_uv", LOOKUPS.values(), ids=LOOKUPS)
@pytest.mark.parametrize("kind", ["sphere", "smooth charts"])
def test_the_normal_leans_along_the_sides_of_a_turned_picture(kind, to_uv):
    """They are what u and v are after `to_uv`, whose derivatives follow by the chain rule."""
    shape = SURFACES[kind]
    texels = np.float32([[TEXEL]])
    picture = Bitmap(pixels=texels, color_space="linear", to_uv=to_uv)
    run, surface, found = hit_surfaces(shape, PLACEMENTS["sheared"], True, picture)
    du, dv = (rows(v) for v in run(uv_derivatives, surface))
    (a, b), (c, d) = np.linalg.inv(picture.to_uv.matrix[:, :2])
    check_normals(run, surface, found, a * du + c * dv, b * du + d * dv, True)


def check_normals(run, surface, found, along, across, follow_uv):
    """See that normals lean along dp/du, and along dp/dv or at right angles to it."""
    n = rows(surface.ns)
    u = along - (along * n).sum(0) * n
    clear = found & (np.linalg.norm(u, axis=0) > 0.02 * np.linalg.norm(along, axis=0))
    u = u / np.maximum(np.linalg.norm(u, axis=0), 1e-12)
    v = np.cross(n, u, axis=0)
    if follow_uv:
        v = np.where((v * across).sum(0) < 0.0, -v, v)
    # Where v hardly grows across u it has no side.
    steep = np.abs((v * across).sum(0)) > 0.02 * np.linalg.norm(across, axis=0)
    clear = clear & (steep | (not follow_uv))
    assert clear.sum() > 0.25 * N
    expected = unit(NORMAL[0] * u + NORMAL[1] * v + NORMAL[2] * n)
    # White matte stuff is as bright as its own normal is turned to the light.
    s, t = rows(surface.s), rows(surface.t)
    every, over = np.ones(N, bool), np.float32([[0.0], [0.0], [1.0]]) * np.ones((3, N), np.float32)
    seen = []
    for wi in unit(np.array([[0.2, 0.1, 1.0], [-0.3, 0.3, 1.0], [0.1, -0.4, 1.0]]).T).T:
        lanes = np.float32(wi)[:, None] * np.ones((3, N), np.float32)
        value, _ = run(evaluate_bsdf, surface, Vec3(*over), Vec3(*lanes), every)
        world = wi[0] * s + wi[1] * t + wi[2] * n
        seen.append(np.pi * np.asarray(value.x, float) - (world * expected).sum(0))
    assert np.quantile(np.abs(seen)[:, clear], 0.99) < 2e-3
