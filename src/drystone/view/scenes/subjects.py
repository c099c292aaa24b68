"""The scene of every value that has a picture."""

from __future__ import annotations

from typing import TypeAlias

from drystone.assembly import Assembly
from drystone.base.display import shortened
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.design.diagnosed import Diagnosis
from drystone.fall import Film
from drystone.limits import Limit, TiltSweep
from drystone.model import Model
from drystone.results import Result
from drystone.sequence import Plan, Scaffolding
from drystone.settlement import LargeDisplacement, Settlement, SupportResponse
from drystone.view.scenes.large_scenes import film_scene, large_scene
from drystone.view.scenes.limit_scenes import limit_scene, sweep_scene
from drystone.view.scenes.mend_scenes import diagnosis_scene
from drystone.view.scenes.plan_scenes import plan_scene
from drystone.view.scenes.scaffold_scenes import scaffold_scene
from drystone.view.scenes.scene import Scene
from drystone.view.scenes.settlement_scenes import followed_scene, settlement_scene
from drystone.view.scenes.staging import bare_scene, result_scene

Subject: TypeAlias = (
    Result
    | Model
    | Assembly
    | Limit
    | TiltSweep
    | Plan
    | Scaffolding
    | SupportResponse
    | Settlement
    | LargeDisplacement
    | Film
    | Diagnosis
    | Scene
)


def scene_of(subject: Subject, contacts: Contacts | None = None, source: str = "") -> Scene:
    """The scene of a model or of an answer, or the scene itself.

    Parameters
    ----------
    subject
    contacts
        Of an assembly; everything else has its own.
    source
        The file that the model came from, for the head of the picture.

    Raises
    ------
    InputError
        Contacts were given that are not those of the result, or that name other blocks; or there
        is no picture of such a value.
    """
    if isinstance(subject, Assembly):
        return bare_scene(subject, contacts, source=source)
    own = getattr(subject, "contacts", None)
    if contacts is not None and contacts is not own:
        raise InputError(
            "contacts other than those of the result", remedy="leave them out: a result has its own"
        )
    match subject:
        case Scene():
            return subject
        case Result():
            return result_scene(subject, source)
        case Model():
            return bare_scene(subject.assembly, subject.contacts, subject, source)
        case Limit():
            return limit_scene(subject, source)
        case TiltSweep():
            return sweep_scene(subject, source)
        case Plan():
            return plan_scene(subject, source)
        case Scaffolding():
            return scaffold_scene(subject, source)
        case SupportResponse():
            return settlement_scene(subject, source)
        case LargeDisplacement():
            return large_scene(subject, source)
        case Film():
            return film_scene(subject, source)
        case Diagnosis():
            return diagnosis_scene(subject, source)
        case Settlement():
            return followed_scene(subject, source)
        case _:
            raise InputError(
                f"there is no picture of {shortened(repr(subject), 60)}",
                remedy="give a model, an assembly, a result, a limit, a plan or a settlement",
            )
