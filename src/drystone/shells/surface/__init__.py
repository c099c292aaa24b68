"""A shell's middle surface: patches, their sources, and form finding."""
