"""`Program`: everything about a scene that is fixed when its kernels are compiled.

Two scenes with the same program share their machine code; numbers (colours, positions, depths)
are not in it.
"""

from __future__ import annotations

from typing import Any, NamedTuple


class Program(NamedTuple):
    """What factories marked with `lanewise.jit.specialised` are given.

    All fields are hashable; the tuples of names are in the order of the family's registry.

    Attributes
    ----------
    shapes, bsdfs, textures, lights : tuple of str
        Models that occur in the scene.
    light_shapes : tuple of str
        Kinds of shape that carry an area light.
    single_light : bool
        There is one light: nothing has to be chosen, and its rows are the same for all lanes.
    environments : tuple of str
        Where there are several, the models of the environments in the order of their rows.
    light_tree : bool
        Lights are chosen by a tree, see `alight.lights.tree.traversal`.
    accel : tuple of str
        Parts of the acceleration structure, see `alight.accel`.
    camera, filter, integrator : str
        Model in use.
    sampler : tuple
        Model in use and its parameters, see `alight.samplers.sampling.sampler_key`.
    options : tuple of (str, value)
        Choices of the sampler and the integrator that are made at compile time, sorted by name.
    aovs : tuple of str
        Further channels.
    media, phases : tuple of str
        Media and phase functions that occur; the former with features, see `alight.media.tables`.
    motion : tuple of str
        What moves while the shutter is open: "shapes", "lights", "camera"; and "rigid" if it all
        only shifts and turns.
    registered : tuple of (str, str, str)
        Family, name and version of the users' own models in it, see `alight.core.registration`.
    """

    shapes: tuple[str, ...] = ()
    bsdfs: tuple[str, ...] = ()
    textures: tuple[str, ...] = ()
    lights: tuple[str, ...] = ()
    light_shapes: tuple[str, ...] = ()
    single_light: bool = False
    light_tree: bool = False
    accel: tuple[str, ...] = ()
    camera: str = ""
    sampler: tuple = ()
    filter: str = ""
    integrator: str = ""
    options: tuple[tuple[str, Any], ...] = ()
    aovs: tuple[str, ...] = ()
    media: tuple[str, ...] = ()
    phases: tuple[str, ...] = ()
    motion: tuple[str, ...] = ()
    registered: tuple[tuple[str, str, str], ...] = ()
    environments: tuple[str, ...] = ()

    def option(self, name: str, default=None):
        """One of `options`."""
        return dict(self.options).get(name, default)
