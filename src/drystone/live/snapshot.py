"""An answer as the data of one picture of the live page."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.answer.question import Question
from drystone.answer.scene import stage_among
from drystone.base.arrays import marked
from drystone.contacts import Contacts, joined_contacts
from drystone.geometry.frames import rotation_about
from drystone.live.wish import Wish, WishedModel
from drystone.loads import DOWN
from drystone.results import Result, Verdict
from drystone.view import Scene, SceneStage
from drystone.view.encode import encode_stage

QUICK = {
    Verdict.STABLE: "Stands with uniform stiffness of the joints; others are being tried",
    Verdict.UNDECIDED: "Not at rest with uniform stiffness of the joints; it is being checked",
}
"""Headlines while the whole verdict is not known."""


@dataclass(frozen=True, eq=False)
class Found:
    """An answer and its picture, of the blocks that are in place.

    Attributes
    ----------
    result
    stage
    moved
        Whether the forces of the stage are those at the end of its motion.
    """

    result: Result
    stage: SceneStage
    moved: bool = False

    @classmethod
    def at_rest(cls, result: Result, *, quick: bool = False) -> Found:
        """The picture of a result; ``quick`` where the whole verdict is still to come."""
        stage = result.stage("live")
        if quick:
            stage = replace(stage, headline=QUICK[result.verdict], role=None)
        return cls(result, stage)


def snapshot(asked: WishedModel, wish: Wish, found: Found) -> dict[str, Any]:
    """An answer about ``asked.part``, encoded for the page that shows all blocks of ``asked``.

    Parameters
    ----------
    asked
    wish
    found
    """
    stage, contacts = widened(found, asked)
    turn = rotation_about(asked.axis, wish.tilt)
    part = asked.part
    facts = Question.of(part).facts()
    stage = replace(stage, up=turn[2], gravity=np.array(DOWN) @ turn, facts=facts)
    more = contacts.count > asked.whole.contacts.count
    encoded = encode_stage(Scene(asked.whole.assembly, contacts, (stage,)), contacts=more)
    encoded["stage"]["moved"] = found.moved
    return encoded


def widened(found: Found, asked: WishedModel) -> tuple[SceneStage, Contacts]:
    """A stage of the blocks in place as one of all blocks, and their contacts.

    Blocks taken out are absent. Edges and corners that touch as well come after the contacts of
    the model.
    """
    blocks, contacts = len(asked.whole), asked.whole.contacts
    here = marked(asked.kept, blocks)
    interface = np.flatnonzero(here[contacts.block_a] & here[contacts.block_b])
    own = found.result.model.contacts
    more = own.select(np.arange(own.count) >= len(interface), asked.kept)
    interface = np.append(interface, contacts.count + np.arange(more.count))
    contacts = joined_contacts(contacts, more)
    return stage_among(found.stage, blocks, contacts, asked.kept, interface), contacts
