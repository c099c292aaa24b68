"""Pictures of results: self-contained pages, static figures, CAD files."""

from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.base.settings import hold
from drystone.view.figure import save_figure
from drystone.view.gif import save_film
from drystone.view.notebook import Frame, interact, show
from drystone.view.page import page_text, save_page
from drystone.view.palette import PRESETS, Preset
from drystone.view.plots import save_chart
from drystone.view.save_cad import save_cad
from drystone.view.subjects import scene_of

__all__ = [
    "PRESETS",
    "Frame",
    "Layer",
    "LayerKind",
    "MarkerShape",
    "Preset",
    "Scene",
    "SceneStage",
    "State",
    "interact",
    "page_text",
    "save_cad",
    "save_chart",
    "save_figure",
    "save_film",
    "save_page",
    "scene_of",
    "show",
]

hold(globals())
