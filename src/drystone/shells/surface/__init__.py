"""The middle surface of a shell: patches, their sources, form finding."""
