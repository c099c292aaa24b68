"""A fall simulated by MuJoCo, with inertia, friction and impacts.

The simulator's constants have units, so the model is scaled first: blocks of 1 m on average, and
loads that accelerate them by 9.81 m/s2 on average. Every block is its convex pieces. All loads act
as forces on the blocks, so that any load case can be followed.
"""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, frozen, frozen_floats
from drystone.base.errors import InputError, require
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.fall.film import MOVED, FallOptions, Film
from drystone.io.mjcf import mjcf_text
from drystone.io.opening import Given, How, as_model
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
_UNIT_TIME = 1.0 / np.sqrt(STANDARD_GRAVITY)
"""[s], in which a block of 1 m falls freely by half its size at 9.81 m/s2."""


@checked_call
def fall(
    given: Given,
    motion: Floats | None = None,
    *,
    options: FallOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
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
    del executor  # one chain of frames
    chosen = FallOptions.of(options)
    model = as_model(given, **how)
    model.require_still()
    if motion is not None:
        motion = frozen_floats(motion, (len(model), 6), "the first motion")
    mujoco = require_mujoco()
    clock = Clock(time_limit_s, stop)
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
    every = max(round(_UNIT_TIME / chosen.rate / STEP), 1)
    last = int(np.ceil(chosen.duration * chosen.rate))
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
        if progress is not None:
            progress("simulating", number, last)
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
        clock.reason,
        chosen,
        {"solve": clock.elapsed_s},
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
    nearest: Floats = axis * (angle + 2.0 * np.pi * turns)[:, None]
    return nearest
