"""What every answer says of itself, what was asked, and the data of its picture."""

from drystone.answer.answer import Answer, plain
from drystone.answer.asked import Asked
from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.answer.sentences import Role, Sentence, Verdict

__all__ = [
    "Answer",
    "Asked",
    "Layer",
    "LayerKind",
    "MarkerShape",
    "Role",
    "Scene",
    "SceneStage",
    "Sentence",
    "State",
    "Verdict",
    "plain",
]
