"""A thousand random events leave nothing behind."""

import contextlib
import gc
import json
import random
import threading

import numpy as np

from alight.view import protocol
from alight.view.painter import Painter
from tests.view.looking import cornell, settled

ROUND, ROUNDS = 250, 4


def event(draw):
    """What a hand at the page might do."""
    x, y, by = draw.randrange(24), draw.randrange(16), draw.uniform(-0.05, 0.05)
    return draw.choice(
        [
            {"do": "orbit", "x": by, "y": -by}, {"do": "pan", "x": by, "y": by},
            {"do": "dolly", "by": by}, {"do": "roll", "by": by}, {"do": "rest"},
            {"do": "show", "layer": draw.choice(["picture", "error", "samples"])},
            {"do": "develop", "exposure": by, "tone_map": "agx", "white_balance": "none"},
            {"do": "pixel", "x": x, "y": y}, {"do": "keep"}, {"do": "drop"},
            {"do": "contrast", "way": "difference"}, {"do": "tree"}, {"do": "camera", "name": ""},
        ]
    )  # fmt: skip


def test_a_thousand_random_events_leave_nothing_behind():
    session, draw = cornell(), random.Random(7)
    painter, counts = Painter(session), []
    try:
        for _ in range(ROUNDS):
            for _ in range(ROUND):
                # Asked while there is no picture, some are refused.
                with contextlib.suppress(protocol.RefusedError):
                    session.apply(protocol.parse(json.dumps(event(draw))))
            session.apply(protocol.parse('{"do": "drop"}'))
            session.apply(protocol.parse('{"do": "rest"}'))
            settled(session)
            gc.collect()
            counts.append((len(gc.get_objects()), threading.active_count()))
    finally:
        painter.close()
        session.close()
    # The first rounds fill caches; whatever a move or a frame kept would be there 250 times.
    objects, threads = np.subtract(counts[-1], counts[-2])
    assert objects < ROUND and threads <= 0, counts
