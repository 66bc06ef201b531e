"""What comparisons and studies take from the file of a metric."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from alight.core.registry import Record, Records
from alight.core.spec import Spec


class Metric(Spec):
    """Base class of metrics: errors of a picture against a reference, 0 where they are equal."""

    family: ClassVar[str] = "metrics"
    kind: ClassVar[str] = "metric"


class Pair(NamedTuple):
    """A picture, and what it should be.

    Attributes
    ----------
    image, reference : ndarray, shape (h, w, 3)
        Linear sRGB.
    exposure : float
        Stops, for metrics of what a display shows.
    on_display : bool
        At this exposure alone: nothing is brighter than the display.
    """

    image: np.ndarray
    reference: np.ndarray
    exposure: float = 0.0
    on_display: bool = False

    def shown(self) -> Pair:
        """What a display shows of both, linear, in [0, 1]."""
        image, reference = (
            np.clip(np.asarray(one, np.float64) * 2.0**self.exposure, 0.0, 1.0)
            for one in (self.image, self.reference)
        )
        return Pair(image, reference, 0.0, True)


def _nothing() -> str:
    return ""


@dataclass(frozen=True, eq=False, kw_only=True)
class MetricModel(Record):
    """A metric.

    Attributes
    ----------
    LABEL : str
        What tables call it.
    evaluate : (spec, Pair) -> float
        >= 0; NaN where it is not defined.
    weight : (spec, reference) -> ndarray, shape (h, w, 3) or ()
        Of metrics that are means of weighted squared errors: the weights. A reference's own noise
        can be subtracted from these.
    error_map : (spec, Pair) -> ndarray, shape (h, w)
        A map whose mean is the metric, if it is worth looking at.
    label : (spec, Pair) -> str
        Where `LABEL` alone does not say everything.
    shown : float -> float
        What tables show in place of the value, where readers know another form of it.
    missing : () -> str
        What it needs and is not installed; empty if nothing is.
    SLOW : bool
        It takes much longer than the others: studies work it out for some replicates only.
    BOUNDED : bool
        It is never above 1.
    IN_STUDIES : bool
        Studies report it; False if another metric says the same.
    """

    LABEL: str
    evaluate: Callable[[Any, Pair], float]
    weight: Callable[[Any, np.ndarray], np.ndarray] | None = None
    error_map: Callable[[Any, Pair], np.ndarray] | None = None
    label: Callable[[Any, Pair], str] | None = None
    shown: Callable[[float], float] | None = None
    missing: Callable[[], str] = _nothing
    SLOW: bool = False
    BOUNDED: bool = False
    IN_STUDIES: bool = True

    @property
    def example(self) -> Any:
        """The description with its defaults: pictures are compared by this one."""
        return self.spec()


#: All metrics, by name.
METRICS = Records("metrics", MetricModel)


def label_of(name: str, pair: Pair) -> str:
    """What tables call a metric of two pictures."""
    model = METRICS[name]
    return model.LABEL if model.label is None else model.label(model.example, pair)


def shown_of(name: str, value: float) -> float:
    """The form of a value that tables show."""
    model = METRICS[name]
    return value if model.shown is None else model.shown(value)
