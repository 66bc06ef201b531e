"""A scene file of pbrt -> a description in the native format, with the place of every value."""

from __future__ import annotations

import re

import numpy as np

from alight.core.errors import Issue, SceneError
from alight.formats.pbrt import settings
from alight.formats.pbrt.below import put_coats
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.directives import Directive, directives
from alight.formats.pbrt.materials_of_3 import OF_3
from alight.formats.pbrt.stand_ins import ONLY_IN_3
from alight.formats.pbrt.transforms import FACING, inverse, keyframes
from alight.formats.pbrt.words import BrokenError, Words
from alight.formats.pbrt.world import World
from alight.formats.reading.packed import text_of
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.formats.scenes.parsed import Parsed
from alight.scene.build import FORMAT_VERSION

MOST_INCLUDES, MOST_INCLUDE_LEVELS = 10_000, 16
MOST_BYTES = 2**29
#: After so many problems the rest of a file is not looked at.
MOST_ISSUES = 100
_UNUSED = {"Accelerator": "alight builds its own", "Option": "it is an option of pbrt"}


def parse(text: str, name: str, reach: Reach | None = None, lenient: bool = False) -> Parsed:
    """Read a scene file.

    Parameters
    ----------
    text, name : str
        Content of the file, and its name for messages.
    reach : Reach, optional
        Where the files that it names may lie; the current folder by default.
    lenient : bool, default False
        Whether what is not covered is replaced instead of refused.
    """
    report = Report(lenient)
    context = Context(report, reach or Reach(), old=_is_old(text))
    context.colors.old = context.old
    reader = _Reader(context)
    reader.file(text, name)
    data = reader.finish()
    report.sort()
    return Parsed.of(data, context.places | {"": f"{name}:1:1"}, report, reader.spp)


#: What only pbrt 3 has, and what only pbrt 4 has.
_OLD = re.compile(
    r'^[ \t]*(WorldEnd\b|Film\s+"image"|(Material\s+|.*"string type"\s*\[?\s*)"('
    + "|".join((*OF_3, *ONLY_IN_3))
    + ')")',
    re.MULTILINE,
)
_NEW = re.compile(
    r'^[ \t]*(Film\s+"(rgb|gbuffer|spectral)"|Attribute\s|ColorSpace\s|Option\s|.*"(point3|point2) '
    r'|.*"(coateddiffuse|coatedconductor|diffusetransmission|thindielectric)")',
    re.MULTILINE,
)


def _is_old(text: str) -> bool:
    """Whether a file is one of pbrt 3: files do not say, but some words exist in one only."""
    return bool(_OLD.search(text)) and not _NEW.search(text)


class _TooManyError(Exception):
    """So much is wrong that reading on would help nobody."""


class _Reader:
    """Follows the directives of a file and of those that it includes."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.world = World(context)
        self.settings: dict[str, Directive] = {}
        self.camera_ends: np.ndarray | None = None
        self.around_camera: Directive | None = None
        self.spp: int | None = None
        self.in_world = False
        self.levels = self.includes = self.bytes = 0
        self.words: Words | None = None

    def file(self, text: str, name: str) -> None:
        """Follow one file."""
        broken: list[BrokenError] = []
        before = self.words
        self.words = words = Words(text, name, before)
        try:
            for directive in directives(words, broken):
                self.follow(directive)
                if len(self.context.report.issues) + len(broken) > MOST_ISSUES:
                    raise _TooManyError
        except _TooManyError:
            if self.levels:
                raise
            text = f"has more than {MOST_ISSUES} problems: these are the first"
            self.context.report.issues.append(Issue("", text, name))
        finally:
            self.words = before
            for error in broken:
                self.context.report.issues.append(Issue("", str(error), error.place))

    def follow(self, directive: Directive) -> None:
        name = directive.name
        if name in ("Include", "Import"):
            self.include(directive)
        elif name in _UNUSED:
            self.context.report.note(directive, f"is not used: {_UNUSED[name]}")
        elif name in ("Camera", "Film", "PixelFilter", "Sampler", "Integrator"):
            self.setting(directive)
        elif name == "WorldBegin":
            self.begin_world(directive)
        elif name == "WorldEnd":
            pass
        else:
            self.world.follow(directive)

    def setting(self, directive: Directive) -> None:
        if self.in_world:
            text = "must stand before WorldBegin"
            self.context.report.error(directive, text)
            return
        if directive.name in self.settings:
            first = self.settings[directive.name].place
            text = f"is given twice, first at {first}: the last one counts"
            self.context.report.warn(directive, text)
        self.settings[directive.name] = directive
        if directive.name == "Camera":
            state = self.world.state
            self.around_camera = state.media
            self.world.systems["camera"] = self.matrix_of_camera(directive, state.matrix)
            self.camera_ends = None
            if state.is_animated:
                self.camera_ends = self.matrix_of_camera(directive, state.ends)

    def matrix_of_camera(self, directive: Directive, to_camera: np.ndarray) -> np.ndarray:
        to_world = inverse(to_camera)
        if to_world is None:
            text = "its transformation is singular: it flattens space"
            self.context.report.error(directive, text)
            return np.eye(4)
        return to_world

    def begin_world(self, directive: Directive) -> None:
        if self.in_world:
            self.context.report.error(directive, "is given twice")
            return
        self.in_world = True
        self.apply_film()
        self.context.sees_media = settings.sees_media(self.context, self.settings.get("Integrator"))
        self.world.begin()

    def apply_film(self) -> None:
        """Read film and camera: lights need the exposure that they ask for."""
        context, found = self.context, self.settings
        self.film = settings.film(context, found.get("Film"), found.get("PixelFilter"))
        size = self.film["size"]
        if not all(1 <= side <= 2**28 for side in size):
            item = found.get("Film") or Directive("Film", "")
            context.report.error(item, f"must have 1 to {2**28} pixels, got {size[0]} x {size[1]}")
            self.film["size"] = [16, 16]
            self.film.pop("crop", None)
        to_world = self.world.systems.get("camera", np.eye(4))
        self.camera = settings.camera(context, found.get("Camera"), to_world, self.film)
        if self.camera_ends is not None:
            begin, end = to_world @ FACING, self.camera_ends @ FACING
            self.camera["transform"] = keyframes(begin, end, self.world.times)

    def include(self, directive: Directive) -> None:
        context, name = self.context, directive.type
        self.includes += 1
        if self.levels >= MOST_INCLUDE_LEVELS or self.includes > MOST_INCLUDES:
            text = f"files include each other more than {MOST_INCLUDE_LEVELS} levels deep"
            if self.levels < MOST_INCLUDE_LEVELS:
                text = f"there are more than {MOST_INCLUDES} included files"
            context.report.error(directive, text)
            raise _TooManyError
        try:
            path = context.reach.find(name)
            text = text_of(path, MOST_BYTES - self.bytes)
            self.bytes += len(text)
        except OutOfReachError as error:
            context.report.lacks(directive, error, "what it includes is left out")
            return
        except SceneError as error:
            context.report.error(directive, str(error))
            return
        self.levels += 1
        if directive.name == "Import":
            self.world.begin_attributes(directive)
        try:
            self.file(text, str(path))
        finally:
            self.levels -= 1
        if directive.name == "Import":
            self.world.end_attributes(directive)

    def finish(self) -> Data:
        """Put the description together."""
        context, found = self.context, self.settings
        if not self.in_world:
            place = next(iter(found.values()), Directive("WorldBegin", ""))
            context.report.issues.append(
                Issue("", "has no WorldBegin: there is no scene", place.place)
            )
            self.apply_film()
        self.camera |= self.world.media.around_camera(self.around_camera)
        self.world.close()
        in_media = self.world.media.close()
        put_coats(context, self.world.nodes)
        self.spp, sampler = settings.sampler(context, found.get("Sampler"))
        return {
            "alight": FORMAT_VERSION,
            "camera": self.camera,
            "film": self.film,
            "sampler": sampler,
            "integrator": settings.integrator(context, found.get("Integrator"), in_media),
            **({"environment": self.world.environment} if self.world.environment else {}),
            **context.tables,
            "nodes": self.world.nodes,
        }
