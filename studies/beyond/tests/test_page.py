"""The page of the second study: its sentences follow from the numbers, whoever they favour."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ptl import methods
from ptl.errors import UserError
from ptl.measures.statistics import Resampling
from studies.beyond import figures, page, summary
from studies.beyond import methods as our_methods
from studies.beyond.collect import LIFE_COLUMNS
from studies.beyond.design import SecondStudy

HOW = Resampling(0.95, 200)
FAMILIES = ("chain", "maze")
STUDY = SecondStudy.read(
    {"methods": ["no_transfer", "ptl", "ptl_goal", "ptl_frontier", "frontier_only", "rmax_memory"]}
)


def lives(**ratios: float | tuple[float, float]) -> pd.DataFrame:
    """Lives whose cost is a multiple of that of PTL, in both families or in each of them."""
    random = np.random.default_rng(1)
    rows = []
    for family in FAMILIES:
        base = 20 * np.exp(random.normal(0, 0.5, 8))
        for method, ratio in {"ptl": 1.0, **ratios}.items():
            factor = ratio[FAMILIES.index(family)] if isinstance(ratio, tuple) else ratio
            for place, cost in enumerate(base):
                for seed in range(2):
                    steps = 1000 * cost * factor * np.exp(random.normal(0, 0.02))
                    rows.append((family, str(4000 + place), 300, "increasing", method, seed, steps, 1000, 3))
    return pd.DataFrame(rows, columns=list(LIFE_COLUMNS))


def said(**ratios: float | tuple[float, float]) -> list[str]:
    """Lead and lines of each answer in one text."""
    frame = lives(**ratios)
    made = page.answers(summary.Means(frame, HOW), page.looks_of(STUDY, frame["method"]), FAMILIES)
    return [" ".join([answer["lead"], *answer["lines"]]) for answer in made]


def test_a_rival_is_called_what_it_is():
    assert "Cheaper than PTL in every family: “R-max, model kept”." in said(rmax_memory=0.1)[0]
    assert "Dearer in every family: “R-max, model kept”." in said(rmax_memory=3.0)[0]
    neither = "Not the same in every family, or not told from PTL: “R-max, model kept”."
    assert neither in said(rmax_memory=(0.5, 2.0))[0]
    assert neither in said(rmax_memory=1.0)[0]


def test_what_a_rival_may_know_is_said_beside_its_win():
    fair = "To be fair to PTL: “R-max, model kept” relies on moves that are certain"
    assert fair in said(rmax_memory=0.1)[0]
    assert fair not in said(rmax_memory=3.0)[0]


def test_the_answers_can_be_in_favour_of_the_library():
    first, second, third = said(no_transfer=4.0, rmax_memory=2.0, ptl_goal=1.5)
    assert "Dearer in every family: “R-max, model kept”." in first
    assert "as a multiple of PTL’s cost: “PTL, subgoal = goal” 1.493 [1.4" in second
    assert "in 2 of 2 families of generated maps, more in 0; by family it takes 0.2" in third
    assert "in 0 of 2 families of generated maps, more in 2" in said(no_transfer=0.5)[2]


@pytest.mark.parametrize(
    ("alone", "counts", "meaning"),
    [
        (0.1, "1.999 [", "the library makes it dearer. What it saves is owed to the memory"),
        (0.4, "0.5", "(less in 2, more in 0 of 2 families); the library helps it."),
        ((0.1, 0.4), "less in 1, more in 1 of 2 families", ""),
        (0.2, "(less in 0, more in 0 of 2 families)", "makes no difference that these maps can show."),
    ],
)
def test_what_our_proposal_owes_to_the_library(alone, counts, meaning):
    second = said(ptl_frontier=0.2, frontier_only=alone)[1]
    assert counts in second and meaning in second


def test_pairs_by_map_tell_what_separate_intervals_hide():
    """Costs differ tenfold between maps and by a tenth between methods: each interval alone holds the other's mean."""
    frame = lives(ptl_frontier=0.22, frontier_only=0.2)
    costs = summary.costs(summary.Means(frame, HOW), frame).set_index(["family", "method"])
    both, alone = costs.loc[("chain", "ptl_frontier")], costs.loc[("chain", "frontier_only")]
    assert both["low"] < alone["cost"] and alone["high"] > both["cost"]
    assert "more in 2 of 2 families); the library makes it dearer" in said(ptl_frontier=0.22, frontier_only=0.2)[1]


def test_the_least_of_a_column_stands_beside_what_cannot_be_told_from_it():
    frame = lives(rmax_memory=0.1, frontier_only=0.1, ptl_frontier=0.12)
    costs = summary.costs(summary.Means(frame, HOW), frame)
    bold = costs[costs["least"] & (costs["family"] == "chain")]
    assert set(bold["method"]) == {"rmax_memory", "frontier_only"}


def test_one_sentence_states_the_level_and_the_resamples():
    [line] = [line for line in page.method_lines(STUDY, HOW) if "bootstrap" in line]
    assert line.startswith("Every interval on this page is the 95% percentile interval of 200 bootstrap resamples")


def test_the_names_that_are_shown_are_explained():
    explained = {method for _, own in page.GLOSSARY.values() for method in own}
    assert set(page.KNOWLEDGE) - explained == {*page.READINGS, "ptl_supervised"}  # under PTL
    names = [name for name, _ in page.glossary(page.looks_of(STUDY, ["mine"]))]
    assert names == ["PTL", "No transfer", "PTL, subgoal = …", "Frontier", "R-max"]


def test_every_method_says_what_it_may_know():
    own = {*our_methods.names(), "no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised"}
    assert own == set(page.KNOWLEDGE)
    looks = page.looks_of(STUDY, ["mine", "ptl", "yours"])
    assert [looks[name].label for name in ("ptl", "mine", "yours")] == ["PTL", "Mine", "Yours"]
    assert looks["mine"].colour != looks["yours"].colour and looks["mine"].dashed
    assert list(looks)[-2:] == ["mine", "yours"]
    assert looks["rmax_memory"].label == methods.load(our_methods.reference("rmax_memory")).label
    table = page.knowledge_table(looks)
    cells = {row.label: [cell.text for cell in row.cells] for row in table.groups[0].rows}
    assert cells["Mine"] == ["not stated"] * 3
    assert cells["R-max, model kept"][1] == "yes"


def test_the_readers_own_method_leads_the_page_and_says_what_it_knows(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from ptl.methods.no_transfer import Method as Base\n\nclass Method(Base):\n"
        "    label, colour, knows = 'My own', '#123456', ('nothing', 'yes', 'walls')\n"
    )
    study = SecondStudy.read({"methods": ["no_transfer", "ptl", str(tmp_path / "mine.py")]})
    frame = lives(no_transfer=4.0, mine=0.5)
    looks, means = page.looks_of(study, frame["method"]), summary.Means(frame, HOW)
    first = page.answers(means, looks, FAMILIES)[0]
    assert first["lead"].startswith("Cheaper than PTL in every family: “My own”")
    assert first["lines"][-1].startswith("To be fair to PTL: “My own” relies on moves that are certain")
    assert page.lead(means, looks, FAMILIES).startswith("“My own” takes 0.499 [0.494, 0.503] times PTL’s steps. On")
    assert "1 kind (family) of generated maps (8 maps each" in page.introduction(
        study, frame[frame["family"] == "chain"]
    )
    [row] = [row for row in page.knowledge_table(looks).groups[0].rows if row.label == "My own"]
    assert [cell.text for cell in row.cells] == ["nothing", "yes", "walls"]


def test_what_a_method_knows_is_three_texts(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from ptl.methods.no_transfer import Method as Base\n\nclass Method(Base):\n"
        "    label, colour, knows = 'My own', '#123456', 'nothing'\n"
    )
    with pytest.raises(UserError, match="knows = 'nothing' is not allowed; give three texts"):
        SecondStudy.read({"methods": [str(tmp_path / "mine.py")]})


def test_figures_have_a_panel_for_each_family_and_a_curve_for_each_method():
    frame = lives(no_transfer=4.0, rmax_memory=0.1)
    looks, titles = page.looks_of(STUDY, frame["method"]), page.titles_of(FAMILIES, ())
    drawn = figures.profile(summary.profiles(frame, HOW), looks, titles)
    panels = [ax for ax in drawn.axes if ax.get_visible()]
    assert [ax.get_title(loc="left") for ax in panels] == ["Chain of rooms", "Perfect maze"]
    assert [len(ax.get_lines()) for ax in panels] == [3, 3]
    costs = summary.costs(summary.Means(frame, HOW), frame)
    points = figures.overview(costs, looks, titles).axes[0].collections[-1].get_offsets()
    expected = costs[costs["family"] == "chain"].set_index("method")["ratio"].dropna()
    assert points[:, 0].tolist() == sorted(expected)  # the cheapest first


def test_one_life_on_one_map_has_no_interval_and_is_drawn():
    frame = lives(no_transfer=2.0)
    frame = frame[(frame["map"] == "4000") & (frame["seed"] == 0)]
    costs = summary.costs(summary.Means(frame, HOW), frame)
    assert costs["high"].isna().all()
    drawn = figures.overview(costs, page.looks_of(STUDY, costs["method"]), dict(zip(FAMILIES, FAMILIES, strict=True)))
    assert all(np.isfinite(ax.get_xlim()).all() for ax in drawn.axes)


def test_a_study_without_sequences_has_an_empty_table_and_one_without_ptl_no_answers():
    assert page.by_group_table({}, page.looks_of(STUDY, []), {}, [], "", "").groups == []
    frame = lives(rmax_memory=0.1)
    alone = summary.Means(frame[frame["method"] == "rmax_memory"], HOW)
    made = page.answers(alone, page.looks_of(STUDY, ["rmax_memory"]), FAMILIES)
    assert not any(answer["lead"] or answer["lines"] for answer in made)
