"""The page and its WebSocket, as a Starlette application.

Every address begins with the token. Files of the page are known by name: no path of a request is
ever looked up on the disk.
"""

from __future__ import annotations

import asyncio
import json
import tempfile
from collections.abc import Awaitable, Callable
from contextlib import asynccontextmanager
from importlib import resources
from pathlib import Path
from urllib.parse import quote

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from alight.core.errors import AlightError
from alight.view import protocol
from alight.view.access import HEADERS, Access
from alight.view.mailbox import Mailbox
from alight.view.painter import Painter
from alight.view.saving import SAVED, save
from alight.view.session import Session

_TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}

#: Slow answers that one browser may wait for.
MOST_SLOW = 2

#: Code with which a WebSocket is closed that is not admitted ("policy violation").
_REFUSED = 1008


def application(session: Session, access: Access) -> Starlette:
    """Serve a session to those who know the address; it ends with the application."""
    painter = Painter(session)
    page = {
        file.name: file.read_bytes()
        for file in (resources.files("alight.view") / "page").iterdir()
        if file.name.rpartition(".")[2] in _TYPES
    }

    def admitted(answer: Callable[[Request], Awaitable[Response]]) -> Callable:
        async def guarded(request: Request) -> Response:
            known = access.is_known(request.path_params["token"])
            if not (known and access.admits(request.headers)):
                return PlainTextResponse("forbidden", 403, headers=HEADERS)
            return await answer(request)

        return guarded

    async def show(request: Request) -> Response:
        name = request.path_params.get("name") or "index.html"
        if name not in page:
            return PlainTextResponse("not found", 404, headers=HEADERS)
        kind = _TYPES[name.rpartition(".")[2]]
        return Response(page[name], media_type=kind, headers=HEADERS)

    async def give(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in SAVED:
            return PlainTextResponse("not found", 404, headers=HEADERS)
        try:
            content = await run_in_threadpool(_saved, session, name)
        except AlightError as error:
            return PlainTextResponse(str(error), 409, headers=HEADERS)
        told = {"content-disposition": _attachment(Path(session.title).stem, Path(name).suffix)}
        kind = "application/octet-stream"
        return Response(content, media_type=kind, headers=HEADERS | told)

    async def listen(socket: WebSocket) -> None:
        known = access.is_known(socket.path_params["token"])
        if not (known and access.admits_socket(socket.headers)):
            await socket.close(_REFUSED)
            return
        await socket.accept()
        await _serve(socket, session, painter)

    @asynccontextmanager
    async def lifespan(_: Starlette):
        yield
        painter.close()
        session.close()

    return Starlette(
        routes=[
            WebSocketRoute("/{token}/socket", listen),
            Route("/{token}/save/{name}", admitted(give)),
            Route("/{token}/", admitted(show)),
            Route("/{token}/{name}", admitted(show)),
        ],
        lifespan=lifespan,
    )


async def _serve(socket: WebSocket, session: Session, painter: Painter) -> None:
    """Read events and send frames until the browser goes."""
    mailbox = Mailbox()
    painter.join(mailbox)
    sending = asyncio.create_task(_send(socket, mailbox))
    slow: set[asyncio.Task[None]] = set()
    try:
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            try:
                text = message.get("text")
                if text is None:
                    raise protocol.RefusedError("messages are texts")
                event = protocol.parse(text)
                if isinstance(event, protocol.SLOW):
                    if len(slow) >= MOST_SLOW:
                        raise protocol.RefusedError(f"{event.word}: wait for the answers before")
                    slow.add(task := asyncio.create_task(_answer(mailbox, session, event)))
                    task.add_done_callback(slow.discard)
                else:
                    await _answer(mailbox, session, event)
            except protocol.RefusedError as error:
                mailbox.answer(json.dumps({"is": "refused", "why": str(error)}))
    finally:
        painter.leave(mailbox)
        sending.cancel()


async def _answer(mailbox: Mailbox, session: Session, event: protocol.Event) -> None:
    """Do what a browser asks, in a thread of its own, and answer if there is an answer."""
    try:
        answer = await run_in_threadpool(session.apply, event)
    except (protocol.RefusedError, AlightError) as error:
        answer = {"is": "refused", "why": str(error)}
    if answer is not None:
        mailbox.answer(json.dumps(answer, allow_nan=False))


async def _send(socket: WebSocket, mailbox: Mailbox) -> None:
    try:
        while True:
            message = await mailbox.next()
            if isinstance(message, str):
                await socket.send_text(message)
            else:
                await socket.send_bytes(message)
    except (WebSocketDisconnect, RuntimeError):
        # The browser left while it was being sent to; reading notices, too.
        return


def _attachment(stem: str, suffix: str) -> str:
    """Name a file for the browser: in ASCII, and as it is (RFC 6266)."""
    plain = "".join(c for c in stem if c.isascii() and (c.isalnum() or c in "-_")) or "alight"
    whole = quote(stem + suffix, "", errors="replace")
    return f"attachment; filename=\"{plain}{suffix}\"; filename*=UTF-8''{whole}"


def _saved(session: Session, name: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        save(session, path)
        return path.read_bytes()
