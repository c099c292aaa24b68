"""A scene that is cut by a plane, or taken apart."""
