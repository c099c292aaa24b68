"""COMPAS JSON without COMPAS."""
