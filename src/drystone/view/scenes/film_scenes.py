"""A film: a scene that plays a simulated fall."""

from __future__ import annotations

import numpy as np

from drystone.fall import Film
from drystone.view.scenes.header import directions, facts_of
from drystone.view.scenes.palette import State
from drystone.view.scenes.scene import Scene, Stage

NO_VERDICT = "a simulated fall: no verdict"


def film_scene(film: Film, source: str = "") -> Scene:
    """A scene that plays a film in the time that it took."""
    assembly, model = film.assembly, film.model
    state = np.where(assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)
    state[film.fell] = State.FALLING
    up, gravity = directions(assembly, model.load)
    headline = film.message[0].upper() + film.message[1:]
    message = "; ".join([NO_VERDICT, film.engine, *model.notes])
    stage = Stage(
        "film", headline, message, state, motion=film.positions[-1], motion_name="Film",
        path=film.positions if len(film) > 1 else None, seconds=float(film.time[-1]), plays=True,
        up=up, gravity=gravity,
    )  # fmt: skip
    facts = facts_of(assembly, film.contacts, model.load, source)
    title = f"drystone: {film.message}"
    return Scene(assembly, film.contacts, (stage,), title, facts, preset="solid")


__all__ = ["film_scene"]
