"""The one kind of error that is meant for the user rather than for a developer."""

INTERRUPTED = "interrupted; run the same command again"
"""What a command says that Ctrl-C ended."""


def printable(text: str) -> str:
    """Return a text with control characters as escapes, so that a terminal shows them and does not act on them."""
    if text.isprintable():
        return text
    shown = (letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text)
    return "".join(shown)


class UserError(Exception):
    """An error that the user can correct: one line that names the file, key or cell, the fault and the remedy.

    The command line prints it as ``error: <line>`` and exits with status 1, without a traceback. Texts from outside
    may be put into the line as they are: their control characters are shown as escapes.
    """

    def __init__(self, message: str) -> None:
        super().__init__(printable(" ".join(message.split())))
