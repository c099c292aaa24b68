"""Scaffolding as things: struts, ropes, clamps and centring in the mechanics of a stage."""
