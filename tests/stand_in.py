"""Results with made-up numbers, for tests of what is done with them."""


def stand_in(kind, **values):
    """An object of a class that has these values, whatever the class computes."""
    return object.__new__(type(kind.__name__, (kind,), values))
