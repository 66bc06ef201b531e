"""Meshes that are kept once and seen in many places."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Placed(NamedTuple):
    """An instance in its place: its maps, its row in the tables, and the box around its mesh."""

    forward: np.ndarray
    backward: np.ndarray
    row: np.ndarray
    low: np.ndarray
    high: np.ndarray


def instance_in_place(vertices: np.ndarray, to_world: np.ndarray) -> Placed:
    """Work out the maps (3, 4) of an instance, and its box in the world, metres."""
    forward = to_world[:3].astype(np.float32)
    # The inverse of the rounded matrix: rays and surface points must agree.
    square = np.vstack([forward.astype(np.float64), [0.0, 0.0, 0.0, 1.0]])
    backward = np.linalg.inv(square)[:3].astype(np.float32)
    corners = vertices @ square[:3, :3].T + square[:3, 3]
    row = np.concatenate([forward.ravel(), backward.ravel()])
    return Placed(forward, backward, row, corners.min(axis=0), corners.max(axis=0))
