"""Our own JSON schema, with arrays in npz beside it."""
