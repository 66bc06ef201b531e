"""``alight view``: the server, from the options of the command line to the end."""

from __future__ import annotations

import socket
import webbrowser
from collections.abc import Callable
from importlib.util import find_spec

from alight.core.errors import OptionError
from alight.core.extras import install_command
from alight.options.view import ViewOptions
from alight.view.access import Access

#: Packages of the extra ``view``.
PACKAGES = ("starlette", "uvicorn", "websockets")


def serve(subject: str, options: ViewOptions, tell: Callable[[str], None]) -> None:
    """View a scene, a film or a picture until interrupted.

    Parameters
    ----------
    subject : str
        Scene file, name of a built-in scene, film or picture.
    options : ViewOptions
    tell : callable
        Given the address of the page.

    Raises
    ------
    AlightError
        For a subject or an option that is wrong, an address that cannot be served at, and without
        the packages of the extra ``view``.
    """
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        command = install_command("view", *PACKAGES)
        raise OptionError(f"the view needs {' and '.join(missing)}: {command}")
    access = Access.of(options.host, options.token)
    import uvicorn

    from alight.view.opening import session_of
    from alight.view.protocol import LONGEST
    from alight.view.server import application

    with _bound(options) as listener:
        session = session_of(subject, options)
        name = f"[{options.host}]" if ":" in options.host else options.host
        address = f"http://{name}:{listener.getsockname()[1]}/{access.token}/"
        tell(address)
        if options.browser:
            webbrowser.open(address)
        server = uvicorn.Server(
            uvicorn.Config(
                application(session, access), log_level="warning", access_log=False,
                ws="websockets-sansio", ws_max_size=4 * LONGEST, ws_per_message_deflate=False,
                timeout_graceful_shutdown=1, server_header=False,
            )
        )  # fmt: skip
        server.run(sockets=[listener])


def _bound(options: ViewOptions) -> socket.socket:
    """A socket at the requested address.

    Raises
    ------
    OptionError
        If it is taken, or none of this machine.
    """
    family = socket.AF_INET6 if ":" in options.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((options.host, options.port))
        # From now on browsers wait for an answer, even before the server is ready to give it.
        listener.listen()
    except OSError as error:
        listener.close()
        where = f"{options.host}:{options.port}"
        raise OptionError(f"cannot serve at {where}: {error.strerror or error}", "host") from None
    return listener
