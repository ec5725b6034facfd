"""The explorer in a real browser: comparison with the learning files, and behaviour."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from urllib.parse import quote

import matplotlib as mpl
import numpy as np
import pytest
from explorer_runs import METHODS, SEEDS, TITLES, opened, write_runs
from lives import read_lives
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

from ptl.agent._selection import SkillSelection
from ptl.agent.policies import greedy_policy
from ptl.agent.selection import prior
from ptl.report.explorer import replay
from ptl.report.explorer.data import collect
from ptl.report.explorer.page import PURE_MODULES, build, bundle, pack
from ptl.world.gridworld import ACTIONS

pytestmark = pytest.mark.browser

DESKTOP = {"width": 1280, "height": 900, "deviceScaleFactor": 1, "mobile": False}
PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
READABLE = 4.5  # contrast of text, WCAG 2 AA
WINDOW = 7  # episodes of the final mean


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return write_runs(tmp_path_factory.mktemp("explorer"))


@pytest.fixture(scope="module")
def address(files):
    page = files[0].parents[2] / "explorer.html"
    page.write_text(build(collect(read_lives(*files), window=WINDOW, titles=TITLES)), encoding="utf-8")
    return page.as_uri()


class Page:
    """The open page, as a visitor uses and reads it."""

    def __init__(self, driver, address):
        self.driver = driver
        self.address = address

    def open(self, screen=None, scheme="light", **view):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen or DESKTOP)
        self.driver.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )
        self.driver.get("about:blank")  # a change of the fragment alone would not load the page anew
        self.driver.get(self.address + "#" + "&".join(f"{key}={quote(str(value))}" for key, value in view.items()))
        self.wait(lambda: self.text("#finding"))  # the data are unpacked after the page has loaded
        return self

    def wait(self, condition):
        WebDriverWait(self.driver, 5).until(lambda _: condition())

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.run("return document.querySelector(arguments[0]).textContent", selector)

    def number(self, selector):
        return float(re.sub(r"[^0-9.]", "", self.text(selector)))

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def select(self, selector, value):
        Select(self.find(selector)).select_by_value(value)

    def press(self, *keys, on="body"):
        self.find(on).send_keys(*keys)

    def choose(self, selector):
        """Click the label around a hidden input, as a pointer would."""
        self.run("arguments[0].closest('label').click()", self.find(selector))

    @property
    def shares(self):
        script = "return [...document.querySelectorAll('#detail1 .chance')].map((one) => one.dataset.share)"
        return [float(share) for share in self.run(script)]

    @property
    def view(self):
        fragment = self.driver.current_url.partition("#")[2]
        return dict(pair.split("=") for pair in fragment.split("&"))

    def read_cell(self, stage, state, world):
        """Go to a cell with the arrow keys and return the text for screen readers."""
        canvas = f"#stage{stage} canvas"
        self.run("arguments[0].focus()", self.find(canvas))
        row, column = world.cells[state]
        for _ in range(200):
            at = [int(part) for part in re.findall(r"\d+", self.text("#status"))[:2]]
            if at == [row, column]:
                return self.text("#status")
            step = next(iter(path_towards(world, world.state_at(*at), state)))
            self.press((Keys.ARROW_UP, Keys.ARROW_DOWN, Keys.ARROW_LEFT, Keys.ARROW_RIGHT)[step], on=canvas)
        raise AssertionError(f"never reached row {row}, column {column}")


def path_towards(world, origin, target):
    distance = world.distances_to(target)
    while origin != target:
        action = int(distance[world.successors[origin]].argmin())
        yield action
        origin = world.successors[origin, action]


@pytest.fixture
def page(browser, address):
    page = Page(browser, address)
    yield page
    severe = [entry for entry in browser.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    assert severe == []


@pytest.fixture(scope="module")
def read(files):
    """The learning file of an environment, method and seed."""
    by_name = {(path.parts[-3], path.parts[-2], int(path.stem[-3:])): path for path in files}
    return lambda *name: opened(by_name[name])


# -- the scripts that only compute ---------------------------------------------------------------------------


def compute(browser, expression, *arguments):
    browser.get("about:blank")
    return browser.execute_script(bundle(PURE_MODULES) + f"\nreturn {expression};", *arguments)


def test_world_is_that_of_python(browser, published_maps):
    for name, world in published_maps.items():
        goal = world.goals["F"]
        expression = "((world) => ({...world, to: distancesTo(world, arguments[1])}))(parseWorld(arguments[0]))"
        shown = compute(browser, expression, world.text, goal)
        assert shown["cells"] == world.cells.tolist(), name
        assert shown["successors"] == world.successors.ravel().tolist()
        assert (shown["start"], shown["goals"]) == (world.start, world.goals)
        assert shown["to"] == world.distances_to(goal).tolist()


def test_opened_records_are_those_of_the_file(browser, files, read):
    browser.get("about:blank")
    script = """
      const [packed, done] = arguments;
      unpack(packed).then((raw) => {
        const [environment] = openDataset(raw).environments;
        const record = environment.task("ptl", 3, "B");
        done({value: record.value, policy: [...record.policy], path: recordedEpisode(environment.world, record).path,
              guides: record.guides.map((guide) => [guide.subgoal, guide.from])});
      });
    """
    packed = pack(collect(read_lives(*files), window=WINDOW))
    shown = browser.execute_async_script(bundle(PURE_MODULES) + script, packed)
    file = read("chain", "ptl", 3)
    task = file.tasks["B"]
    np.testing.assert_allclose(shown["value"], task.q.max(axis=1), rtol=1.2e-4)
    assert shown["policy"] == greedy_policy(task.q).tolist()
    assert (shown["path"][0], shown["path"][-1]) == (task.start, task.goal)
    assert len(shown["path"]) == task.steps[0] + 1
    assert all(after in file.world.successors[state] for state, after in pairwise(shown["path"]))
    skills = [skill for skill in file.library if skill.learned_after < 2]
    assert shown["guides"] == [[skill.subgoal, "CA"[skill.learned_after]] for skill in skills]
    assert skills


# -- what is shown against the files -------------------------------------------------------------------------


def test_opens_with_ptl_beside_no_transfer_on_a_task_in_the_middle(page):
    page.open()
    assert page.text("#stage1 select option:checked") == "PTL"
    assert page.text("#stage2 select option:checked") == "No transfer"
    assert page.find("input[name=task]:checked").get_attribute("value") == "A"
    assert "one goal after another: C, then A and B. It has learned no values for a new" in " ".join(
        page.text(".lead").split()
    )
    assert page.find("#stage2").is_displayed()


@pytest.mark.parametrize("environment", list(TITLES))
def test_facts_of_every_choice(page, read, environment):
    page.open(compare="no")
    page.select("#environment", environment)
    page.select("#seed", str(SEEDS[1]))
    for method in METHODS:
        page.select("#stage1 select", method)
        file = read(environment, method, SEEDS[1])
        letter = "BA"[METHODS.index(method) % 2]
        task = file.tasks[letter]
        page.choose(f"input[name=task][value={letter}]")
        assert page.number("#stage1 [data-fact=first]") == task.steps[0]
        assert page.number("#stage1 [data-fact=total]") == task.steps.sum()
        last = task.steps[-WINDOW:].mean()
        assert page.number("#stage1 [data-fact=last]") == pytest.approx(last, rel=6e-4)
        assert page.text("#stage1 dt.last") == f"Last {WINDOW}, mean"
        assert f"on average in its last {WINDOW};" in page.text("#finding")
    assert page.view["environment"] == environment
    assert page.text("#environment option:checked") == TITLES[environment]


@pytest.mark.parametrize("place", ["beside the goal", "on the way", "beside the start"])
def test_value_and_action_of_a_cell(page, read, place):
    stage, method = (1, "ptl") if place != "beside the start" else (2, "no_transfer")
    page.open(environment="flat", task="B", seed=3, mode="greedy")
    file = read("flat", method, 3)
    task, world = file.tasks["B"], file.world
    value, policy = task.q.max(axis=1), greedy_policy(task.q)
    path = [task.start]
    for action in path_towards(world, task.start, task.goal):
        path.append(int(world.successors[path[-1], action]))
    state = {"beside the goal": path[-2], "on the way": path[len(path) // 2], "beside the start": path[1]}[place]
    spoken = page.read_cell(stage, state, world)
    assert page.text(f"#stage{stage} .cell") == spoken
    assert spoken.startswith("Row {}, column {}: value ".format(*world.cells[state]))
    assert spoken.endswith(f"; {ACTIONS[policy[state]]}." if policy[state] >= 0 else "no action known.")
    if value[state] == 0:
        assert "value 0, never informed" in spoken
        return
    number = re.search(r"value ([\d.]+(?:\s×\s10\^−\d+)?)", spoken).group(1)
    assert float(re.sub(r"\s×\s10\^−", "e-", number)) == pytest.approx(value[state], rel=6e-3)
    steps = float(re.search(r"as ([\d.]+) steps", spoken).group(1))
    assert steps == pytest.approx(1 + np.log(value[state]) / np.log(0.95), rel=6e-3)


def test_probabilities_at_the_cursor(page, read):
    """Worked out here from the stored draws and steps with the package's own selection."""
    page.open(environment="chain", task="B", seed=8)
    file = read("chain", "ptl", 8)
    task, world = file.tasks["B"], file.world
    subgoals = [task.start, *[skill.subgoal for skill in file.library if skill.learned_after < 2]]
    selection = SkillSelection(prior(world.cells, subgoals, task.goal, world.diagonal))
    for episode in range(1, len(task.steps) + 1):
        if episode in (1, 2, 3, 12, 40):
            page.run(
                "const c = document.getElementById('cursor'); c.value = arguments[0];"
                " c.dispatchEvent(new Event('input'))",
                episode,
            )
            np.testing.assert_allclose(page.shares, selection.probabilities(), atol=5.1e-5)
            assert page.number("#episode") == episode
            steps = page.find("#curve-values li b").get_attribute("data-steps")
            assert int(steps) == task.steps[episode - 1]
            assert f"Episode {episode} drew" in page.text("#detail1 .drawn")
        selection.record(task.selected_in(episode - 1), int(task.steps[episode - 1]))
    assert len(subgoals) > 1


def test_policy_reuse_offers_the_earlier_policies(page, read):
    page.open(environment="chain", task="B", seed=3, method="policy_reuse")
    names = [part.text for part in page.driver.find_elements(By.CSS_SELECTOR, "#detail1 .guide b")]
    assert names == ["New policy", "Policy of C", "Policy of A"]
    np.testing.assert_allclose(page.shares, 1 / 3, atol=5.1e-5)  # nothing is known before the first episode


def test_choosing_a_skill_shows_its_arrows(page, read):
    page.open(environment="chain", task="B", seed=3)
    page.choose("#detail1 .guide input[value='1']")
    page.run("document.querySelector('#stage1 details').open = true")
    WebDriverWait(page.driver, 5).until(lambda _: page.text("#stage1 pre"))
    rows = page.text("#stage1 pre").split("\n")
    assert page.view["guide"] == "1"
    file = read("chain", "ptl", 3)
    skill, world, task = file.library[0], file.world, file.tasks["B"]
    marked = {task.start, task.goal, *[one.subgoal for one in file.library]}
    for state, (row, column) in enumerate(world.cells):
        if state not in marked:
            assert rows[row][column] == ("↑↓←→"[skill.policy[state]] if skill.policy[state] >= 0 else "·")
    row, column = world.cells[skill.subgoal]
    assert rows[row][column] == "1"
    assert [[letter == "#" for letter in line] for line in rows] == world.walls.tolist()


# -- playing -------------------------------------------------------------------------------------------------


def walk(world, policy, state, goal, end=-1):
    """Steps and last state of a policy without chance; None as steps if it goes round in circles."""
    met = {state}
    steps = 0
    while state not in (goal, end) and policy[state] >= 0:
        state = int(world.successors[state, policy[state]])
        steps += 1
        if state in met:
            return None, state
        met.add(state)
    return steps, state


def expected_end(steps, state, goal):
    if steps is None:
        return "Goes round in circles"
    if steps == 0:
        return "Nothing is known at the start"
    return f"Goal B after {steps} steps" if state == goal else f"Stops after {steps} steps"


@pytest.mark.parametrize("method", ["ptl", "no_transfer", "policy_reuse", "full_transfer"])
def test_the_learned_policy_plays(page, read, method):
    page.open(environment="chain", task="B", seed=3, method=method, mode="greedy", compare="no")
    page.find("#finish").click()
    file = read("chain", method, 3)
    task = file.tasks["B"]
    steps, state = walk(file.world, greedy_policy(task.q), task.start, task.goal)
    shortest = file.world.shortest_path_length(task.start, task.goal)
    shown = page.text("#stage1 .outcome")
    assert shown.startswith(expected_end(steps, state, task.goal))
    assert state != task.goal or shown.endswith(f"the shortest path has {shortest}.")
    assert shown in page.text("#status")


def test_a_guided_episode_plays(page, read):
    page.open(environment="chain", task="B", seed=3, guide=1, mode="guided", compare="no")
    page.find("#finish").click()
    file = read("chain", "ptl", 3)
    task, world, skill = file.tasks["B"], file.world, file.library[0]
    lead, state = walk(world, skill.policy, task.start, task.goal, skill.subgoal)
    assert state == skill.subgoal
    rest, state = walk(world, greedy_policy(task.q), state, task.goal)
    assert page.text("#stage1 .outcome").startswith(
        expected_end(None if rest is None else lead + rest, state, task.goal)
    )


def test_play_moves_step_by_step_and_pauses(page):
    page.open(environment="chain", task="B", seed=3, mode="greedy")
    assert page.text("#stage1 .outcome").startswith("Ready")
    page.find("#step").click()
    assert page.text("#stage1 .outcome").startswith("1 step")
    page.find("#play").click()
    assert page.text("#play") == "Pause"
    WebDriverWait(page.driver, 5).until(lambda _: page.number("#stage1 .outcome") >= 3)
    page.press(" ")
    assert page.text("#play") == "Play"
    held = page.text("#stage1 .outcome")
    page.find("#restart").click()
    assert held != page.text("#stage1 .outcome") == "Ready: the learned policy."


def test_first_episodes_are_those_of_the_files(page, read):
    page.open(environment="chain", task="B", seed=3)
    page.find("#finish").click()
    for stage, method in ((1, "ptl"), (2, "no_transfer")):
        file = read("chain", method, 3)
        task = file.tasks["B"]
        shortest = file.world.shortest_path_length(task.start, task.goal)
        expected = f"Goal B after {task.steps[0]:,} steps; the shortest path has {shortest}."
        assert page.text(f"#stage{stage} .outcome") == expected
    assert page.text("#legend-title").startswith("How often the cell was entered")


def test_a_first_episode_starts_from_a_blank_map_and_counts_visits(page, read):
    page.open(environment="chain", task="B", seed=3)
    for stage in (1, 2):
        assert "no value is learned yet for goal B" in page.text(f"#stage{stage} .outcome")
    file = read("chain", "ptl", 3)
    world, start = file.world, file.tasks["B"].start
    script = """
      const {width, height} = document.querySelector("#stage1 canvas");
      const copy = new OffscreenCanvas(width, height).getContext("2d", {willReadFrequently: true});
      copy.drawImage(document.querySelector("#stage1 canvas"), 0, 0);
      const unit = height / arguments[0];
      const corner = (place) => Math.round((place + 0.1) * unit);
      return new Set(arguments[1].map(([row, column]) =>
        copy.getImageData(corner(column), corner(row), 1, 1).data.join())).size;
    """
    assert page.run(script, world.shape[0], world.cells[start + 1 :].tolist()) <= 2  # the floor, and marks on it
    page.run("document.querySelector('#stage1 details').open = true")
    page.wait(lambda: page.text("#stage1 pre"))
    assert "o" not in page.text("#stage1 pre")
    assert page.read_cell(1, start, world).endswith("not entered yet.")
    page.find("#finish").click()
    assert page.run(script, world.shape[0], world.cells.tolist()) > 5
    assert "o" in page.text("#stage1 pre")
    page.press(Keys.ARROW_DOWN, on="#stage1 canvas")
    assert re.search(r": entered (once|\d+ times)\.$", page.text("#status"))


def test_who_leads_in_a_first_episode_is_told(page, files):
    [path] = [path for path in files if path.match("chain/ptl/seed_003.h5")]
    data = collect(read_lives(path), window=WINDOW)
    tasks = data["environments"][0]["runs"]["ptl/3"]["tasks"]
    task = next(task for task in tasks if any(candidate for candidate, _ in task["first"]["parts"]))
    page.open(environment="chain", task=task["name"], seed=3)
    before = begin = 0
    told = set()
    for candidate, steps in task["first"]["parts"]:
        if steps > 1:
            page.find("#restart").click()
            page.run("for (let i = 0; i < arguments[0]; i += 1) document.getElementById('step').click()", begin + 1)
            after = f"exploring after skill {before}" if before else "exploring"
            expected = f"led by skill {candidate}" if candidate else after
            assert page.text("#stage1 .outcome").endswith(f", {expected}")
            told.add(expected)
        before, begin = candidate, begin + steps
    assert any(words.startswith("led by") for words in told)


def test_a_cut_first_episode_says_so(browser, files, monkeypatch, tmp_path, read):
    monkeypatch.setattr(replay, "MAX_RECORDED_STEPS", 30)
    [path] = [path for path in files if path.match("chain/no_transfer/seed_003.h5")]
    (tmp_path / "cut.html").write_text(build(collect(read_lives(path), window=WINDOW)), encoding="utf-8")
    page = Page(browser, (tmp_path / "cut.html").as_uri()).open(task="B")
    page.find("#finish").click()
    file = read("chain", "no_transfer", 3)
    steps = file.tasks["B"].steps[0]
    assert page.text("#stage1 .outcome") == f"First 30 of {steps:,} steps recorded."
    assert page.text("#compare-note") and page.find("#compare-note").is_displayed()


def test_nothing_is_headlined_for_the_first_task(page):
    page.open(environment="chain", task="C", seed=3)
    assert page.text("#finding").startswith("Task C is the first, so nothing is transferred yet")


def test_comparison_names_the_better_method(page, read):
    page.open(environment="chain", task="B", seed=3)
    ours, base = read("chain", "ptl", 3), read("chain", "no_transfer", 3)
    totals = {"PTL": ours.tasks["B"].steps.sum(), "No transfer": base.tasks["B"].steps.sum()}
    less, more = sorted(totals, key=totals.get)
    factor = totals[more] / totals[less]
    said = f"{factor:.1f}" if factor < 10 else f"{factor:.0f}"
    expected = f"{less} took {totals[less]:,} steps, {more} {totals[more]:,}: {said} times as many."
    assert page.text("#finding") == f"Over 40 episodes of task B {expected}"
    page.choose("#compare")
    assert not page.find("#stage2").is_displayed()
    assert "compare=no" in page.driver.current_url


# -- keyboard, address, layout, privacy ----------------------------------------------------------------------


def test_keys_move_the_cursor(page):
    page.open(environment="chain")
    page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_LEFT)
    assert page.number("#episode") == 3
    page.press(Keys.PAGE_UP)
    assert page.number("#episode") == 13
    page.press(Keys.ARROW_RIGHT, on="#cursor")
    assert page.number("#episode") == 14
    assert page.view["episode"] == "14"
    assert page.find("#cursor").get_attribute("aria-valuetext").startswith("Episode 14: PTL ")
    page.press(Keys.PAGE_DOWN)
    page.press(*[Keys.ARROW_LEFT] * 6)
    assert page.number("#episode") == 1  # stays within the episodes


def test_the_address_holds_the_view(page):
    page.open(environment="chain", task="B", seed=8, method="policy_reuse", guide=1, episode=7, mode="greedy")
    asked = page.view
    page.driver.refresh()
    assert page.view == asked
    assert page.number("#episode") == 7
    assert page.find("#detail1 input:checked").get_attribute("value") == "1"
    page.run("location.hash = '#environment=flat&task=B&seed=3&theme=dark'")
    WebDriverWait(page.driver, 5).until(lambda _: page.view.get("method") == "ptl")
    assert page.run("return document.documentElement.dataset.theme") == "dark"


def test_an_address_that_cannot_be_shown_falls_to_one_that_can(page):
    page.open(environment="nowhere", task="Z", seed="x", episode=-4, guide=99, method="<b>")
    assert page.view["environment"] == "chain"
    assert (page.view["task"], page.view["seed"], page.view["method"]) == ("A", "3", "ptl")
    assert page.number("#episode") == 1


@pytest.mark.parametrize("environment", list(TITLES))
@pytest.mark.parametrize("compare", ["yes", "no"])
def test_no_sideways_scrolling_on_a_phone(page, environment, compare):
    page.open(screen=PHONE, environment=environment, compare=compare)
    script = "return [document.documentElement.scrollWidth, window.innerWidth]"
    assert page.run(script) == [390, 390]
    assert 300 < page.find("#stage1 .map-holder").size["width"] < 390
    page.find("#zoom").click()
    page.run("document.querySelector('#stage1 details').open = true")
    page.find("#finish").click()
    assert page.run(script) == [390, 390]


CONTRASTS = """
  const parse = (text) => text.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((part) => part / 255)
    .map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4))
    .reduce((sum, part, i) => sum + part * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = parse(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const shown = (element) => element.getClientRects().length && !element.closest(".unseen, svg, noscript");
  const poor = [];
  let texts = 0;
  for (const element of document.body.querySelectorAll("*")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    if (!own || !shown(element) || element.closest("script, option")) continue;
    texts += 1;
    const [ink, paper] = [parse(getComputedStyle(element).color), behind(element)];
    const [a, b] = [light(ink), light(paper)].sort((x, y) => y - x);
    const contrast = (a + 0.05) / (b + 0.05);
    if (contrast < arguments[0]) poor.push([element.outerHTML.slice(0, 80), contrast]);
  }
  return [texts, poor];
"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_is_readable_in_both_schemes(page, scheme):
    page.open(scheme=scheme)
    page.find("#step").click()
    texts, poor = page.run(CONTRASTS, READABLE)
    assert texts > 50
    assert poor == []
    dark = page.run("return getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, re.findall(r"\d+", dark))) < 150) == (scheme == "dark")


def test_the_button_overrides_the_scheme(page):
    page.open(scheme="dark")
    page.find("#theme").click()
    assert page.run("return document.documentElement.dataset.theme") == "light"
    assert page.view["theme"] == "light"


def test_walls_are_drawn_as_walls_and_cells_by_their_value(page, read):
    page.open(environment="chain", task="B", seed=3, compare="no", mode="greedy")
    file = read("chain", "ptl", 3)
    world, task = file.world, file.tasks["B"]
    script = """
      const canvas = document.querySelector("#stage1 canvas");
      const unit = canvas.height / arguments[1];
      const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return arguments[0].map(([row, column]) => {
        const first = 4 * ((row * unit + 2) * canvas.width + column * unit + 2);
        return [...data.slice(first, first + 3)];
      });
    """
    beside = int(world.successors[task.goal, 2])
    places = [[0, 0], [int(part) for part in np.argwhere(world.walls)[-1]], world.cells[beside].tolist()]
    wall, other_wall, cell = page.run(script, places, world.shape[0])
    expected = page.run("return getComputedStyle(document.documentElement).getPropertyValue('--wall')").strip()
    assert wall == other_wall == [int(expected[i : i + 2], 16) for i in (1, 3, 5)]
    file = read("chain", "ptl", 3)
    value = file.tasks["B"].q.max(axis=1)[beside]
    steps = 1 + np.log(value) / np.log(0.95)
    place = 1 - min(1.0, np.log(max(1.0, steps)) / np.log(1000))
    viridis = 255 * np.array(mpl.colormaps["viridis"](place)[:3])
    np.testing.assert_allclose(cell, viridis, atol=6)


def test_every_control_has_a_name_for_screen_readers(page):
    page.open()
    nodes = page.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = {"button", "combobox", "slider", "radio", "switch", "checkbox", "application", "image", "textbox"}
    controls = [node for node in nodes if node.get("role", {}).get("value") in roles and not node["ignored"]]
    assert len(controls) > 20
    assert [node for node in controls if not node.get("name", {}).get("value", "").strip()] == []


def test_every_control_can_be_reached_by_tab_and_shows_focus(page):
    page.open(mode="greedy")
    reached = set()
    for _ in range(45):
        page.driver.switch_to.active_element.send_keys(Keys.TAB)
        active = page.run(
            "const a = document.activeElement;"
            "const at = a.matches('.segments input') ? a.nextElementSibling : a;"
            "const name = a.id || a.name || a.closest('section')?.id + ' ' + a.tagName;"
            "return [name, getComputedStyle(at).outlineStyle]"
        )
        reached.add(active[0])
        assert active[1] != "none" or active[0] == "undefined BODY", active
    wanted = {
        "environment",
        "task",
        "seed",
        "layer",
        "compare",
        "mode",
        "play",
        "speed",
        "cursor",
        "guide",
        "theme",
    }
    assert wanted | {"stage1 CANVAS", "stage2 CANVAS", "stage1 SELECT"} <= reached


def test_nothing_is_loaded_from_anywhere(page):
    page.driver.get_log("performance")
    page.open(environment="chain")
    page.find("#finish").click()
    page.select("#environment", "flat")
    asked = set()
    for entry in page.driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            asked.add(message["params"]["request"]["url"].partition("#")[0])
    assert asked - {"about:blank", "data:,"} == {page.address}
    assert page.run("return performance.getEntriesByType('resource').length") == 0
    blocked = page.driver.execute_async_script(
        "const done = arguments[0]; fetch('https://example.org').then(() => done(false), () => done(true))"
    )
    assert blocked  # the page's own policy forbids it
    page.driver.get_log("browser")  # the refusal above is noted there
