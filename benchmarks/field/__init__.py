"""The benchmark of the field: models with known answers, and programs that are asked about them."""
