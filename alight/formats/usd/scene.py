"""A file of OpenUSD -> a description in the native format."""

from __future__ import annotations

import threading

from alight.core.errors import Issue, SceneError, show_value
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.formats.scenes.parsed import Parsed
from alight.formats.usd.graph import Graph
from alight.formats.usd.modules import Tf
from alight.formats.usd.stage import first_line, open_stage, to_world, world_matrix

#: Layers are the process's, whoever has opened them: a stage must be gone before the next one opens
#: its layers again. So nothing of the reader may hold it in a cycle.
_ONE_AT_A_TIME = threading.Lock()


def parse(
    data: bytes,
    name: str,
    reach: Reach | None = None,
    at: float | None = None,
    lenient: bool = False,
) -> Parsed:
    """Read a scene file.

    Parameters
    ----------
    data, name : bytes and str
        Nothing, as OpenUSD reads the file itself; and its name for messages.
    reach : Reach, optional
        Where it lies, and its layers and pictures may lie; the current folder by default.
    at : float, seconds, optional
        After the stage's first time code; that one by default.
    lenient : bool, default False
        Whether a stage may lack layers and pictures.

    Raises
    ------
    SceneError
        If the file is no scene at all.
    """
    with _ONE_AT_A_TIME:
        return _parsed(name, reach or Reach(), at, Report(lenient))


def _parsed(name: str, reach: Reach, at: float | None, report: Report) -> Parsed:
    try:
        stage = open_stage(name, reach, report, at)
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
    return graph.finish()
