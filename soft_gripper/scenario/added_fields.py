"""Fields that extras add to the classes of the schema, and what they add beside these; see docs/howto/own_extra.md.

The module `adds` of an extra declares them, as classes by the names of those that they are added to:

    @dataclass
    class Fruit:
        sugar: float = quantity(0.1, least=0, most=1)

    FIELDS = {"MeshConfig": Fruit}

Then `mesh.sugar` is a field of every scenario, with a rule of its own, and `cast(Fruit, model.mesh).sugar` its value.
"""

from copy import copy
from dataclasses import fields
from typing import TypeVar

from soft_gripper.extras import added

_T = TypeVar("_T", bound=type)


def with_added_fields(of: _T) -> _T:
    """A class of the schema, before it becomes a dataclass, with the fields that extras add to it."""
    for declared in added("FIELDS"):
        for each in fields(declared[of.__name__]) if of.__name__ in declared else ():
            of.__annotations__[each.name] = each.type
            setattr(of, each.name, copy(each))
    return of
