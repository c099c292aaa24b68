"""What falls, followed with inertia and impacts until it lies: a film, never a verdict.

MuJoCo simulates it. The simulator's constants have units, so the model is scaled first: blocks of 1
m on average, and loads that accelerate them by 9.81 m/s2 on average. Every block is its convex
pieces. All loads act as forces on the blocks, so that any load case can be followed.

What a simulated fall answers: where the blocks are, frame after frame.

An animated GLB has a node per block that moves, with the keys of its frames. Source of the format:
Khronos glTF 2.0 specification, section 3.11 (animations).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Unpack

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.answer import Answer, Role, Scene, SceneStage, Sentence, State
from drystone.answer.drawing import state_of
from drystone.answer.question import directions
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, frozen, frozen_floats
from drystone.base.display import named
from drystone.base.errors import InputError, counted, require
from drystone.base.files import PathLike, write_bytes
from drystone.base.settings import Clock, Options, checked_call
from drystone.base.table import Table
from drystone.io.draft import Contents
from drystone.io.glb import Z_UP, blocks_of
from drystone.io.mjcf import mjcf_text
from drystone.io.opening import Given, LongHow, as_model
from drystone.loads import LoadCase
from drystone.loads.case import STANDARD_GRAVITY
from drystone.model import Model

STEP = 0.002
"""[s] at the scale of the simulation; contacts have time constants of 0.01 s."""
_CONTACT = 0.01
"""[s], time constant of contacts: with 0.005 s large models were thrown apart."""
STILL, FOR = 0.03, 0.5
"""[m/s] and [s] at the scale of the simulation: slower for so long, everything lies. Before a
first motion has led to a fall, blocks may only be slow: a wedge in its groove needs 2 s."""
RATE = 12.0
"""Frames in the time in which a block of 1 m falls freely by half its size."""
_UNIT_TIME = 1.0 / np.sqrt(STANDARD_GRAVITY)
"""[s], in which a block of 1 m falls freely by half its size at 9.81 m/s2."""


@checked_call
def fall(
    given: Given,
    motion: Floats | None = None,
    *,
    options: FallOptions | None = None,
    **how: Unpack[LongHow],
) -> Film:
    """Follow what falls with inertia and impacts until it lies.

    A film of what may happen. It is no verdict: impacts depend on what nobody knows, and the
    contacts of the simulator are soft, so that what barely falls may stand in it. Each frame needs
    the one before, so an ``executor`` has nothing to share.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    motion : (n, 6), optional
        A first motion along which the blocks have a small speed at the beginning, such as
        ``result.mechanism``; its size does not matter.
    options

    Raises
    ------
    MissingDependency
        MuJoCo is not installed.
    InputError
        What was given cannot be made into a model, or the motion has another shape.

    Examples
    --------
    >>> from drystone.models import tower
    >>> film = fall(tower(2), load=(1.0, 0.0, -0.5), friction=0.2)  # doctest: +SKIP
    >>> bool(film.fell[1]), film.lies  # doctest: +SKIP
    (True, True)
    """
    chosen = FallOptions.of(options)
    clock = Clock.of(how)
    model = as_model(given, **how)
    model.require_still()
    if motion is not None:
        motion = frozen_floats(motion, (len(model), 6), "the first motion")
    mujoco = require_mujoco()
    free = model.assembly.free
    force = model.load.wrench[free]
    total = float(np.linalg.norm(force[:, :3], axis=1).sum())
    if not len(free) or total == 0.0:
        still = np.zeros((1, len(model), 6))
        return Film(model, frozen(np.zeros(1)), frozen(still), True, options=chosen)
    length = float(np.cbrt(model.assembly.volume[free]).mean())
    pull = total / float(model.assembly.mass[free].sum())
    second = np.sqrt(length * STANDARD_GRAVITY / pull)
    scaled = _scaled(model, length)
    spec = mujoco.MjSpec.from_string(mjcf_text(scaled, contact_s=_CONTACT))
    spec.option.timestep = STEP
    spec.option.gravity = np.zeros(3)
    if chosen.ground:
        _add_ground(mujoco, spec, scaled, force[:, :3].sum(axis=0))
    simulator = spec.compile()
    data = mujoco.MjData(simulator)
    # bodies are in the order of the blocks, after the world
    push = model.load.wrench * (scaled.assembly.mass / model.assembly.mass)[:, None]
    push *= STANDARD_GRAVITY / pull
    push[:, 3:] /= length
    data.xfrc_applied[1:] = np.where(model.assembly.fixed[:, None], 0.0, push)
    if motion is not None:
        _give_speed(simulator, data, motion, model.assembly, length, chosen.nudge)
    every = max(round(_UNIT_TIME / RATE / STEP), 1)
    last = int(np.ceil(chosen.duration * RATE))
    quiet, lies, fallen = 0.0, False, motion is None or not np.any(motion[free])
    size = np.cbrt(scaled.assembly.volume)
    mujoco.mj_forward(simulator, data)
    frames = [_pose(data)]
    for number in range(1, last + 1):
        mujoco.mj_step(simulator, data, every)
        frames.append(_pose(data))
        if not np.isfinite(frames[-1][0]).all():
            raise InputError(
                "the blocks flew apart in the simulation",
                remedy="look for blocks that overlap: inspect",
            )
        quiet = quiet + every * STEP if np.abs(data.qvel).max() < STILL else 0.0
        # what is known to fall is waited for: it may begin slowly
        fallen = fallen or _has_fallen(frames, size)
        clock.tell("simulating", number, last)
        if quiet >= FOR and fallen:
            lies = True
            break
        if clock.late():
            break
    lies = lies or quiet >= FOR
    time = np.arange(len(frames)) * every * STEP * second
    return Film(
        model,
        frozen(time),
        frozen(_positions(frames, length)),
        lies,
        f"MuJoCo {mujoco.__version__}",
        chosen,
        time_s={"solve": clock.elapsed_s},
        stopped=clock.reason,
    )


def require_mujoco() -> Any:
    """The package that simulates.

    Raises
    ------
    MissingDependency
    """
    require("mujoco", "fall", "a simulated fall")
    import mujoco  # only for those who want a film

    return mujoco


def _scaled(model: Model, length: float) -> Model:
    """Blocks of 1 m on average about the origin, with plain gravity."""
    assembly = model.assembly
    origin = assembly.centroid.mean(axis=0)
    blocks = tuple(
        block.transformed(np.eye(3) / length, -origin / length) for block in assembly.blocks
    )
    made = Assembly(blocks, assembly.fixed)
    return Model(made, model.contacts, LoadCase.gravity(made))


def _add_ground(mujoco: Any, spec: Any, scaled: Model, force: Floats) -> None:
    """A plane below the lowest point, square to the whole load."""
    size = float(np.linalg.norm(force))
    up = np.array([0.0, 0.0, 1.0]) if size == 0.0 else -force / size
    points = np.concatenate([block.vertices for block in scaled.assembly.blocks])
    lowest = points[int(np.argmin(points @ up))]
    turn, _ = Rotation.align_vectors(up[None], np.array([[0.0, 0.0, 1.0]]))
    x, y, z, w = turn.as_quat()
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 1.0],
        pos=lowest.tolist(),
        quat=[w, x, y, z],
        condim=3,
    )


def _give_speed(
    simulator: Any, data: Any, motion: Floats, assembly: Assembly, length: float, nudge: float
) -> None:
    """The blocks move along a motion at a small speed."""
    scaled = np.concatenate([motion[:, :3] / length, motion[:, 3:]], axis=1)
    scaled[assembly.fixed] = 0.0
    largest = float(np.abs(scaled).max(initial=0.0))
    if largest == 0.0:
        return
    speed = scaled * (nudge * STANDARD_GRAVITY * _UNIT_TIME / largest)
    for number in assembly.free.tolist():
        at = int(simulator.jnt_dofadr[simulator.body_jntadr[number + 1]])
        data.qvel[at : at + 6] = speed[number]


def _has_fallen(frames: list[tuple[Floats, Floats]], size: Floats) -> bool:
    """Whether a block has moved by a tenth of its size (n,) since the first frame."""
    gone = np.linalg.norm(frames[-1][0] - frames[0][0], axis=1)
    return bool((gone > MOVED * size).any())


def _pose(data: Any) -> tuple[Floats, Floats]:
    """Places (n, 3) and quaternions (n, 4), scalar first, of all blocks."""
    return np.array(data.xpos[1:]), np.array(data.xquat[1:])


def _positions(frames: list[tuple[Floats, Floats]], length: float) -> Floats:
    """(s, n, 6) [m, rad] from the first frame, with rotation vectors that do not jump."""
    place = np.stack([one[0] for one in frames])
    quaternion = np.stack([one[1] for one in frames])[..., [1, 2, 3, 0]]
    count = place.shape[:2]
    vector = Rotation.from_quat(quaternion.reshape(-1, 4)).as_rotvec().reshape(*count, 3)
    for number in range(1, len(vector)):
        vector[number] = _nearest(vector[number], vector[number - 1])
    gone = (place - place[0]) * length
    return np.concatenate([gone, vector], axis=2)


def _nearest(vector: Floats, before: Floats) -> Floats:
    """Rotation vectors (n, 3) of the same rotations, as near as can be to those before."""
    angle = np.linalg.norm(vector, axis=1)
    # without a rotation any axis will do: that of the frame before
    last = np.linalg.norm(before, axis=1)
    axis = np.where((angle > 1e-9)[:, None], vector, before)
    size = np.where(angle > 1e-9, angle, last)
    axis = axis / np.where(size > 0.0, size, 1.0)[:, None]
    turns = np.round(((before * axis).sum(axis=1) - angle) / (2.0 * np.pi))
    return axis * (angle + 2.0 * np.pi * turns)[:, None]


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
    parts = blocks_of(Contents(model.assembly))
    centroid = model.assembly.centroid @ Z_UP
    nodes = parts.top["nodes"]
    channels = []
    when = parts.numbers(time, bounds=True)
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
        channels.append((i, "translation", when, place, "LINEAR"))
        channels.append((i, "rotation", when, turn, "LINEAR"))
    parts.play("film", channels)
    write_bytes(path, parts.file({"nodes": [*range(len(model.assembly))]}))


MOVED = 0.1
"""Travel of a block, by its size, from which on it has fallen. The contacts of the simulator
are soft: what stands moves by a hundredth at most (docs/reference/robots.md)."""


@dataclass(frozen=True)
class FallOptions(Options):
    """Options of :func:`fall`.

    Attributes
    ----------
    duration : > 0, < inf
        Largest length of the film, by the time in which a block falls freely by half its size:
        0.32 s for blocks of 1 m, 0.1 s for blocks of 0.1 m.
    ground
        A plane below the lowest point, on which blocks come to lie.
    nudge : >= 0, < inf
        Speed at the beginning, along a given first motion, by that at the end of such a free fall.
    """

    duration: float = 20.0
    ground: bool = True
    nudge: float = 0.02


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
    options
    """

    model: Model
    time: Floats
    positions: Floats
    lies: bool
    engine: str = ""
    options: FallOptions = field(default_factory=FallOptions)

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
        last = self.positions[-1]
        columns: dict[str, Any] = {"block": list(self.assembly.names), "fell": self.fell}
        columns |= {"move": last[:, :3], "turn": last[:, 3:]}
        return [Table("blocks", columns, {"move": "m", "turn": "rad"})]

    def numbers(self) -> Mapping[str, Any]:
        """How long it is, and what fell."""
        return {
            "message": self.message,
            "seconds": self.time[-1],
            "frames": len(self.time),
            "lies": self.lies,
            "fell": [self.assembly.names[i] for i in np.flatnonzero(self.fell)],
            "engine": self.engine,
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
        """Write the film as an animated GLB; see ``write_film``."""
        write_film(self.model, self.time, self.positions, path)


__all__ = ["FallOptions", "Film", "fall"]
