"""Keys of a cluster: one certificate that scheduler, workers and clients show each other.

Whoever holds it may run any code on the workers, and on the client: tasks and answers are pickles.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from alight.core.errors import OptionError, OutputError

if TYPE_CHECKING:
    from distributed import Security

#: The files: the certificate, which signs itself, and its private key.
CERTIFICATE, KEY = "certificate.pem", "key.pem"

_ROLES = ("scheduler", "worker", "client")


def make_keys(folder: Path) -> list[Path]:
    """Write a new certificate and its key, valid for a year; only the owner can read them.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    OutputError
        If there are keys already, or the folder cannot be written.
    """
    from distributed import Security

    made = Security.temporary()
    files = {folder / CERTIFICATE: made.tls_client_cert, folder / KEY: made.tls_client_key}
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        for path, text in files.items():
            # Closed to others from the first byte on; a key that is in use is not overwritten.
            with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:  # noqa: PTH123
                file.write(str(text))
    except OSError as error:
        raise OutputError(f"cannot write {error.filename}: {error.strerror}") from None
    return list(files)


def security_of(folder: Path) -> Security:
    """The keys of a folder, as Dask takes them: the same for scheduler, workers and clients.

    Raises
    ------
    OptionError
        If there are none, or they are not a pair.
    """
    from distributed import Security

    certificate, key = _files(folder)
    words = {}
    for role in _ROLES:
        words |= {f"tls_{role}_cert": certificate, f"tls_{role}_key": key}
    return Security(require_encryption=True, tls_ca_file=certificate, **words)


def role_settings(folder: Path) -> dict[str, Any]:
    """The same as settings of `dask.config`, for processes that are given nothing else.

    Raises
    ------
    OptionError
        If there are none.
    """
    certificate, key = _files(folder)
    found: dict[str, Any] = {
        "distributed.comm.require-encryption": True,
        "distributed.comm.tls.ca-file": certificate,
    }
    for role in _ROLES:
        found[f"distributed.comm.tls.{role}.cert"] = certificate
        found[f"distributed.comm.tls.{role}.key"] = key
    return found


def _files(folder: Path) -> tuple[str, str]:
    import ssl

    certificate, key = str(folder / CERTIFICATE), str(folder / KEY)
    if not (Path(certificate).is_file() and Path(key).is_file()):
        text = f"there is no {CERTIFICATE} and {KEY} in {folder}: alight cluster keys makes them"
        raise OptionError(text, "cluster_keys")
    try:
        ssl.create_default_context().load_cert_chain(certificate, key, password="")
    except (OSError, ValueError) as error:
        why = getattr(error, "reason", None) or getattr(error, "strerror", None) or str(error)
        text = f"{CERTIFICATE} and {KEY} in {folder} are not a certificate and its key: {why}"
        raise OptionError(text, "cluster_keys") from None
    return certificate, key
