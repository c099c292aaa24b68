"""The diagnosis of a structure that falls: its regions, as text and as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.answer import Answer, Layer, LayerKind, Role, Scene, Sentence
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.design import words
from drystone.design.joint_motion import JointState
from drystone.design.needs import Needs
from drystone.model import Model
from drystone.results import Result, Verdict


@dataclass(frozen=True, eq=False)
class Region(OneLine):
    """Connected blocks that fall or need help.

    Attributes
    ----------
    blocks
        Positions of the blocks in the model.
    neighbours
        Positions of the blocks that touch them, which are fixed in the local model.
    local
        The model of the region alone: first its blocks (free), then its neighbours (fixed).
    verdict
        Of the local model.
    joints
        First motion of each block at each of its interfaces.
    needs
        What would hold it.
    sentence
        What happens, and what to do.
    """

    blocks: tuple[int, ...]
    neighbours: tuple[int, ...]
    local: Model
    verdict: Verdict
    joints: tuple[JointState, ...]
    needs: Needs
    sentence: str

    def _summary(self) -> str:
        return f"{counted(len(self.blocks), 'block')}, '{self.sentence}'"


@dataclass(frozen=True, eq=False)
class Diagnosis(Answer):
    """Where a model falls, why, and which forces are missing.

    Attributes
    ----------
    result
        Result of the check, or of the penalty form if the check is undecided.
    regions
        The heaviest first; empty where it stands.
    motion : (n, 6) [m, rad]
        First motion of the blocks; the fastest one moves by about its size.
    friction
        Coefficient of all joints with which the whole model stands; ``None`` if it stands already
        or none was found.
    others
        Blocks of regions that were not examined.
    stopped
        Why the needs of some regions are missing; else empty.
    """

    result: Result
    regions: tuple[Region, ...]
    motion: Floats
    friction: float | None = None
    others: tuple[int, ...] = ()
    stopped: str = ""

    def _summary(self) -> str:
        told = counted(len(self.regions), "region")
        return f"{self.result.verdict.value}, {told}, '{'; '.join(self.reasons)}'"

    @property
    def model(self) -> Model:
        """The diagnosed model."""
        return self.result.model

    @property
    def reasons(self) -> tuple[str, ...]:
        """A sentence for each region, or one if the model stands."""
        if not self.regions:
            return (words.nothing(self.result),)
        said = [region.sentence for region in self.regions]
        if self.others:
            more = counted(len(self.others), "more block falls", "more blocks fall")
            said.append(f"{more}: {words.names_of(self.model, self.others)}")
        if self.friction is not None:
            regions = [region.needs.friction for region in self.regions]
            said.append(words.friction_of_all(self.friction, regions))
        return tuple(said)

    @property
    def props(self) -> tuple[Floats, Floats]:
        """Points (p, 3) [m] and forces (p, 3) [N] of the props that hold the regions."""
        return _arrows(
            [(one.point, one.force) for r in self.regions for one in r.needs.props.props]
        )

    @property
    def missing(self) -> tuple[Floats, Floats]:
        """The same of the missing force of each region that no props were found to hold."""
        bare = [region.needs for region in self.regions if not region.needs.props.props]
        return _arrows([(needs.point, needs.force) for needs in bare])

    @property
    def title(self) -> str:
        """The verdict as a plain sentence."""
        return self.result.title

    def sentences(self) -> Sequence[Sentence]:
        """The verdict, and why the heaviest regions fall."""
        verdict, *_ = self.result.sentences()
        told, regions = list(self.reasons), len(self.regions)
        if regions > 5:
            told[5:regions] = [f"and {regions - 5} more regions like these (--json lists all)"]
        said = [verdict, Sentence(self.result.message), *map(Sentence, told)]
        if self.stopped:
            said.append(Sentence(f"{self.stopped} before all was tried", Role.REMARK))
        return [one for one in said if one.text]

    def layers(self) -> Scene:
        """The model with its first motion and the forces that would hold it."""
        stage = self.result.stage("diagnosis")
        needed = [
            Layer(
                key, label, LayerKind.ARROWS, "help", point, force, single=True, width=2.0,
                group="help",
            )
            for key, label, (point, force) in (
                ("help", "props that would hold it", self.props),
                ("missing", "forces that are missing", self.missing),
            )
            if len(point)
        ]  # fmt: skip
        shown = [layer for layer in stage.layers if layer.kind is not LayerKind.ARROWS]
        stage = replace(
            stage,
            message="; ".join(self.reasons),
            motion=self.motion if self.regions else None,
            prop=None,
            layers=(*shown, *needed),
        )
        return replace(self.result.layers(), stages=(stage,))

    def numbers(self) -> Mapping[str, Any]:
        """Of each region: its joints, and what would hold it."""
        return {
            "verdict": self.result.verdict,
            "message": self.result.message,
            "friction_of_all": self.friction,
            "others": [self.model.assembly.names[i] for i in self.others],
            "stopped": self.stopped,
            "regions": [_plain_region(self.model, region) for region in self.regions],
        }


def _arrows(pairs: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    point, force = ([one[k] for one in pairs] for k in (0, 1))
    return np.array(point).reshape(-1, 3), np.array(force).reshape(-1, 3)


def _plain_region(model: Model, region: Region) -> dict[str, Any]:
    names, contacts, needs = model.assembly.names, model.contacts, region.needs

    def joint(k: int) -> dict[str, Any]:
        return {"interface": k, "blocks": [names[contacts.block_a[k]], names[contacts.block_b[k]]]}

    ballast, turn, blocks = needs.ballast, needs.turn, [names[i] for i in region.blocks]
    return {
        "blocks": blocks,
        "neighbours": [names[i] for i in region.neighbours],
        "verdict": region.verdict,
        "sentence": region.sentence,
        "joints": [
            {
                **vars(one),
                "block": names[one.block],
                "neighbour": names[one.neighbour],
                "motion": one.motion.name.lower(),
            }
            for one in region.joints
        ],
        "needs": {
            "prop": {"force": needs.force, "point": needs.point},
            "wrench": dict(zip(blocks, needs.wrench, strict=True)),
            "supports": [
                {"block": names[one.block], "force": one.force, "point": one.point}
                for one in needs.props.props
            ],
            "friction": needs.friction,
            "ballast": ballast and {"block": names[ballast.at[0]], "force": ballast.value},
            "turn": turn and {**joint(turn.at[0]), "degrees": turn.value, "jams": turn.jams},
            "glue": [
                {"joints": [joint(k) for k in glue.at], "strength": glue.value}
                for glue in needs.glue
            ],
            "tension": [{**vars(one), **joint(one.interface)} for one in needs.pulls],
        },
    }
