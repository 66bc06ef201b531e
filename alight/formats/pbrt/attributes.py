"""The directives about where things stand, and about what counts for those that follow."""

from __future__ import annotations

import numpy as np

from alight.core.errors import unknown_name
from alight.formats.pbrt.colors import SPACES
from alight.formats.pbrt.context import Context
from alight.formats.pbrt.directives import Directive, Parameter
from alight.formats.pbrt.making import default_material
from alight.formats.pbrt.state import State
from alight.formats.pbrt.transforms import look_at, only_turns, rotation, scaling, translation

MOST_LEVELS = 1000
_TIMES = {"StartTime": (True, False), "EndTime": (False, True), "All": (True, True)}
_TARGETS = ("shape", "light", "material", "medium", "texture")


class Attributes:
    """Follows the directives that change the state.

    Attributes
    ----------
    systems : dict of str to (4, 4) float64
        Named coordinate systems, to the world.
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self.state = State(default_material())
        self.stack: list[tuple[str, State | tuple, Directive]] = []
        self.systems: dict[str, np.ndarray] = {}
        self.times = 0.0, 1.0

    def close(self) -> None:
        """Report what was not closed."""
        for _, _, directive in self.stack:
            end = directive.name.replace("Begin", "End")
            self.context.report.error(directive, f"has no {end}")

    def append(self, directive: Directive) -> None:
        """Translate, Scale, Rotate, LookAt or ConcatTransform."""
        # What becomes too large is refused below.
        with np.errstate(over="ignore", invalid="ignore"):
            self._append(directive)

    def _append(self, directive: Directive) -> None:
        numbers, name = directive.numbers, directive.name
        matrix: np.ndarray | None
        if name == "Translate":
            matrix = translation(*numbers)
        elif name == "Scale":
            matrix = scaling(*numbers)
        elif name == "Rotate":
            matrix = rotation(float(numbers[0]), numbers[1:])
        elif name == "LookAt":
            matrix = look_at(numbers[:3], numbers[3:6], numbers[6:])
        else:
            matrix = numbers.reshape(4, 4).T
        if matrix is None:
            text = "has no direction: an axis of length 0, or nothing to look at"
            self.context.report.error(directive, text)
        else:
            self.state.append(matrix)

    def set_matrix(self, directive: Directive) -> None:
        """Identity, Transform or CoordSysTransform."""
        if directive.name == "Identity":
            self.state.set_matrix(np.eye(4))
        elif directive.name == "Transform":
            self.state.set_matrix(directive.numbers.reshape(4, 4).T)
        elif directive.type in self.systems:
            self.state.set_matrix(self.systems[directive.type])
        else:
            kind = "coordinate system"
            message = unknown_name(kind, directive.type, self.systems, listed_as="known")
            self.context.report.error(directive, message)

    def name_system(self, directive: Directive) -> None:
        """Follow CoordinateSystem."""
        self.systems[directive.type] = self.state.matrix

    def activate(self, directive: Directive) -> None:
        """Follow ActiveTransform."""
        if directive.type not in _TIMES:
            message = unknown_name("time", directive.type, _TIMES, listed_as="times")
            self.context.report.error(directive, message)
            return
        self.state.changes_start, self.state.changes_end = _TIMES[directive.type]

    def set_times(self, directive: Directive) -> None:
        """Follow TransformTimes."""
        start, end = (float(number) for number in directive.numbers)
        if not start < end:
            text = f"must have an end after its start, got {start:g} and {end:g}"
            self.context.report.error(directive, text)
        else:
            self.times = start, end

    def report_motion(self, directive: Directive) -> None:
        """Warn of what moves while the shutter is open, and does not here."""
        if self.state.is_animated:
            text = "moves: it stands where it is at the start time"
            self.context.report.warn(directive, text)

    def rests(self, directive: Directive, shines: bool, strands: bool = False) -> bool:
        """Whether a shape stands still, as strands do, and lights unless they shift and turn."""
        state = self.state
        kept = strands or (shines and not only_turns(state.matrix, state.ends))
        if state.is_animated and kept:
            self.report_motion(directive)
            return True
        return not state.is_animated

    def begin_attributes(self, directive: Directive) -> None:
        """Keep the state."""
        if len(self.stack) >= MOST_LEVELS:
            self.context.report.error(directive, f"is nested deeper than {MOST_LEVELS} levels")
        else:
            self.stack.append(("Attribute", self.state, directive))
            self.state = self.state.copied()

    def end_attributes(self, directive: Directive) -> None:
        """Go back to the state that was kept."""
        kept = self.pop("Attribute", directive)
        if isinstance(kept, State):
            self.state = kept

    def begin_transform(self, directive: Directive) -> None:
        """Keep the transformations; in pbrt 4 it is another word for AttributeBegin."""
        if not self.context.old:
            self.begin_attributes(directive)
            return
        if len(self.stack) >= MOST_LEVELS:
            self.context.report.error(directive, f"is nested deeper than {MOST_LEVELS} levels")
            return
        state = self.state
        kept = (state.matrix, state.ends, state.changes_start, state.changes_end)
        self.stack.append(("Transform", kept, directive))

    def end_transform(self, directive: Directive) -> None:
        """Go back to the transformations that were kept."""
        if not self.context.old:
            self.end_attributes(directive)
            return
        kept = self.pop("Transform", directive)
        if isinstance(kept, tuple):
            state = self.state
            state.matrix, state.ends, state.changes_start, state.changes_end = kept

    def pop(self, kind: str, directive: Directive) -> State | tuple | None:
        """Take what was kept last, if it is of the kind."""
        if not self.stack or self.stack[-1][0] != kind:
            text = f"has no {kind}Begin before it"
            if self.stack:
                text += f": the last one open is {self.stack[-1][2].name}"
            self.context.report.error(directive, text)
            return None
        return self.stack.pop()[1]

    def set_defaults(self, directive: Directive) -> None:
        """Follow Attribute: parameters for all that follows."""
        if directive.type not in _TARGETS:
            message = unknown_name("target", directive.type, _TARGETS)
            self.context.report.error(directive, message)
            return
        given = {p.name for p in directive.parameters}
        old = [p for p in self.defaults(directive.type) if p.name not in given]
        self.state.defaults = {
            **self.state.defaults,
            directive.type: [*directive.parameters, *old],
        }

    def defaults(self, target: str) -> list[Parameter]:
        """Parameters that ``Attribute`` has set."""
        return self.state.defaults.get(target, [])

    def reverse(self, directive: Directive) -> None:
        """Turn surfaces inside out."""
        self.state.reverse = not self.state.reverse

    def set_space(self, directive: Directive) -> None:
        """Follow ColorSpace."""
        if directive.type in SPACES:
            self.state.space = directive.type
        else:
            message = unknown_name("colour space", directive.type, SPACES)
            self.context.report.error(directive, message)
