"""Commands for analysis: verdict, limits, settlement, fall."""
