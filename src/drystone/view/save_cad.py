"""Answers as files for CAD programs."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from drystone.base.errors import FormatError, InputError
from drystone.contacts import Contacts
from drystone.view.cad_pictures import write_3dm, write_glb
from drystone.view.palette import PRESETS, first_preset
from drystone.view.subjects import Subject, scene_of

_WRITERS = {".3dm": write_3dm, ".glb": write_glb}


def save_cad(
    subject: Subject,
    path: str | PathLike[str],
    contacts: Contacts | None = None,
    *,
    stage: int | None = None,
    preset: str | None = None,
) -> None:
    """Write an answer for a CAD program, as Rhino 3dm or GLB; lengths are in metres.

    Blocks keep their names. Their layer or material says what they are: support, free, falling, in
    need of help. Joints are coloured by the force at each corner. What is drawn is marked, so that
    reading the file again finds the blocks alone.

    Parameters
    ----------
    subject
        A result, a model, an assembly, a limit, a plan, a settlement, or a scene put together by
        hand.
    path
        ``.3dm``: layers for blocks, joints, forces and the motion, with forces as user text; needs
        rhino3dm (extra ``cad``). ``.glb``: materials, and the motion of a fall or the order of a
        plan as an animation.
    contacts
        Of an assembly; a result has its own.
    stage
        Its number, where there are several; the one that a figure shows when left out.
    preset
        Which layers are shown; the one that suits the answer when left out.

    Raises
    ------
    FormatError
        Another suffix, a name that the format has no place for, or the file cannot be written.
    InputError
        There is no such picture or stage.
    MissingDependency
        rhino3dm is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.models import tower
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> save_cad(tower(3), folder / "tower.glb")
    >>> (folder / "tower.glb").read_bytes()[:4]
    b'glTF'
    """
    target = Path(path)
    writer = _WRITERS.get(target.suffix.lower())
    if writer is None:
        raise FormatError(
            f"an answer cannot be written as '{target.suffix}'",
            where=str(path),
            remedy="end the name in .3dm or .glb",
        )
    scene = scene_of(subject, contacts)
    if stage is not None and not -len(scene.stages) <= stage < len(scene.stages):
        raise InputError(f"there is no stage {stage}", remedy=f"there are {len(scene.stages)}")
    chosen = first_preset(scene) if preset is None else preset
    if chosen not in PRESETS:
        raise InputError(f"there is no picture '{chosen}'", remedy=f"choose {', '.join(PRESETS)}")
    writer(scene, target, stage, chosen)
