"""Training a guide, and the scene that follows it.

Paths start at a small picture of the same view, whatever the film's size, so that the guide does
not depend on how much is rendered. Their samples are thrown away: the picture is unbiased, given
the guide, and each of its samples independent of all others, given the guide. A guide is a function
of scene and seed alone. Where the scene leaves the choice, whether there is one, and of how many
rounds, also depends on the samples that the whole picture is to have. A resumed render makes the
guide of its film again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.guiding.tables import GUIDED, Guide
from alight.guiding.tree import Tree
from alight.lights.tables import LightTables
from alight.rendering.training.trainer import EVERYWHERE, Trainer, framed
from alight.rendering.training.training_plan import ROUNDS, UNKNOWN, Length, TrainingPlan
from lanewise.view import View


class Training(NamedTuple):
    """What training a guide took, and what came of it.

    Attributes
    ----------
    cpu_seconds : float
        Of all threads.
    paths, vertices, arrivals : int
        Paths from the camera, the vertices that they taught, and those of light paths.
    leaves, nodes, bytes : int
        Of the guide.
    gain : float or None
        How many unguided rays one guided ray is worth at equal error, see `Trainer.gain`; None
        if nobody asked.
    used : bool
        Whether the picture's paths follow the guide.
    hash : str
        Names the guide that they follow.
    rounds : int
        That were run.
    """

    cpu_seconds: float
    paths: int
    vertices: int
    arrivals: int
    leaves: int
    nodes: int
    bytes: int
    gain: float | None
    used: bool
    hash: str
    rounds: int

    @classmethod
    def left_out(cls) -> Training:
        """None at all."""
        return cls(0.0, 0, 0, 0, 0, 0, 0, gain=None, used=False, hash=NONE, rounds=0)

    @property
    def identity(self) -> dict[str, Any]:
        """The guide as a part of a film's options, from which it can be made again."""
        return {"guide": self.hash, **({"guide_rounds": self.rounds} if self.used else {})}

    @property
    def line(self) -> str:
        """What the guide gains, and what follows, in words."""
        if self.gain is None:
            return "guide: not trained, as it would not pay (guiding: on trains it all the same)"
        worth = f"a ray with it is worth {self.gain:.2g} without"
        return f"guide: {worth}" if self.used else f"guide: not used, as {worth}"

    def state(self) -> dict[str, Any]:
        """As JSON."""
        return {**self._asdict(), "line": self.line}


#: In place of a guide's hash, where paths follow none.
NONE = "none"


def is_to_be_guided(scene: CompiledScene) -> bool:
    """Whether a scene asks for a guide."""
    return scene.small_view is not None


def with_guide(scene: CompiledScene, guide: Guide) -> CompiledScene:
    """A scene whose paths follow a guide."""
    options = tuple(option for option in scene.program.options if option[0] != GUIDED)
    program = scene.program._replace(options=(*options, (GUIDED, True)))
    return replace(scene, program=program, guide=guide)


def without_guide(scene: CompiledScene) -> CompiledScene:
    """A scene that asks for no guide any more: it has the tables of one that never did."""
    lights = LightTables(*scene.tables.lights[: len(LightTables._fields)])
    return replace(scene, tables=scene.tables._replace(lights=lights), small_view=None)


def untrained(scene: CompiledScene) -> CompiledScene:
    """A scene with a guide that is never asked: it has the kernels of a trained one."""
    frame = framed(EVERYWHERE, np.ones((1, 1), np.float32), scene.size)
    return with_guide(scene, Tree.new().guide(frame))


def length_of(scene: CompiledScene, spp: int | None, is_limit: bool = False) -> Length:
    """How long a scene's picture is; a crop is as long as the whole, whose bits it has.

    Parameters
    ----------
    scene : CompiledScene
    spp : int or None
        Samples per pixel; None where nobody knows.
    is_limit : bool
        Whether it may have fewer.
    """
    width, height = scene.size
    return Length(float(width * height * spp), is_limit) if spp else UNKNOWN


def trained(
    scene: CompiledScene,
    *,
    seed: int,
    threads: int,
    rounds: int = ROUNDS,
    length: Length = UNKNOWN,
    again: Mapping[str, Any] | None = None,
) -> tuple[CompiledScene, Training]:
    """Train a guide for a scene that asks for one.

    Parameters
    ----------
    scene : CompiledScene
    seed : int
        Of the render; training has random numbers of its own.
    threads : int
        They do not change the guide.
    rounds : int
        To be run, where the scene does not leave the choice (`TrainingPlan`).
    length : Length, optional
        Of the picture.
    again : mapping, optional
        `Training.identity` of a guide that is to be made again.

    Returns
    -------
    CompiledScene
        With the guide, or without one where it would not pay and the scene leaves the choice.
    Training
    """
    assert scene.small_view is not None
    chooses = scene.integrator.way_of_guiding == "auto"
    if again:
        chooses, rounds = again["guide"] == NONE, int(again.get("guide_rounds", ROUNDS))
    width, height = scene.small_view.size
    plan = TrainingPlan(rounds, chooses, length, width * height)
    if (again and chooses) or not plan.begins:
        return without_guide(scene), Training.left_out()
    trainer = Trainer(untrained(scene), threads)
    guide = trainer.train(seed, plan)
    arrays = [table.array for table in guide]
    digest = hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()
    took = Training(
        cpu_seconds=sum(trainer.seconds),
        paths=trainer.paths,
        vertices=trainer.vertices,
        arrivals=trainer.arrivals,
        leaves=guide.roots.size,
        nodes=len(guide.nodes.shaped),
        bytes=sum(array.nbytes for array in arrays),
        gain=trainer.gain,
        used=trainer.pays,
        hash=digest[:16] if trainer.pays else NONE,
        rounds=trainer.rounds,
    )
    if not trainer.pays:
        return without_guide(scene), took
    # Trained in another picture: the film has other pixels.
    film = framed(guide.box.array, guide.picture.shaped, scene.size)
    return with_guide(scene, guide._replace(blocks=View(film.blocks))), took
