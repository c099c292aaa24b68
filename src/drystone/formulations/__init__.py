"""Numerical problems from blocks and contacts, and the conversion of their solutions."""
