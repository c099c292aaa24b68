"""The JSON schema of drystone, optionally with arrays in an npz file."""
