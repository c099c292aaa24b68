"""Why a structure falls: regions, first motions, what is missing."""
