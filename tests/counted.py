"""Whole numbers that count the operations done with them."""


class Counted(int):
    """A whole number; each operation and comparison adds one to `Counted.operations`."""

    operations = 0


def _counting(name):
    plain = getattr(int, name)

    def operation(self, other):
        Counted.operations += 1
        result = plain(self, other)
        return result if isinstance(result, bool) else Counted(result)

    return operation


for _name in ("add", "sub", "and", "or", "xor", "lshift", "rshift", "eq", "lt", "gt", "ge"):
    setattr(Counted, f"__{_name}__", _counting(f"__{_name}__"))
