"""Who may open the page: those who know its address, on a page of its own.

A token is a part of every address. Against pages of strangers in the same browser, which cannot
know it but may try: the host must be one that we serve as (a name that a stranger points at this
machine is none, so DNS rebinding fails), and the origin of a WebSocket must be our own page.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

from alight.core.errors import OptionError

#: Names of this machine that no other machine can reach it by.
LOOPBACK = ("127.0.0.1", "localhost", "::1")

#: Fewest characters of a token that a user chooses.
SHORTEST = 8

#: Sent with every page: nothing is loaded from elsewhere, nothing leaks to others.
HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


@dataclass(frozen=True)
class Access:
    """The rules of one server.

    Parameters
    ----------
    host : str
        Address that is served at.
    token : str
    """

    host: str
    token: str

    @classmethod
    def of(cls, host: str, token: str | None) -> Access:
        """Check what the user asks for, and draw a token where none is given.

        Raises
        ------
        OptionError
            For an address that others reach without a token, and for a token that is short or does
            not fit into an address.
        """
        if token is None:
            if host not in LOOPBACK:
                raise OptionError(
                    "others can reach this address: choose a secret for the page with {token}",
                    "host", names=("token",),
                )  # fmt: skip
            return cls(host, secrets.token_urlsafe(16))
        if not re.fullmatch(rf"[\w.~-]{{{SHORTEST},200}}", token, re.ASCII):
            raise OptionError(
                f"must have at least {SHORTEST} letters, digits or any of - . _ ~", "token"
            )
        return cls(host, token)

    def is_known(self, token: str) -> bool:
        """Whether a token is ours; how long this takes says nothing of how much of it is right."""
        return secrets.compare_digest(token.encode(), self.token.encode())

    def admits(self, headers: Mapping[str, str]) -> bool:
        """Whether a request names a host that we serve as."""
        name = _name_of(headers.get("host", ""))
        if self.host in LOOPBACK:
            return name in LOOPBACK
        # At the address of all interfaces any of their names will do: the token is the secret.
        return bool(name) and (self.host in ("0.0.0.0", "::") or name == self.host.lower())

    def admits_socket(self, headers: Mapping[str, str]) -> bool:
        """Whether a WebSocket is opened by our own page."""
        host, origin = headers.get("host", ""), headers.get("origin", "")
        return origin in (f"http://{host}", f"https://{host}") and self.admits(headers)


def _name_of(host: str) -> str:
    """The name in a Host header, without port and brackets; empty if it is none."""
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""
