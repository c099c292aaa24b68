"""Commands about model files and built-in models."""
