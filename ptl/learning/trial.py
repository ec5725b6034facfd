"""The check of a method before the first job: how it is shown, its interface, and a short trial life."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Annotated

import msgspec
import numpy as np

from ptl import methods
from ptl.agent import seeding
from ptl.config import TITLE, Parameters
from ptl.errors import UserError
from ptl.keys import allowed, key, shortened
from ptl.learning.life import Life, learn_life, tasks_of
from ptl.methods import BaseMethod
from ptl.world.gridworld import GridWorld

Label = Annotated[str, key("", **{**TITLE, "min_length": 1})]
Colour = Annotated[str, key("", pattern=r"^#[0-9a-f]{6}\Z", wanted="#rrggbb with lower-case digits")]

TRIAL_WORLD = GridWorld.from_text("I...\n.#.A\n...B\n", "trial")
SILENT_SECONDS = 3
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
            problem = f"{name} = {shortened(repr(value))} is not allowed" if hasattr(kind, name) else f"has no {name}"
            raise UserError(f"method {methods.shown(method)}: {problem}; give {allowed(wanted)}") from None
    _check_interface(method, kind)
    if _numbers(_trial(method)) != _numbers(_trial(method)):
        raise UserError(
            f"method {methods.shown(method)}: two lives with equal seeds differ; draw random numbers from self.random"
        )


def colour_notes(references: Iterable[str]) -> list[str]:
    """Return a sentence for each pair of methods that have one colour and so look alike in the figures."""
    by_colour: dict[str, str] = {}
    notes = []
    for reference in references:
        kind = methods.load(reference)
        other = by_colour.setdefault(kind.colour, kind.label)
        if other != kind.label:
            notes.append(f"{kind.label} and {other} have the same colour, {kind.colour}; give one of them another")
    return notes


def _check_interface(method: str | methods.Maker, kind: object) -> None:
    """Refuse a method that defines no episodes, or whose instances lack what `BaseMethod` prepares."""
    name = methods.shown(method)
    calls = ("run_episode", "plan")
    if isinstance(kind, type) and all(getattr(kind, call, None) is getattr(BaseMethod, call) for call in calls):
        near = {call: get_close_matches(call, vars(kind), 1) for call in calls}
        meant = "".join(f"; {found[0]} is probably meant to be {call}" for call, found in near.items() if found)
        raise UserError(f"method {name}: defines neither run_episode nor plan, which say what an episode is{meant}")
    if isinstance(kind, type):
        with methods.reporting_errors_of(method), _limited(method):
            made = kind(TRIAL_WORLD, TRIAL_PARAMETERS, seeding.generator(0, "trial"))
        if missing := [part for part in ("world", "parameters", "random", "library") if not hasattr(made, part)]:
            raise UserError(
                f"method {name}: its instances have no attribute {missing[0]}; let its __init__ call"
                " super().__init__(world, parameters, random)"
            )


def _trial(method: str | methods.Maker) -> Life:
    with methods.reporting_errors_of(method), _limited(method):
        return learn_life(TRIAL_WORLD, tasks_of(TRIAL_WORLD, "AB"), method, TRIAL_PARAMETERS, 0, "trial")


@contextmanager
def _limited(method: str | methods.Maker) -> Iterator[None]:
    """End a trial that takes too long, if this is the main thread, which alone can be interrupted."""
    told = False

    def end(*_: object) -> None:
        nonlocal told
        if not told:
            told = True
            print(f"trying method {methods.shown(method)}, for up to {TRIAL_SECONDS} s", file=sys.stderr, flush=True)
            signal.setitimer(signal.ITIMER_REAL, TRIAL_SECONDS)
            return
        raise UserError(
            f"method {methods.shown(method)}: a life of two tasks on a map of {TRIAL_WORLD.n_states} states has not"
            f" ended after {TRIAL_SECONDS} s; let every episode end"
        )

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, SILENT_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _numbers(life: Life) -> bytes:
    return b"".join(np.concatenate([record.steps, record.q.ravel()]).tobytes() for record in life.records)
