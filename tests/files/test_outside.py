"""Methods from elsewhere, with parameters of their own."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from projects import ROOMS

from ptl.cli.learn import command
from ptl.errors import UserError
from ptl.files.configuration import completed
from ptl.files.outside import configured, learning_code
from ptl.files.results import open_learning
from ptl.files.verification import faults_of

MINE = """
from typing import Annotated

from ptl.keys import Group, key
from ptl.methods.no_transfer import Method as NoTransfer


class Own(Group, frozen=True, kw_only=True):
    chance: Annotated[float, key("Probability of a random action.", ge=0, le=1)] = 0.3


class Method(NoTransfer):
    label = "Mine"
    colour = "#123456"
    own = Own()

    def run_episode(self, learner):
        learner.explore(epsilon=self.own.chance)
        return []
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("rooms.txt").write_text(ROOMS)
    Path("mine.py").write_text(MINE)
    return tmp_path


def learn(name: str, *arguments: str) -> None:
    options = ["--map", "rooms.txt", "--method", "mine.py", "--parameters", '{"learning": {"episodes": 5}}']
    done = CliRunner().invoke(command, [*options, "--output", name, *arguments], catch_exceptions=False)
    assert done.exit_code == 0, done.output


def steps(name: str) -> list[int]:
    with open_learning(name) as file:
        return file.tasks["B"].steps.tolist()


def test_own_parameters_act_and_are_kept(folder: Path) -> None:
    learn("default.h5")
    learn("same.h5", "--method-parameters", '{"chance": 0.3}')
    learn("other.h5", "--method-parameters", '{"chance": 1}')
    assert steps("default.h5") == steps("same.h5") != steps("other.h5")
    with open_learning("other.h5") as file:
        assert file.method == "mine" and file.environment == "rooms"
        assert file.parameters["method"] == {"reference": "mine.py", "parameters": {"chance": 1.0}}


def test_a_file_is_held_against_its_method(folder: Path) -> None:
    learn("one.h5")
    assert faults_of(Path("one.h5")) == []
    before = learning_code("mine.py")
    Path("mine.py").unlink()
    [fault] = faults_of(Path("one.h5"))
    assert "was made by the method mine.py, which is not there" in fault
    Path("mine.py").write_text(MINE + "# changed\n")
    assert learning_code("mine.py") != before


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"mine": {"chance": 2}}, "method_parameters.mine.chance: 2 is not allowed; give a number >= 0 and <= 1"),
        ({"mine": {"luck": 1}}, "method_parameters.mine.luck: unknown; known are chance"),
        ({"ptl": {"luck": 1}}, "method_parameters.ptl: method ptl has no parameters of its own"),
        ({"yours": {"luck": 1}}, "method_parameters.yours: is not compared; give parameters of ptl, mine"),
    ],
)
def test_a_wrong_parameter_is_refused_before_the_first_job(folder: Path, parameters: dict, message: str) -> None:
    config = {"run": "own", "environments": {"rooms": {"map": "rooms.txt"}}, "methods": ["ptl", "mine.py"]}
    completed({**config, "method_parameters": {"mine": {"chance": 0.5}}})
    with pytest.raises(UserError, match=f"^configuration key {message}"):
        completed({**config, "method_parameters": parameters})


def test_a_configured_class_keeps_what_was_not_given(folder: Path) -> None:
    assert configured("mine.py", {}).own.chance == 0.3
    assert configured("mine.py", {"chance": 0.7}).own.chance == 0.7
    assert configured("mine.py", {}).own.chance == 0.3
