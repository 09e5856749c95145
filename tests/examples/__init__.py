"""A valid call of every public name, a module a room: where fuzzing starts from.

`INSTANCES` has an object of each class that arguments or methods ask for, `CALLS` the arguments
that a rule's usual example doesn't suit, by the name within the room. What takes time to make is
a function without arguments there: every worker of the tests imports this, few use it.
"""
