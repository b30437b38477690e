"""What goes wrong, reported in one line."""


class InputError(ValueError):
    """Something the user wrote is wrong; its one line says where, which value, and what would do."""

    def __init__(self, where: object, field: str, value: object, expected: str):
        super().__init__(where, field, value, expected)
        self.where, self.field, self.value, self.expected = where, field, value, expected

    def __str__(self) -> str:
        return f"{self.where}: {self.field} = {self.value!r}: {self.expected}"

    def inside(self, place: object) -> "InputError":
        """The same mistake, seen from the file or option that holds it."""
        return InputError(f"{place}: {self.where}", self.field, self.value, self.expected)


class SimulationDivergedError(RuntimeError):
    """The simulation left the finite numbers; the message names the time, the state and the likely cause."""


class WorkerDiedError(RuntimeError):
    """The process that made a call died each time; the message names the call."""
