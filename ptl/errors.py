"""The one kind of error that is meant for the user rather than for a developer."""


class UserError(Exception):
    """Something the user can mend: one line that names the file, key or cell, the fault and the remedy.

    The command line prints it as ``error: <line>`` and exits with status 1, without a traceback.
    """

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))
