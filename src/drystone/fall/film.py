"""What a simulated fall answers: where the blocks are, frame after frame.

An animated GLB has a node per block that moves, with the keys of its frames. Source of the format:
Khronos glTF 2.0 specification, section 3.11 (animations).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.answer import Answer, Role, Scene, SceneStage, Sentence, State
from drystone.answer.drawing import state_of
from drystone.answer.question import directions
from drystone.base.arrays import Bools, Floats
from drystone.base.display import named
from drystone.base.errors import InputError, counted
from drystone.base.files import PathLike, write_bytes
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.io.draft import Contents
from drystone.io.glb import FLOAT, Z_UP, container, glb_content
from drystone.model import Model


def write_film(model: Model, time: Floats, positions: Floats, path: PathLike) -> None:
    """Write blocks that move as an animated GLB, to a temporary name that is then renamed.

    Every block is a node of its name about its centroid; those that move have keys of translation
    and rotation, between which viewers interpolate.

    Parameters
    ----------
    model
    time : (s,) [s], ascending
    positions : (s, n, 6) [m, rad]
        Translations of the centroids and rotation vectors from the beginning.
    path
    """
    content, binary = glb_content(Contents(model.assembly))
    keys = _Keys(binary, content)
    centroid = model.assembly.centroid @ Z_UP
    nodes = content["nodes"]
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, int]] = []
    when = keys.add(time[:, None], "SCALAR", bounds=True)
    for i in range(len(model.assembly)):
        # the surface is in world coordinates: a child that is moved back has it
        inner = {"mesh": nodes[i].pop("mesh"), "translation": (-centroid[i]).tolist()}
        nodes[i] |= {"children": [len(nodes)], "translation": centroid[i].tolist()}
        nodes.append(inner)
        if not positions[:, i].any():
            continue
        place = centroid[i] + positions[:, i, :3] @ Z_UP
        turn = Rotation.from_rotvec(positions[:, i, 3:] @ Z_UP).as_quat()
        # the same rotation has two quaternions: viewers take the short way between near ones
        flips = np.cumprod(np.where((turn[1:] * turn[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
        turn[1:] *= flips[:, None]
        for path_of, values, kind in (("translation", place, "VEC3"), ("rotation", turn, "VEC4")):
            channels.append({"sampler": len(samplers), "target": {"node": i, "path": path_of}})
            samplers.append({"input": when, "output": keys.add(values, kind)})
    if channels:
        content["animations"] = [{"name": "film", "channels": channels, "samplers": samplers}]
    binary = keys.binary()
    content["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    write_bytes(path, container(text, binary))


class _Keys:
    """Arrays of keys, put behind the surfaces."""

    def __init__(self, surfaces: bytes, content: dict[str, Any]) -> None:
        self.parts = [surfaces + b"\0" * (-len(surfaces) % 4)]
        self.length = len(self.parts[0])
        self.content = content

    def add(self, values: Floats, kind: str, *, bounds: bool = False) -> int:
        """The number of the accessor of an array (s, c)."""
        data = np.ascontiguousarray(values, dtype="<f4")
        views, accessors = self.content["bufferViews"], self.content["accessors"]
        views.append({"buffer": 0, "byteOffset": self.length, "byteLength": data.nbytes})
        made = {
            "bufferView": len(views) - 1,
            "componentType": FLOAT,
            "count": len(data),
            "type": kind,
        }
        if bounds:
            made |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
        accessors.append(made)
        self.parts.append(data.tobytes())
        self.length += data.nbytes
        return len(accessors) - 1

    def binary(self) -> bytes:
        """All of them."""
        return b"".join(self.parts)


MOVED = 0.1
"""Travel of a block, by its size, from which on it has fallen. The contacts of the simulator
are soft: what stands moves by a hundredth at most (docs/reference/robots.md)."""


@dataclass(frozen=True)
class FallOptions(Options):
    """Options of :func:`fall`.

    Attributes
    ----------
    duration : > 0
        Largest length of the film, by the time in which a block falls freely by half its size:
        0.32 s for blocks of 1 m, 0.1 s for blocks of 0.1 m.
    rate
        Frames in that time.
    ground
        A plane below the lowest point, on which blocks come to lie.
    nudge
        Speed at the beginning, along a given first motion, by that at the end of such a free fall.
    """

    duration: float = 20.0
    rate: float = 12.0
    ground: bool = True
    nudge: float = 0.02

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_unless_positive("duration", "rate")
        self._refuse_below(0.0, "nudge")
        for name in ("duration", "rate", "nudge"):
            if not getattr(self, name) < float("inf"):
                raise InputError(f"{name} is {getattr(self, name)}", remedy="give a finite number")


@dataclass(frozen=True, eq=False)
class Film(Answer):
    """A simulated fall. It shows what may happen, and proves nothing.

    Attributes
    ----------
    model
    time : (s,) [s]
        Of the frames.
    positions : (s, n, 6) [m, rad]
        Translation of the centroid and rotation vector of every block from the beginning, world
        axes; rotation vectors go on beyond a half turn, so that frames can be interpolated.
    lies
        Whether everything has come to lie.
    engine
        What simulated it.
    stopped
        Why it ended early; empty where it did not.
    options, time_s
    """

    model: Model
    time: Floats
    positions: Floats
    lies: bool
    engine: str = ""
    stopped: str = ""
    options: FallOptions = field(default_factory=FallOptions)
    time_s: Mapping[str, float] = field(default_factory=dict)

    def _summary(self) -> str:
        return f"{counted(len(self.time), 'frame')}, '{self.message}'"

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.time)

    @property
    def fell(self) -> Bools:
        """(n,) blocks whose centroid is, or was, a tenth of their size from its place."""
        size = np.cbrt(self.assembly.volume)
        far = np.linalg.norm(self.positions[:, :, :3], axis=2).max(axis=0)
        return np.asarray(far > MOVED * size)

    @property
    def message(self) -> str:
        """One sentence for a person."""
        count = int(self.fell.sum())
        seconds = f"{self.time[-1]:.3g} s"
        if not count:
            return f"nothing fell in {seconds}"
        end = f"and {'lies' if count == 1 else 'lie'}" if self.lies else "and still moved then"
        why = f" ({self.stopped})" if self.stopped else ""
        return f"{counted(count, 'block')} fell in {seconds} {end}{why}"

    @property
    def title(self) -> str:
        """What fell."""
        return self.message[0].upper() + self.message[1:]

    def sentences(self) -> Sequence[Sentence]:
        """What fell, and that it proves nothing."""
        names = [self.assembly.names[i] for i in np.flatnonzero(self.fell)]
        said = [Sentence("FILM", Role.GOOD if self.lies else Role.UNSURE), Sentence(self.message)]
        if names:
            said.append(Sentence(f"fell: {named(names, 12)}"))
        return [*said, Sentence(f"simulated by {self.engine}; no verdict")]

    def tables(self) -> Sequence[Table]:
        """Where every block is at the end."""
        return [self.table()]

    def table(self) -> Table:
        """Where every block is at the end."""
        last = self.positions[-1]
        columns: dict[str, Any] = {"block": list(self.assembly.names), "fell": self.fell}
        columns |= {"move": last[:, :3], "turn": last[:, 3:]}
        return Table("blocks", columns, {"move": "m", "turn": "rad"})

    def numbers(self) -> Mapping[str, Any]:
        """How long it is, and what fell."""
        return {
            "message": self.message,
            "seconds": self.time[-1],
            "frames": len(self.time),
            "lies": self.lies,
            "fell": [self.assembly.names[i] for i in np.flatnonzero(self.fell)],
            "engine": self.engine,
            "stopped": self.stopped,
            "time_s": self.time_s,
        }

    def layers(self) -> Scene:
        """The film, in real time."""
        state = state_of(self.assembly)
        state[self.fell] = State.FALLING
        _, gravity = directions(self.assembly, self.model.load)
        message = "; ".join(["a simulated fall: no verdict", self.engine, *self.model.notes])
        stage = SceneStage(
            "film", self.title, message, state, motion=self.positions[-1], motion_name="Film",
            path=self.positions if len(self) > 1 else None, seconds=float(self.time[-1]),
            plays=True, up=-gravity, gravity=gravity,  # up across the ground on which they fall
        )  # fmt: skip
        return Scene(
            self.assembly, self.contacts, (stage,), f"drystone: {self.message}",
            self.asked.facts(), preset="solid",
        )  # fmt: skip

    def save_glb(self, path: PathLike) -> None:
        """Write the film as an animated GLB; see ``drystone.fall.film.write_film``."""
        from drystone.fall.film import write_film  # only for those who want one

        write_film(self.model, self.time, self.positions, path)
