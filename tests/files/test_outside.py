"""Users' methods, with their own parameters."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from projects import ROOMS

from ptl.cli import commands
from ptl.errors import UserError
from ptl.files import store
from ptl.files.configuration import completed
from ptl.files.outside import configured, learning_code, local_sources
from ptl.jobs.learn import tasks_in
from ptl.learning.trial import check_method

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
    done = CliRunner().invoke(commands, ["learn", *options, "--output", name, *arguments], catch_exceptions=False)
    assert done.exit_code == 0, done.output


def steps(name: str) -> list[int]:
    return tasks_in(store.read(name))["B"].steps.tolist()


def verified(name: str) -> str:
    """Output of `ptl verify`, at a fault before it fails."""
    return CliRunner().invoke(commands, ["verify", name]).output


def test_own_parameters_act_and_are_kept(folder: Path) -> None:
    learn("default.h5")
    learn("same.h5", "--method-parameters", '{"chance": 0.3}')
    learn("other.h5", "--method-parameters", '{"chance": 1}')
    assert steps("default.h5") == steps("same.h5") != steps("other.h5")
    job = store.read("other.h5").job
    assert (job.method, job.reference, job.own, job.environment) == ("mine", "mine.py", {"chance": 1.0}, "rooms")


def test_a_file_is_compared_with_its_method(folder: Path) -> None:
    learn("one.h5")
    assert verified("one.h5") == "one.h5: is whole and consistent\n"
    before = learning_code("mine.py")
    Path("mine.py").unlink()
    gone = "one.h5: its code cannot be compared with the present one: method mine.py: no such file"
    assert verified("one.h5").startswith(gone)
    Path("mine.py").write_text(MINE + "# changed\n")
    assert learning_code("mine.py") != before
    assert verified("one.h5").startswith("one.h5: was made with another version of the code")


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


HELPED = MINE.replace("from typing", "import {helper}\nfrom typing").replace(
    "epsilon=self.own.chance", "epsilon={helper}.CHANCE"
)


def test_what_a_file_imports_from_its_folder_counts_as_its_source(folder: Path) -> None:
    place = folder / "somewhere"
    place.mkdir()
    (place / "helped.py").write_text(HELPED.replace("{helper}", "close_helper"))
    (place / "close_helper.py").write_text("from tools_of_mine.chances import CHANCE\n")
    (place / "tools_of_mine").mkdir()
    for name, text in {
        "__init__": "",
        "chances": "from . import deep\nCHANCE = 0.5\n",
        "deep": "import h5py\n",
    }.items():
        (place / "tools_of_mine" / f"{name}.py").write_text(text)
    (place / "bystander.py").write_text("")
    reference = "somewhere/helped.py"
    check_method(reference)
    root, paths = local_sources(reference)
    expected = "close_helper helped tools_of_mine/__init__ tools_of_mine/chances tools_of_mine/deep"
    assert [path.relative_to(root).as_posix() for path in paths] == [f"{name}.py" for name in expected.split()]
    digests = [learning_code(reference)]
    for name in ("bystander", "close_helper", "tools_of_mine/deep"):
        with (place / f"{name}.py").open("a") as file:
            file.write("# changed\n")
        digests.append(learning_code(reference))
    assert digests[0] == digests[1] != digests[2] != digests[3]


def test_what_an_import_path_imports_from_its_package_counts_as_its_source(folder: Path) -> None:
    place = folder / "agents_of_mine"
    place.mkdir()
    (place / "__init__.py").write_text("")
    (place / "numbers.py").write_text("CHANCE = 0.5\n")
    agent = HELPED.replace("import {helper}", "from . import numbers").replace("{helper}", "numbers")
    (place / "agent.py").write_text(agent.replace("    label", '    name = "agent"\n    label'))
    reference = "agents_of_mine.agent:Method"
    check_method(reference)
    assert [path.name for path in local_sources(reference)[1]] == ["__init__.py", "agent.py", "numbers.py"]
    (place / "alone.py").write_text(MINE)
    assert [path.name for path in local_sources("agents_of_mine.alone:Method")[1]] == ["__init__.py", "alone.py"]
    before = learning_code(reference)
    (place / "numbers.py").write_text("CHANCE = 0.6\n")
    assert learning_code(reference) != before
