"""Results to pictures: one self-contained page, static figures."""

from drystone.view.figure import save_figure
from drystone.view.inspection import inspection_scene, save_inspection
from drystone.view.notebook import Frame
from drystone.view.page import page_text, save_page
from drystone.view.palette import State
from drystone.view.polar import save_polar
from drystone.view.presets import PRESETS, Preset
from drystone.view.report import save_report
from drystone.view.scene import Layer, LayerKind, Scene, Shape, Stage
from drystone.view.staging import stage_of
from drystone.view.subject import scene_of

__all__ = [
    "PRESETS",
    "Frame",
    "Layer",
    "LayerKind",
    "Preset",
    "Scene",
    "Shape",
    "Stage",
    "State",
    "inspection_scene",
    "page_text",
    "save_figure",
    "save_inspection",
    "save_page",
    "save_polar",
    "save_report",
    "scene_of",
    "stage_of",
]
