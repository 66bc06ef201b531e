"""The page and its socket: who is let in, and that nothing that is said brings it down."""

import asyncio
import json
import re

import numpy as np
import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from alight.core.errors import AlightError, OptionError
from alight.options.view import ViewOptions
from alight.outputs.picture import as_picture
from alight.view import serve
from alight.view.access import HEADERS, Access
from alight.view.layers import FileLayers
from alight.view.mailbox import Mailbox
from alight.view.server import application
from alight.view.session import Session
from tests.view.looking import cornell, settled, wait_for
from tests.view.test_protocol import garbled

HOST = "127.0.0.1:8000"
ORIGIN = {"host": HOST, "origin": f"http://{HOST}"}
TOKEN = "a-token-of-ours"


@pytest.fixture
def picture():
    image = np.linspace(0.0, 1.0, 6 * 8 * 3, dtype=np.float32).reshape(6, 8, 3)
    return Session("ramp.exr", FileLayers(as_picture(image)))


@pytest.fixture
def client(picture):
    made = application(picture, Access("127.0.0.1", TOKEN))
    with TestClient(made, base_url=f"http://{HOST}") as found:
        yield found


def socket(client, token=TOKEN, headers=ORIGIN):
    return client.websocket_connect(f"/{token}/socket", headers=headers)


def is_let_in(client, token=TOKEN, headers=ORIGIN):
    try:
        with socket(client, token, headers):
            return True
    except WebSocketDisconnect:
        return False


def receive(connection, kind):
    """The next message of a kind: a text by its `is`, or a frame."""
    while True:
        message = connection.receive()
        if message.get("bytes") is not None:
            if kind == "frame":
                return message["bytes"]
        elif json.loads(message["text"])["is"] == kind:
            return json.loads(message["text"])


def test_the_page_is_there_with_everything_that_it_names(client):
    page = client.get(f"/{TOKEN}/")
    assert page.status_code == 200
    named = set(re.findall(r'(?:src|href)="([\w.]+)"', page.text))
    for name in named:
        found = client.get(f"/{TOKEN}/{name}")
        assert found.status_code == 200
        for other in re.findall(r'from "\./([\w.]+)"', found.text):
            assert client.get(f"/{TOKEN}/{other}").status_code == 200
    assert {"main.js", "style.css"} <= named
    for name, value in HEADERS.items():
        assert page.headers[name] == value
    assert TOKEN not in page.text
    assert "http" not in page.text.replace("http-equiv", "")


@pytest.mark.parametrize("path", ["/", "/wrong/", "/wrong/main.js", "/wrong/save/film.alight",
                                  f"/{TOKEN}x/", f"/{TOKEN[:-1]}/", "/%C3%A9/"])  # fmt: skip
def test_without_the_token_nothing_is_given(client, path):
    answer = client.get(path)
    assert answer.status_code in (403, 404)
    assert "ramp" not in answer.text


@pytest.mark.parametrize(
    "path", ["../../pyproject.toml", "..%2f..%2fpyproject.toml", "%2e%2e/server.py", "/etc/passwd",
             "save/..%2f..%2fx.exr", "save/other.exr", "__init__.py", "page/main.js", "main.js%00"],
)  # fmt: skip
def test_a_path_in_a_request_leads_nowhere(client, path):
    assert client.get(f"/{TOKEN}/{path}").status_code in (403, 404)


@pytest.mark.parametrize("host", ["stranger.example", "127.0.0.1.stranger.example", "", "[", "a b"])
def test_a_strangers_name_for_this_machine_is_refused(client, host):
    assert client.get(f"/{TOKEN}/", headers={"host": host}).status_code == 403
    assert not is_let_in(client, headers={"host": host, "origin": f"http://{host}"})


STRANGERS = [
    "http://stranger.example", "null", "", "http://localhost:8000", f"http://{HOST}1",
    f"ftp://{HOST}", f"http://u@{HOST}",
]  # fmt: skip


@pytest.mark.parametrize("origin", STRANGERS)
def test_a_strangers_page_gets_no_socket(client, origin):
    assert not is_let_in(client, headers=ORIGIN | {"origin": origin})


@pytest.mark.parametrize(("token", "headers"), [("wrong", ORIGIN), (TOKEN, {"host": HOST})])
def test_a_socket_needs_token_and_origin(client, token, headers):
    assert is_let_in(client)
    assert not is_let_in(client, token, headers)


def test_a_browser_gets_state_and_picture(client):
    with socket(client) as connection:
        frame = receive(connection, "frame")
        assert np.frombuffer(frame[:16], "<u4").tolist() == [0, 8, 6, 0]
        assert len(frame) == 16 + 8 * 6 * 4
        state = receive(connection, "state")
        assert (state["kind"], state["size"], state["layer"]) == ("picture", [8, 6], "picture")
        connection.send_text('{"do": "pixel", "x": 7, "y": 5}')
        assert receive(connection, "pixel")["values"]["picture"][2] == 1.0


def test_exposure_brightens_the_picture_for_all_who_look(client):
    with socket(client) as one, socket(client) as other:
        before = receive(other, "frame")
        one.send_text(
            '{"do": "develop", "exposure": 2, "tone_map": "none", "white_balance": "none"}'
        )
        wait_for(lambda: receive(other, "frame")[16:] > before[16:], 20)


def test_a_state_is_never_ahead_of_the_pictures_before_it():
    """Nor does a browser that is slow hear of pictures alone."""

    async def heard(sent):
        mailbox, found = Mailbox(), []
        for number in range(1, 40):
            for kind in ("frame", "kept", "state"):
                mailbox.post(kind, f"{kind} {number}")
            await asyncio.sleep(0)
            found += [await mailbox.next() for _ in range(sent)]
        return [tuple(message.split()) for message in found]

    for sent in (1, 2, 3):
        newest = {"frame": 0, "kept": 0, "state": 0}
        for kind, number in asyncio.run(heard(sent)):
            newest[kind] = int(number)
            assert newest["state"] <= min(newest["frame"], newest["kept"])
        assert min(newest.values()) > 20


def test_ten_thousand_malformed_messages_leave_the_server_alive(client):
    with socket(client) as connection:
        for seed in range(10_000):
            connection.send_text(garbled(seed))
        connection.send_bytes(b"\x00" * 100)
        connection.send_text('{"do": "pixel", "x": 1, "y": 1}')
        wait_for(lambda: receive(connection, "pixel")["x"] == 1, 60)
    assert client.get(f"/{TOKEN}/").status_code == 200


def test_what_is_saved_is_what_is_shown(client, picture):
    answer = client.get(f"/{TOKEN}/save/picture.exr")
    assert answer.headers["content-disposition"].startswith('attachment; filename="ramp.exr"')
    assert answer.content[:4] == b"\x76\x2f\x31\x01"
    refused = client.get(f"/{TOKEN}/save/film.alight")
    assert (refused.status_code, refused.text) == (409, "this is no film")


@pytest.mark.parametrize(("title", "plain", "whole"), [
    ("my ramp.exr", "myramp", "my%20ramp"),
    ("сцена.exr", "alight", "%D1%81%D1%86%D0%B5%D0%BD%D0%B0"),
    ('a"b;c.exr', "abc", "a%22b%3Bc"), ("a\udcff.exr", "a", "a%3F"),
])  # fmt: skip
def test_a_saved_file_has_the_name_of_the_scene(client, picture, title, plain, whole):
    picture.title = title
    told = client.get(f"/{TOKEN}/save/picture.exr").headers["content-disposition"]
    assert told == f"attachment; filename=\"{plain}.exr\"; filename*=UTF-8''{whole}.exr"


def test_a_scene_is_moved_rendered_and_saved_over_the_socket(tmp_path):
    import alight

    session = cornell()
    made = application(session, Access("127.0.0.1", TOKEN))
    with TestClient(made, base_url=f"http://{HOST}") as client, socket(client) as connection:
        settled(session)
        connection.send_text('{"do": "orbit", "x": 0.05, "y": 0}')
        connection.send_text('{"do": "rest"}')
        wait_for(lambda: session.number == 1)
        settled(session)
        (tmp_path / "a.alight").write_bytes(client.get(f"/{TOKEN}/save/film.alight").content)
        scene = tmp_path / "scene.yaml"
        scene.write_bytes(client.get(f"/{TOKEN}/save/scene.yaml").content)
        again = alight.render(scene, spp=4, threads=1)
        np.testing.assert_array_equal(alight.Film.load(tmp_path / "a.alight").sums, again.sums)
    assert not session.live._thread.is_alive()


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.2", "studio.example"])
def test_others_are_served_only_with_a_token_of_ones_own(host):
    with pytest.raises(OptionError, match="token") as refused:
        Access.of(host, None)
    assert "with --token" in refused.value.spelled(lambda name: f"--{name}")
    assert Access.of(host, "long-enough").token == "long-enough"


@pytest.mark.parametrize(
    "token", ["", "short", "with/slash1", "with space1", "ümlaut-long", "a" * 201]
)
def test_a_token_is_long_and_fits_into_an_address(token):
    with pytest.raises(OptionError, match="token"):
        Access.of("127.0.0.1", token)


def test_tokens_are_drawn_anew():
    tokens = {Access.of("127.0.0.1", None).token for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) >= 20


def test_without_the_extra_one_message_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(serve, "find_spec", lambda name: None)
    with pytest.raises(OptionError, match=r'pip install ".*\[view\]"'):
        serve.serve("cornell-box", ViewOptions(), print)


def test_an_address_that_is_taken_is_said():
    listener = serve._bound(ViewOptions())
    try:
        with pytest.raises(OptionError, match="cannot serve at 127"):
            serve._bound(ViewOptions(port=listener.getsockname()[1]))
    finally:
        listener.close()


def test_nothing_stays_open_when_there_is_nothing_to_view(monkeypatch):
    bound, made = serve._bound, []
    monkeypatch.setattr(serve, "_bound", lambda options: made.append(bound(options)) or made[-1])
    with pytest.raises(AlightError, match="no such scene file"):
        serve.serve("none.yaml", ViewOptions(), print)
    assert [listener.fileno() for listener in made] == [-1]
