"""Why a structure falls: regions, first motions, missing forces."""
