"""Pictures of results: self-contained pages, static figures, CAD files."""

from drystone.answer.scene import Layer as Layer
from drystone.answer.scene import LayerKind as LayerKind
from drystone.answer.scene import MarkerShape as MarkerShape
from drystone.answer.scene import Scene as Scene
from drystone.answer.scene import SceneStage as SceneStage
from drystone.answer.scene import State as State
from drystone.base.settings import hold
from drystone.view.cad_pictures import save_cad as save_cad
from drystone.view.figure import save_figure as save_figure
from drystone.view.gif import save_film as save_film
from drystone.view.notebook import Frame as Frame
from drystone.view.notebook import interact as interact
from drystone.view.notebook import show as show
from drystone.view.page import page_text as page_text
from drystone.view.page import save_page as save_page
from drystone.view.palette import PRESETS as PRESETS
from drystone.view.palette import Preset as Preset
from drystone.view.plots import save_chart as save_chart
from drystone.view.subjects import scene_of as scene_of

__all__ = hold(globals())
