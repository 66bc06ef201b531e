"""Walks over the nodes of a scene: all of them, those that are placed, prototypes by use."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from alight.core.errors import join_path
from alight.scene.description import Node, Scene
from alight.scene.transform import Matrix


def all_nodes(scene: Scene) -> Iterator[tuple[str, Node]]:
    """Visit every node, prototypes too: key path and node."""
    for name, prototype in scene.prototypes.items():
        for _, path, node in prototype.walk(name, join_path("prototypes", name)):
            yield path, node
    for _, path, node in scene.walk():
        yield path, node


def placed_nodes(scene: Scene) -> Iterator[tuple[str, Node, Matrix]]:
    """Visit every node with its matrix: to the world, for prototypes to their instances."""
    roots = [(join_path("prototypes", name), node) for name, node in scene.prototypes.items()]
    roots += [(join_path("nodes", name), node) for name, node in scene.nodes.items()]
    for keys, root in roots:
        stack: list[tuple[str, Node, Matrix | None]] = [(keys, root, None)]
        while stack:
            path, node, parent = stack.pop()
            to_world = node.transform.matrix
            if parent is not None:
                with np.errstate(over="ignore", invalid="ignore"):
                    to_world = parent @ to_world
            yield path, node, to_world
            if node.children:
                stack.extend(
                    (f"{path}.children.{name}", child, to_world)
                    for name, child in reversed(node.children.items())
                )


def instances_in(node: Node, prototypes: dict[str, Node]) -> list[str]:
    """The prototypes that a node and what is below it instance."""
    found = (below.instance for _, _, below in node.walk("", ""))
    return [name for name in found if name in prototypes]


def sort_by_use(uses: dict[str, list[str]]) -> tuple[list[str], list[str]]:
    """Sort names so that each comes after those that it uses.

    Returns
    -------
    cycle : list of str
        A chain of names that ends where it began, or empty. The order is then not complete.
    order : list of str
    """
    done: dict[str, None] = {}
    for start in uses:
        chain, pending = [start], [iter(uses[start])]
        while chain:
            following = next((n for n in pending[-1] if n not in done), None)
            if following is None:
                done[chain.pop()] = None
                pending.pop()
            elif following in chain:
                return [*chain[chain.index(following) :], following], list(done)
            else:
                chain.append(following)
                pending.append(iter(uses[following]))
    return [], list(done)


def count_shapes(scene: Scene) -> int:
    """Count the shapes after all instances are put in place; prototypes must have no cycle."""
    counts: dict[str, int] = {}

    def count(nodes: Iterator[Node], in_prototype: Callable[[str], int]) -> int:
        return sum(
            (node.shape is not None) + (in_prototype(node.instance) if node.instance else 0)
            for node in nodes
        )

    def count_prototype(name: str) -> int:
        if name not in scene.prototypes:
            return 0
        if name not in counts:
            nodes = (node for _, _, node in scene.prototypes[name].walk("", ""))
            counts[name] = count(nodes, count_prototype)
        return counts[name]

    return count((node for _, _, node in scene.walk()), count_prototype)
