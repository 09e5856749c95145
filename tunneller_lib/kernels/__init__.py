"""How one formula runs on single numbers, on arrays and compiled, with the same bits each time."""
