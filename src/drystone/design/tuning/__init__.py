"""Parameters by search: the values with which a family of structures is best and stands."""
