"""The benchmark of the field: models with known answers, and programs that are asked about them."""

from pathlib import Path

MODELS = Path(__file__).parent / "models"
"""Folder of the models, a JSON file each."""

__all__ = ["MODELS"]
