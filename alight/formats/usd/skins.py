"""Meshes as their skeletons and blend shapes hold them at the time that is shown.

Source: Pixar, OpenUSD documentation, "UsdSkel: Skinning, Binding and Blend Shapes".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.fields import LARGEST
from alight.formats.geometry.skinning import Matrices, held
from alight.formats.usd.modules import Usd, UsdGeom, UsdSkel
from alight.formats.usd.stage import Stage

Rows = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """What moves the points of one mesh.

    Attributes
    ----------
    joints : (n, k) int64
        Of each point; k is 0 where only blend shapes move it.
    weights : (n, k) float64
    matrices : (m, 4, 4) float64
        Of the joints, in the space of the mesh, for column vectors.
    shifts : (n, 3) float64
        What blend shapes add to the points, before the joints move them.
    """

    joints: NDArray[np.int64]
    weights: NDArray[np.float64]
    matrices: Matrices
    shifts: Rows

    def moved(self, points: Rows) -> Rows:
        """The points where they are shown."""
        return held(self.joints, self.weights, self.matrices, points + self.shifts, None)[0]

    def turned(self, corners: NDArray[np.int64], normals: Rows) -> Rows:
        """The normals of corners, each of a point."""
        rows = np.zeros((len(corners), 3))
        found = held(self.joints[corners], self.weights[corners], self.matrices, rows, normals)[1]
        assert found is not None
        return found


def poses_of(stage: Stage, root: Any) -> dict[str, Pose]:
    """Poses of the meshes below a SkelRoot, by their paths."""
    # Prims of instances have skeletons too.
    every = Usd.TraverseInstanceProxies()
    cache, places = UsdSkel.Cache(), UsdGeom.XformCache(stage.time)
    cache.Populate(UsdSkel.Root(root), every)
    found: dict[str, Pose] = {}
    for binding in cache.ComputeSkelBindings(UsdSkel.Root(root), every):
        skeleton = cache.GetSkelQuery(binding.GetSkeleton())
        placed = places.GetLocalToWorldTransform(binding.GetSkeleton().GetPrim())
        for target in binding.GetSkinningTargets():
            prim = target.GetPrim()
            pose = _pose(stage, skeleton, target, placed, places)
            if pose is None:
                stage.report.approximate(f"{prim.GetPath()}: shown as it is bound to its skeleton")
            elif prim.IsA(UsdGeom.Mesh):
                stage.report.count("skinned meshes")
                found[str(prim.GetPath())] = pose
    return found


def _pose(stage: Stage, skeleton: Any, target: Any, placed: Any, places: Any) -> Pose | None:
    """The pose of one mesh, or None if what the file says of it does not fit together."""
    prim = target.GetPrim()
    count = len(stage.value(UsdGeom.PointBased(prim).GetPointsAttr(), []))
    shifts = _shifts(stage, skeleton, target, count)
    if not target.HasJointInfluences():
        none = np.zeros((count, 0))
        return Pose(none.astype(np.int64), none, np.eye(4)[None], shifts)
    moves = skeleton.ComputeSkinningTransforms(stage.time) if skeleton else None
    influences = target.ComputeVaryingJointInfluences(count, stage.time)
    if not moves or not influences:
        return None
    moves = np.array(moves).reshape(-1, 4, 4)
    own = target.GetJointOrder()
    if own is not None:
        order = skeleton.GetJointOrder()
        if len(order) != len(moves):
            return None
        moves = _in_order(moves, order, own, np.eye(4))
    if target.GetSkinningMethod() == UsdSkel.Tokens.dualQuaternion:
        stage.report.approximate(f"{prim.GetPath()}: joints are blended linearly, not as rotations")
    bound = np.array(target.GetGeomBindTransform(stage.time))
    back = np.array(placed * places.GetLocalToWorldTransform(prim).GetInverse())
    with np.errstate(over="ignore", invalid="ignore"):
        matrices = (bound @ moves @ back).transpose(0, 2, 1)
    joints, weights = (np.array(part) for part in influences)
    fits = count > 0 and len(joints) == len(weights) and len(joints) % count == 0
    if not fits or not 0 <= joints.min(initial=0) <= joints.max(initial=0) < len(matrices):
        return None
    if not (np.abs(matrices) <= LARGEST).all() or not np.isfinite(weights).all():
        return None
    shape = (count, -1)
    return Pose(joints.reshape(shape).astype(np.int64), weights.reshape(shape), matrices, shifts)


def _in_order(rows: Any, given: Sequence[str], wanted: Sequence[str], absent: Any) -> Any:
    """Rows that stand in the order of some names, in that of others; `absent` where there is none.

    The mappers of OpenUSD do this, but not for whole arrays of Python.
    """
    place = {name: number for number, name in enumerate(given)}
    return np.array([rows[place[name]] if name in place else absent for name in wanted])


def _shifts(stage: Stage, skeleton: Any, target: Any, count: int) -> Rows:
    """What blend shapes add to the points of a mesh, with the weights of the animation."""
    shifts = np.zeros((count, 3))
    animation = skeleton.GetAnimQuery() if skeleton else None
    if not target.HasBlendShapes() or not animation:
        return shifts
    weights = animation.ComputeBlendShapeWeights(stage.time)
    if not weights:
        return shifts
    names = animation.GetBlendShapeOrder(), target.GetBlendShapeOrder()
    if len(weights) != len(names[0]):
        name = animation.GetPrim().GetPath()
        text = f"{len(weights)} weights for {len(names[0])} blend shapes; left out"
        stage.report.approximate(f"{name}: {text}")
        return shifts
    weights = _in_order(np.array(weights, np.float64), *names, 0.0).tolist()
    query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(target.GetPrim()))
    if len(weights) != query.GetNumBlendShapes():
        return shifts
    parts, shapes, subshapes = query.ComputeSubShapeWeights(weights)
    where, by = query.ComputeBlendShapePointIndices(), query.ComputeSubShapePointOffsets()
    for weight, shape, subshape in zip(parts, shapes, subshapes, strict=True):
        offsets, chosen = np.array(by[subshape], np.float64), np.array(where[shape], np.int64)
        chosen = chosen if len(chosen) else np.arange(count)
        if len(offsets) != len(chosen) or chosen.min(initial=0) < 0 or chosen.max() >= count:
            name = query.GetBlendShape(shape).GetPrim().GetPath()
            stage.report.approximate(f"{name}: its offsets do not fit the mesh; left out")
            continue
        np.add.at(shifts, chosen, weight * offsets)
    if shifts.any():
        text = "normals of the file stay those of the shape before it is blended"
        stage.report.approximate(f"{target.GetPrim().GetPath()}: {text}")
    return shifts
