"""What every answer says of itself, what was asked, and the data of its picture."""

from drystone.answer.answer import Answer as Answer
from drystone.answer.answer import Statement as Statement
from drystone.answer.answer import plain as plain
from drystone.answer.answer import worst_first as worst_first
from drystone.answer.question import Question as Question
from drystone.answer.scene import Layer as Layer
from drystone.answer.scene import LayerKind as LayerKind
from drystone.answer.scene import MarkerShape as MarkerShape
from drystone.answer.scene import Scene as Scene
from drystone.answer.scene import SceneStage as SceneStage
from drystone.answer.scene import State as State
from drystone.answer.sentences import Role as Role
from drystone.answer.sentences import Sentence as Sentence
from drystone.answer.sentences import Verdict as Verdict
from drystone.base.settings import hold

__all__ = hold(globals())
