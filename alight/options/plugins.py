"""Scripts that register models, run before the scene is read."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from alight.core.errors import AlightError, OptionError


def load_plugins(paths: Sequence[Path] | None) -> None:
    """Run each file as a module; what it registers can be named in scenes.

    Raises
    ------
    OptionError
        If a file does not exist, is no Python file, fails, or registers nothing.
    """
    from alight.core.registry import REGISTERED

    for path in paths or ():
        if not path.is_file():
            raise OptionError(f"there is no file {path}", "plugins")
        before = {name: dict(models) for name, models in REGISTERED.items()}
        _run(path)
        if before == REGISTERED:
            raise OptionError(
                f"{path} registers nothing; end it with alight.register(__name__)", "plugins"
            )


def _run(path: Path) -> None:
    name = f"alight_plugin_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise OptionError(f"{path} is not a Python file (.py)", "plugins")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    # As for a script: modules next to it can be imported.
    sys.path.insert(0, str(path.resolve().parent))
    try:
        spec.loader.exec_module(module)
    except AlightError:
        raise
    except Exception as error:
        raise OptionError(f"{_where(error, path)}: {error}", "plugins") from error
    finally:
        sys.path.pop(0)


def _where(error: BaseException, path: Path) -> str:
    """File, line and kind of an error; the innermost line that is the plugin's own."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}:{error.lineno}: {type(error).__name__}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if Path(frame.filename) == path]
    line = f":{own[-1].lineno}" if own else ""
    return f"{path}{line}: {type(error).__name__}"
