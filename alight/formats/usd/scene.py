"""A file of OpenUSD -> a description in the native format."""

from __future__ import annotations

from typing import Any

from alight.core.errors import Issue, SceneError, show_value
from alight.formats.model_scene import model_scene
from alight.formats.names import free_name
from alight.formats.parsed import Parsed
from alight.formats.reach import Reach
from alight.formats.report import Report
from alight.formats.usd.graph import Graph
from alight.formats.usd.modules import Tf
from alight.formats.usd.stage import first_line, open_stage, to_world, world_matrix


def parse(data: bytes, name: str, reach: Reach | None = None) -> Parsed:
    """Read a scene file.

    Parameters
    ----------
    data, name : bytes and str
        Content of the file, which OpenUSD reads again itself; and its name for messages.
    reach : Reach, optional
        Where it lies, and its layers and pictures may lie; the current folder by default.

    Raises
    ------
    SceneError
        If the file is no scene at all.
    """
    report = Report()
    try:
        stage = open_stage(name, reach or Reach(), report)
        steps = to_world(stage)
        graph = Graph(stage, world_matrix(steps))
        graph.build(steps)
    except Tf.ErrorException as error:
        issue = Issue("", f"OpenUSD: {first_line(error)}", name)
        raise SceneError([*report.issues, issue]) from None
    except UnicodeDecodeError as error:
        issue = Issue("", f"text must be in UTF-8, got {show_value(error.object)}", name)
        raise SceneError([*report.issues, issue]) from None
    if report.issues:
        raise SceneError(report.issues)
    tables: dict[str, Any] = {
        "bsdfs": graph.bsdfs,
        "prototypes": graph.prototypes,
        "nodes": graph.nodes,
    }
    for around in graph.environments:
        # They stand in the world, not where their prims do.
        if "environment" in tables:
            name = free_name("dome", graph.nodes, "dome")
            graph.nodes[name] = {"light": around}
        else:
            tables["environment"] = around
    return model_scene(
        tables,
        graph.places | {"": name},
        report,
        graph.bounds,
        graph.glow,
        is_lit=graph.is_lit,
        cameras=[path for path, _ in graph.cameras],
        aspect=graph.cameras[0][1] if graph.cameras else 1.0,
        view=graph.view,
    )
