"""What every answer says of itself, what was asked, and the data of its picture."""

from drystone.answer.answer import Answer, Statement, plain, worst_first
from drystone.answer.question import Question
from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.answer.sentences import Role, Sentence, Verdict
from drystone.base.settings import hold

__all__ = [
    "Answer",
    "Layer",
    "LayerKind",
    "MarkerShape",
    "Question",
    "Role",
    "Scene",
    "SceneStage",
    "Sentence",
    "State",
    "Statement",
    "Verdict",
    "plain",
    "worst_first",
]

hold(globals())
