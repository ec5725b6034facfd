"""The check of a method before the first job: how it is shown, its interface, and a short trial life."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import msgspec
import numpy as np

from ptl import methods
from ptl.config import TITLE, Parameters
from ptl.errors import UserError
from ptl.keys import allowed, key
from ptl.learning.life import Life, learn_life, tasks_of
from ptl.world.gridworld import GridWorld

Label = Annotated[str, key("", **{**TITLE, "min_length": 1})]
Colour = Annotated[str, key("", pattern=r"^#[0-9a-f]{6}\Z", wanted="#rrggbb with lower-case digits")]

TRIAL_WORLD = GridWorld.from_text("I...\n.#.A\n...B\n", "trial")
TRIAL_SECONDS = 60
TRIAL_PARAMETERS = Parameters().replace(learning__episodes=5, learning__max_steps=10**5, subgoals__trajectories=3)


def check_method(method: str | methods.Maker) -> None:
    """Refuse a method that cannot be shown in tables and figures or that fails in a life of two small tasks.

    Raises
    ------
    UserError
        One line that names the method and the fault.
    """
    methods.identifier(method)
    kind = methods.load(method) if isinstance(method, str) else method
    for name, wanted in (("label", Label), ("colour", Colour)):
        value = getattr(kind, name, None)
        try:
            msgspec.convert(value, wanted)
        except msgspec.ValidationError:
            raise UserError(
                f"method {methods.shown(method)}: {name} = {value!r} is not allowed; give {allowed(wanted)}"
            ) from None
    if _numbers(_trial(method)) != _numbers(_trial(method)):
        raise UserError(
            f"method {methods.shown(method)}: two lives with equal seeds differ; draw random numbers from self.random"
        )


def _trial(method: str | methods.Maker) -> Life:
    with methods.reporting_errors_of(method), _limited(method):
        return learn_life(TRIAL_WORLD, tasks_of(TRIAL_WORLD, "AB"), method, TRIAL_PARAMETERS, 0, "trial")


@contextmanager
def _limited(method: str | methods.Maker) -> Iterator[None]:
    """End a trial that takes too long, if this is the main thread, which alone can be interrupted."""

    def end(*_: object) -> None:
        raise UserError(
            f"method {methods.shown(method)}: a life of two tasks on a map of {TRIAL_WORLD.n_states} states has not"
            f" ended after {TRIAL_SECONDS} s; let every episode end"
        )

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, TRIAL_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _numbers(life: Life) -> bytes:
    return b"".join(np.concatenate([record.steps, record.q.ravel()]).tobytes() for record in life.records)
