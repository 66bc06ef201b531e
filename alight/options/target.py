"""The option for which processors kernels are compiled, and its effect."""

from __future__ import annotations

from alight.core.errors import OptionError
from alight.options.kinds import Choice
from alight.options.table import SAMPLING, Options, option, table
from lanewise.machine import TARGETS, choose_target


@table
class TargetOptions(Options):
    """For which processors code is made."""

    target: str | None = option(
        Choice("target", TARGETS),
        "native, or portable: the same bits on every x86-64-v3 processor, but slower.",
        default=None, shown="native, or as this process has begun", panel=SAMPLING,
    )  # fmt: skip

    def take_target(self) -> None:
        """Compile for the target from now on, if one is asked for.

        Raises
        ------
        OptionError
            If that is too late, or cannot be.
        """
        if self.target is not None:
            try:
                choose_target(self.target)
            except ValueError as error:
                raise OptionError(str(error), "target") from None
