"""Skill selection against values worked out by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ptl.agent._selection import SkillSelection
from ptl.agent.selection import prior

CELLS = np.array([(0, 0), (0, 4), (3, 0)])


def test_prior_by_hand():
    # Goal at (0, 0), L = 10, sigma = 0.1: distances 0, 4 and 3 in units of 1 cell.
    weights = np.exp([0.0, -4.0, -3.0])
    np.testing.assert_allclose(prior(CELLS, [0, 1, 2], 0, 10.0, width=0.1), weights / weights.sum(), rtol=1e-14)
    gaussian = np.exp([0.0, -8.0, -4.5])
    made = prior(CELLS, [0, 1, 2], 0, 10.0, "gaussian", width=0.1)
    np.testing.assert_allclose(made, gaussian / gaussian.sum(), rtol=1e-14)
    np.testing.assert_allclose(prior(CELLS, [0, 1, 2], 0, 10.0, "uniform"), [1 / 3] * 3)
    # Twice the width halves the exponents.
    wide = np.exp([0.0, -2.0, -1.5])
    np.testing.assert_allclose(prior(CELLS, [0, 1, 2], 0, 10.0, width=0.2), wide / wide.sum(), rtol=1e-14)


def test_prior_survives_a_far_goal():
    far = prior(np.array([(0, 0), (10**6, 0)]), [1], 0, 1.0)
    np.testing.assert_array_equal(far, [1.0])


@pytest.mark.parametrize("form", ["exponential", "gaussian", "uniform"])
@pytest.mark.parametrize("width", [5e-324, 0.005, 1000.0])
@pytest.mark.parametrize("goal", [0, 1])
@pytest.mark.parametrize("null_skill", [True, False])
def test_selection_is_finite_at_every_setting(form, width, goal, null_skill):
    allowed = np.array([null_skill, True, True])
    selection = SkillSelection(prior(CELLS, [0, 1, 2], goal, 10.0, form, width, allowed), exponent=100.0)
    selection.record([2], 10**12)
    selection.record([1], 1)
    chances = selection.probabilities()
    assert np.isfinite(chances).all() and chances.sum() == pytest.approx(1)
    assert null_skill or chances[0] == 0


def test_an_excluded_candidate_does_not_count_as_the_nearest():
    # relative to the excluded one, on the goal itself, the others' weights would all vanish
    chances = prior(CELLS, [0, 1, 2], 0, 10.0, "gaussian", 0.005, np.array([False, True, True]))
    np.testing.assert_array_equal(chances, [0, 0, 1])


def test_of_equally_near_candidates_each_has_its_share_under_the_narrowest_prior():
    cells = np.array([(0, 0), (0, 4), (4, 0), (9, 9)])
    np.testing.assert_array_equal(prior(cells, [1, 2, 3], 0, 10.0, "gaussian", 5e-324), [0.5, 0.5, 0])


def test_a_prior_that_is_no_distribution_is_refused():
    for wrong in ([], [0.5, np.nan], [0.7, 0.7], [1.5, -0.5]):
        with pytest.raises(ValueError, match="prior"):
            SkillSelection(np.array(wrong))


def test_prior_refuses_an_unknown_form():
    with pytest.raises(ValueError, match="form"):
        prior(CELLS, [0], 0, 10.0, "cauchy")


def test_likelihood_by_hand():
    selection = SkillSelection(np.array([0.5, 0.3, 0.2]), exponent=2.0, weight=0.5)
    np.testing.assert_array_equal(selection.performance, [1, 1, 1])
    np.testing.assert_allclose(selection.probabilities(), [0.5, 0.3, 0.2])

    selection.record([0], 100)  # first use sets v_0 = 1/100; the unused skills take the best v so far
    np.testing.assert_allclose(selection.performance, [0.01, 0.01, 0.01])
    selection.record([1], 10)
    np.testing.assert_allclose(selection.performance, [0.01, 0.1, 0.1])
    selection.record([1], 20)  # half-way from 1/10 to 1/20
    np.testing.assert_allclose(selection.performance, [0.01, 0.075, 0.075])
    weights = np.array([0.5, 0.3, 0.2]) * np.array([0.01, 0.075, 0.075]) ** 2
    np.testing.assert_allclose(selection.probabilities(), weights / weights.sum(), rtol=1e-12)


def test_every_skill_used_is_updated_once():
    selection = SkillSelection(np.full(3, 1 / 3))
    selection.record([2, 1, 2], 50)
    selection.record([2, 2], 100)
    np.testing.assert_allclose(selection.performance, [0.02, 0.02, 0.015])


def test_draws_follow_the_probabilities():
    selection = SkillSelection(np.array([0.7, 0.2, 0.1]))
    random = np.random.default_rng(5)
    counts = np.bincount([selection.draw(random) for _ in range(20_000)], minlength=3)
    expected = np.array([0.7, 0.2, 0.1]) * 20_000
    assert ((counts - expected) ** 2 / expected).sum() < 13.8  # 0.1 % point of chi-square with 2 degrees


def test_a_skill_without_probability_is_never_drawn():
    selection = SkillSelection(np.array([0.0, 1.0]))
    random = np.random.default_rng(5)
    assert {selection.draw(random) for _ in range(200)} == {1}


@pytest.mark.parametrize("skills", [1, 2, 9, 40])
def test_draws_are_those_of_the_formulas(skills):
    random = np.random.default_rng(skills)
    chances = random.dirichlet(np.full(skills, 0.3))
    selection = SkillSelection(chances, exponent=1.7, weight=0.3)
    values: dict[int, float] = {}
    for _ in range(300):
        best = max(values.values(), default=1.0)
        weights = chances * np.array([values.get(skill, best) for skill in range(skills)]) ** 1.7
        np.testing.assert_allclose(selection.probabilities(), weights / weights.sum(), rtol=1e-12)

        share = random.random()
        drawn = selection.draw(SimpleNamespace(random=lambda share=share: share))
        assert drawn == (np.cumsum(weights / weights.sum()) <= share).sum()

        length = int(random.integers(1, 10**6))
        used = {drawn, int(random.integers(skills))}
        selection.record(list(used), length)
        for skill in used:
            values[skill] = values[skill] + 0.3 * (1 / length - values[skill]) if skill in values else 1 / length


def test_the_greatest_random_number_draws_the_last_skill():
    selection = SkillSelection(np.full(49, 1 / 49))
    assert selection.draw(SimpleNamespace(random=lambda: np.nextafter(1.0, 0.0))) == 48


@pytest.mark.parametrize("skill", [-1, 3])
def test_a_skill_that_is_not_there_is_refused(skill):
    with pytest.raises(IndexError, match=f"no skill {skill} among 3"):
        SkillSelection(np.full(3, 1 / 3)).record([skill], 10)


def test_another_prior_has_as_many_skills():
    selection = SkillSelection(np.full(3, 1 / 3))
    with pytest.raises(ValueError, match="3 skills cannot become one of 2"):
        selection.prior = np.full(2, 1 / 2)


def test_a_prior_changed_afterwards_does_not_reach_the_selection():
    chances = np.array([1.0, 0.0])
    selection = SkillSelection(chances)
    chances[:] = [0.0, 1.0]
    assert selection.prior.tolist() == [1.0, 0.0]
    assert selection.draw(np.random.default_rng(0)) == 0


def test_a_selection_that_was_not_made_is_refused():
    class Forgetful(SkillSelection):
        def __init__(self):
            pass

    with pytest.raises(AttributeError, match="not initialized"):
        Forgetful().draw(np.random.default_rng(0))
    with pytest.raises(AttributeError, match="not initialized"):
        Forgetful().record([0], 10)
