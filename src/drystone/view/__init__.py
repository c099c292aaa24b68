"""Pictures of results: self-contained pages, static figures, CAD files."""

from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.view.cad.save_cad import save_cad
from drystone.view.paper.figure import save_figure
from drystone.view.paper.plots import save_chart, save_gravity
from drystone.view.paper.report import save_report
from drystone.view.style.presets import PRESETS, Preset
from drystone.view.subjects import scene_of
from drystone.view.web.notebook import Frame, show
from drystone.view.web.page import page_text, save_page
from drystone.view.web.widget import interact

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
    "save_gravity",
    "save_page",
    "save_report",
    "scene_of",
    "show",
]
