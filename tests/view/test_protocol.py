"""Messages of the browser: what is one becomes an event, everything else is refused."""

import json
import random
from dataclasses import fields

import numpy as np
import pytest

from alight.view import protocol
from alight.view.frames import frame
from alight.view.protocol import EVENTS, RefusedError

VALUES = {"float": 0.25, "int": 3, "str": "picture", "bool": True}


def message(event):
    return {"do": event.word} | {one.name: VALUES[one.type] for one in fields(event)}


@pytest.mark.parametrize("event", EVENTS.values(), ids=EVENTS.keys())
def test_every_word_is_read_with_exactly_its_keys(event):
    said = message(event)
    found = protocol.parse(json.dumps(said))
    assert type(found) is event
    assert {one.name: getattr(found, one.name) for one in fields(event)} == {
        key: value for key, value in said.items() if key != "do"
    }
    for wrong in (
        {**said, "more": 1},
        *({k: v for k, v in said.items() if k != key} for key in said),
    ):
        with pytest.raises(RefusedError):
            protocol.parse(json.dumps(wrong))


@pytest.mark.parametrize("event", EVENTS.values(), ids=EVENTS.keys())
def test_the_protocol_is_described_where_it_is_read(event):
    assert f'{{"do": "{event.word}"' in protocol.__doc__


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", "3", '"orbit"', "{}", '{"do": null}', '{"do": ["orbit"]}',
     '{"do": "orbit", "x": NaN, "y": 0}', '{"do": "orbit", "x": 1e999, "y": 0}',
     '{"do": "orbit", "x": 1001, "y": 0}', '{"do": "orbit", "x": true, "y": 0}',
     '{"do": "orbit", "x": "1", "y": 0}', '{"do": "pixel", "x": 1.0, "y": 0}',
     '{"do": "pixel", "x": -1, "y": 0}', '{"do": "pixel", "x": 1000000000000, "y": 0}',
     '{"do": "camera", "name": 3}', "[" * 4000, '{"do": "rest"}' + " " * protocol.LONGEST,
     '{"do": "orbit", "x": 1' + "0" * 400 + ', "y": 0}', "\x00", "\ud800"],
)  # fmt: skip
def test_what_is_no_message_is_refused(text):
    with pytest.raises(RefusedError):
        protocol.parse(text)


def garbled(seed):
    """A message with some random slip: of a character, of a value, of its length."""
    draw = random.Random(seed)
    said = message(draw.choice(list(EVENTS.values())))
    key = draw.choice(list(said))
    said[key] = draw.choice([None, True, [], {}, "\x00", -1, 1e308, 10**30, "a" * 5000, said[key]])
    text = list(json.dumps(said))
    for _ in range(draw.randrange(4)):
        text[draw.randrange(len(text))] = chr(draw.randrange(1, 0xD7FF))
    return "".join(text)


def test_ten_thousand_garbled_messages_are_events_or_refused():
    refused = 0
    for seed in range(10_000):
        try:
            assert isinstance(protocol.parse(garbled(seed)), protocol.Event)
        except RefusedError as error:
            assert str(error)
            refused += 1
    assert refused > 5_000


def test_a_frame_says_what_it_is():
    rgba = np.arange(2 * 3 * 4, dtype=np.uint8).reshape(2, 3, 4)
    packed = frame(1, 7, rgba)
    assert np.frombuffer(packed[:16], "<u4").tolist() == [1, 3, 2, 7]
    assert packed[16:] == rgba.tobytes()
