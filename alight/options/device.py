"""The option of what computes a render."""

from __future__ import annotations

from alight.options.kinds import Choice
from alight.options.table import SAMPLING, Options, option, table

#: The processor, or a GPU of NVIDIA.
CPU, GPU = DEVICES = "cpu", "gpu"


@table
class DeviceOptions(Options):
    """What computes the samples."""

    device: str = option(
        Choice("device", DEVICES),
        "cpu or gpu (NVIDIA's); their pictures agree within noise.",
        default=CPU, panel=SAMPLING,
    )  # fmt: skip
