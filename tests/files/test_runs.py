"""Runs as other programs log them become a table that a study reads."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from ptl.cli import commands
from ptl.errors import UserError
from ptl.files.foreign import Expected, read_foreign
from ptl.files.runs import Imported, Source, import_runs, parsed_columns
from ptl.world.gridworld import GridWorld

GIVEN = {"environment": "hall", "method": "agent", "task": "A"}
HEADER = '#{"t_start": 100.5, "env_id": "Hall-v0"}\n'


def imported(*sources: Path | str, columns: str = "", **options: object) -> Imported:
    chosen = [source if isinstance(source, Source) else Source(Path(source)) for source in sources]
    return import_runs(
        chosen, given=options.pop("given", GIVEN), columns=parsed_columns([columns] if columns else []), **options
    )


def steps(result: Imported) -> list[list[int]]:
    """Steps of each seed, in the order of environment, task and seed."""
    return [part["steps"].tolist() for _, part in result.table.groupby(["environment", "task", "seed"])]


def refusal(*arguments: object, **options: object) -> str:
    with pytest.raises(UserError) as caught:
        imported(*arguments, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


# -- monitor.csv


@pytest.mark.parametrize(
    "text",
    [
        HEADER + "r,l,t\n1.0,40,0.5\n0.0,33,0.9\n",
        HEADER + "r,l,t,is_success,a.b\n1.0,40,0.5,True,1\n0.0,33,0.9,False,2\n",
        HEADER.replace("#", "# ") + "r,l,t\r\n1.0,40,0.5\r\n0.0,33,0.9\r\n",
        "r,l,t\n1.0,40,0.5\n0.0,33,0.9\n",
        "1.0,40,0.5\n0.0,33,0.9\n",
        HEADER + "r,l,t1.0,40,0.5\n0.0,33,0.9\n",
        HEADER + "r,l,t-1.0,40,0.5\n0.0,33,0.9\n",
        HEADER.strip() + "r,l,t\n1.0,40,0.5\n0.0,33,0.9\n",
        HEADER + "r,l,t\n1.0,40,0.5\n" + HEADER + "r,l,t\n0.0,33,0.9\n",
        HEADER + "l,r,t\n40,1.0,0.5\n33,0.0,0.9\n",
        HEADER + "r,l,t\n1.0,40,0.5\n0.0,33,0.9\n1.0,2",
        "\ufeff" + HEADER + "r,l,t\n1.0,40.0,0.5\n0.0,33.0,9e-1\n",
    ],
    ids=["whole", "more columns", "Windows", "no comment", "no header", "header in a row", "header in a negative row",
         "comment in the header", "continued", "another order", "cut short", "byte order mark"],
)  # fmt: skip
def test_monitor_files_are_read_whatever_became_of_their_header(tmp_path, text):
    result = imported(written(tmp_path / "monitor.csv", text))
    assert steps(result) == [[40, 33]] and result.table["episode"].tolist() == [1, 2]
    assert any("last line" in note for note in result.notes) == text.endswith("1.0,2")


def test_a_line_that_is_no_episode_is_refused_unless_it_is_the_last(tmp_path):
    path = written(tmp_path / "monitor.csv", "r,l,t\n1.0,40,0.5\n1.0,x,0.6\n1.0,33,0.9\n")
    assert refusal(path).endswith("line 3: '1.0,x,0.6' is no episode; give reward, length, time")


def test_monitor_files_may_say_which_episodes_were_cut_off(tmp_path):
    text = HEADER + 'r,l,t,"TimeLimit.truncated"\n1.0,40,0.5,False\n0.0,50,0.9,True\n'
    assert imported(written(tmp_path / "monitor.csv", text)).table["truncated"].tolist() == [0, 1]


@pytest.mark.parametrize(
    "text",
    [
        "evaluation/episode_len_mean,episode_len_mean,training_iteration\n99,40,1\n98,33.2,2\n",
        "evaluation/episode_len_mean,episode_len_mean,training_iteration\n,40,1\n98,33.2,2\n",
        "env_runners/episode_len_mean,evaluation/env_runners/episode_len_mean\n,7\n40,99\nnan,98\n33.2,97\n",
        'episodes_this_iter,sampler_results/hist_stats/episode_lengths\n1,"[9, 40]"\n1,"[9, 40, 33]"\n',
        "rollout/ep_len_mean,eval/mean_ep_length\n40,99\n33.2,98\n",
        '"Step","a - rollout/ep_len_mean"\n"1","40"\n"2","33.2"\n',
    ],
)
def test_lengths_are_those_of_learning_whatever_stands_beside_them(tmp_path, text):
    assert steps(imported(written(tmp_path / "x.csv", text))) == [[40, 33]]


def test_means_that_are_no_numbers_are_refused(tmp_path):
    path = written(tmp_path / "progress.csv", 'episode_len_mean,training_iteration\n40.5,1\n"33,2",2\n')
    assert "episode_len_mean '33,2' is not a number with a decimal point" in refusal(path)


def test_each_folder_with_a_monitor_file_is_a_seed(tmp_path):
    for seed, length in (("seed_10", 12), ("seed_9", 11)):
        written(tmp_path / f"runs/{seed}/monitor.csv", f"{HEADER}r,l,t\n1.0,{length},0.5\n")
    result = imported(tmp_path / "runs")
    assert steps(result) == [[11], [12]]
    assert "seeds are numbered: seed_9 is 0, seed_10 is 1" in result.notes


def test_files_that_are_called_after_their_seed_are_seeds_and_numbered_workers_are_one_run(tmp_path):
    for name, began, length in (("a", 0, 11), ("b", 0, 12)):
        written(tmp_path / f"seeds/{name}.monitor.csv", f'#{{"t_start": {began}}}\nr,l,t\n1.0,{length},0.5\n')
    assert steps(imported(tmp_path / "seeds")) == [[11], [12]]
    for name, began, length in (("0", 5, 11), ("1", 0, 12), ("0.1", 3, 13)):
        written(tmp_path / f"one/{name}.monitor.csv", f'#{{"t_start": {began}}}\nr,l,t\n1.0,{length},0.5\n')
    result = imported(tmp_path / "one")
    assert steps(result) == [[12, 13, 11]] and any(
        "3 parallel environments of one run" in note for note in result.notes
    )


# -- other programs


def test_progress_of_rllib_gives_episodes_where_it_has_them_and_iterations_otherwise(tmp_path):
    means = "episode_len_mean,training_iteration\n,1\n52.4,2\n40.0,3\n"
    result = imported(written(tmp_path / "a/progress.csv", means))
    assert steps(result) == [[52, 40]] and "an iteration counts as one episode" in result.notes[0]
    new = "training_iteration,env_runners/episode_len_mean\n1,7\n2,6\n"
    assert steps(imported(written(tmp_path / "b/progress.csv", new))) == [[7, 6]]
    header = "episode_len_mean,episodes_this_iter,hist_stats/episode_lengths"
    whole = f'{header}\n9,2,"[8, 10]"\n9,0,"[8, 10]"\n8,1,"[8, 10, 6]"\n'
    assert steps(imported(written(tmp_path / "c/progress.csv", whole))) == [[8, 10, 6]]


def test_exports_of_tensorboard_say_what_a_value_is_by_name_or_number(tmp_path):
    scalars = "Wall time,Step,Value\n1.5,40,1.0\n2.5,73,1.0\n"
    lengths = "Wall time,Step,Value\n1.5,40,40.0\n2.5,73,33.0\n"
    assert "give --columns steps=Value, or --columns total_steps=Step" in refusal(written(tmp_path / "x.csv", scalars))
    for name, text, columns in (("run-1-tag-charts_episodic_return.csv", scalars, ""), ("x.csv", lengths, ""),
                                ("run-1-tag-charts_episodic_length.csv", lengths, ""),
                                ("x.csv", scalars, "total_steps=Step"), ("x.csv", lengths, "steps=Value")):  # fmt: skip
        assert steps(imported(written(tmp_path / name, text), columns=columns)) == [[40, 33]]


def test_exports_of_weights_and_biases_have_a_column_for_each_run(tmp_path):
    path = written(
        tmp_path / "wandb.csv",
        '"global_step","hall__q__1 - charts/episodic_length","hall__q__1 - charts/episodic_length__MIN",'
        '"hall__q__1 - charts/episodic_length__MAX","hall__q__2 - charts/episodic_length"\n'
        '"40","40","40","40",""\n"73","33","30","36","31"\n"90","","","","32"\n',
    )
    result = imported(path)
    assert steps(result) == [[40, 33], [31, 32]]
    assert any("1 rows are means of several episodes" in note for note in result.notes)
    returns = written(tmp_path / "r.csv", '"Step","a - charts/episodic_return"\n"1","2"\n')
    assert "has no column with the length of an episode" in refusal(returns)


def test_logs_of_bsuite_end_where_episodes_begin_to_be_left_out(tmp_path):
    text = "steps,episode,total_return,episode_len,episode_return\n40,1,1,40,1\n73,2,2,33,1\n200,5,4,30,1\n"
    result = imported(written(tmp_path / "bsuite_id_-_deep_sea-0.csv", text))
    assert steps(result) == [[40, 33]]
    [note] = [note for note in result.notes if note.startswith("all runs are cut to 2 episodes, the length of the")]
    assert note.endswith("up to its first missing episode: 1 of 3 episodes are left out")


def test_tables_with_other_names_numbers_and_separators(tmp_path):
    frame = pd.DataFrame({"world": "hall", "algo": "agent", "goal": "A", "run": [42, 42, 43, 43], "i": [0, 1, 0, 1],
                          "length": [40.0, 33.0, 12.0, 11.0], "cut": [False, True, False, False]})  # fmt: skip
    names = "environment=world,method=algo,task=goal,seed=run,episode=i,steps=length,truncated=cut"
    for options in ({}, {"sep": ";"}, {"sep": "\t", "encoding": "utf-8-sig", "lineterminator": "\r\n"}):
        frame.to_csv(tmp_path / "t.csv", **options)
        result = imported(tmp_path / "t.csv", given={}, columns=names)
        assert steps(result) == [[40, 33], [12, 11]] and result.table["truncated"].tolist() == [0, 1, 0, 0]
        assert result.table["episode"].tolist() == [1, 2, 1, 2]
        assert "seeds are numbered: 42 is 0, 43 is 1" in result.notes
    assert "--columns steps=THEIRS" in refusal(tmp_path / "t.csv")
    assert "does not say the task of its runs; give --task or" in refusal(
        tmp_path / "t.csv", given={"environment": "hall", "method": "agent"}, columns="steps=length"
    )


@pytest.mark.parametrize(
    "text",
    [
        "sep=;\r\nseed;episode;steps\r\n0;1;40,0\r\n0;2;33\r\n",
        "Seed, Episode, Steps\n 0, 1, 40\n 0, 2, 33\n",
        "Seed\tEpisode\tTotal_Steps\n0\t1\t40\n0\t2\t73\n",
    ],
)
def test_tables_as_spreadsheets_and_people_write_them(tmp_path, text):
    result = imported(written(tmp_path / "t.csv", text))
    assert steps(result) == [[40, 33]] and not any("numbered" in note for note in result.notes)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("seed;episode;steps\n0;1;40\n0;2;1.000\n", "row 2: steps '1.000' is not allowed"),
        ('seed,episode,steps\n0,1,"1,000"\n', "row 1: steps '1,000' is not allowed"),
        ("seed,episode,steps\n0,1,40,5\n0,2,33,0\n", "Expected 3 fields in line 2, saw 4"),
        ("seed,episode,steps,steps\n0,1,40,5\n", "has two columns steps; rename one of them"),
        ("<!DOCTYPE html><html>404</html>\n", "is HTML or XML; give a CSV table"),
        ('{"a": 1}\n', "is JSON; give a CSV table"),
        ("Episode,Length\n1,40\n", "has no column of steps among episode, Length; give"),
    ],
)
def test_tables_that_would_be_misread_are_refused(tmp_path, text, says):
    assert says in refusal(written(tmp_path / "t.csv", text))


def test_numbers_as_numpy_shows_them(tmp_path):
    path = written(tmp_path / "t.csv", "seed,episode,steps\n0,1,np.int64(40)\n0,2,33.0\n")
    assert steps(imported(path)) == [[40, 33]]
    written(path, "seed,episode,steps\n0,1,40\n0,2,33.5\n")
    assert refusal(path).endswith("row 2: steps '33.5' is not allowed; give a whole number")


# -- rules for all


def runs_of(folder: Path, **lengths: list[int]) -> Path:
    for seed, episodes in lengths.items():
        rows = "".join(f"1.0,{length},0.5\n" for length in episodes)
        written(folder / seed / "monitor.csv", f"{HEADER}r,l,t\n{rows}")
    return folder


def test_runs_of_unequal_length_are_cut_by_a_rule_that_is_said(tmp_path):
    folder = runs_of(tmp_path / "runs", a=[9, 8, 7], b=[6, 5])
    result = imported(folder)
    assert steps(result) == [[9, 8], [6, 5]]
    rule = "the length of the shortest (environment hall method agent task A seed 1) up to its first missing episode"
    assert f"all runs are cut to 2 episodes, {rule}: 1 of 5 episodes are left out" in result.notes
    assert steps(imported(folder, episodes=1)) == [[9], [6]]
    assert "--episodes: 3 is more than the 2 of environment hall" in refusal(folder, episodes=3)


def test_tasks_are_named_with_their_folders_and_need_equal_seeds(tmp_path):
    first, second = runs_of(tmp_path / "x", a=[9], b=[8]), runs_of(tmp_path / "y", c=[7], d=[6])
    result = imported(Source(first, "B"), Source(second, "A"), given={"environment": "hall", "method": "agent"})
    assert steps(result) == [[7], [6], [9], [8]]
    runs_of(tmp_path / "y", e=[5])
    assert "the number of seeds differs: 2 in task B of hall (agent), 3 in task A" in refusal(
        Source(first, "B"), Source(second, "A"), given={"environment": "hall", "method": "agent"}
    )


def test_episodes_at_the_limit_were_cut_off(tmp_path):
    folder = runs_of(tmp_path / "runs", a=[9, 50], b=[50, 5])
    result = imported(folder, max_steps=50)
    assert result.table["truncated"].tolist() == [0, 1, 1, 0]
    assert any("give --max-steps" in note for note in imported(folder).notes)
    assert "--max-steps: 49 is less than an episode of 50 steps" in refusal(folder, max_steps=49)


def test_what_cannot_be_read_is_named(tmp_path):
    (tmp_path / "empty").mkdir()
    assert "has no CSV file; name a folder of monitor.csv" in refusal(tmp_path / "empty")
    events = written(tmp_path / "empty/events.out.tfevents.1", "")
    assert "event files of TensorBoard; export a scalar as CSV" in refusal(tmp_path / "empty")
    events.write_bytes(b"\xff\xfe")
    (tmp_path / "latin.csv").write_bytes(b"seed,steps\nag\xe9nt,1\n")
    assert refusal(tmp_path / "latin.csv").endswith("byte 14 is not UTF-8 text; save it as UTF-8")
    assert refusal(events).endswith("is an event file of TensorBoard; export a scalar as CSV")
    assert "cannot be read (No such file" in refusal(tmp_path / "none.csv")
    assert refusal(written(tmp_path / "monitor.csv", HEADER + "r,l,t\n")).endswith("let it run longer")
    for wrong in ("l", "=l", "length=l", "steps="):
        with pytest.raises(UserError, match=r"--columns: .* is not allowed; give OURS=THEIRS"):
            parsed_columns([wrong])


def test_the_command_writes_a_table_that_a_study_reads(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for task in "AB":
        runs_of(Path(task.lower()), seed_1=[30, 20, 10], seed_2=[31, 21, 11])
    done = CliRunner().invoke(commands, ["import-runs", "A=a", "B=b", "--environment", "hall", "--method", "agent"])
    assert done.exception is None
    assert "agent.csv: written, 2 seeds, 3 episodes of A in hall, B in hall" in done.output
    assert re.search(r"foreign_results:\n  agent: \{file: agent.csv\}\n", done.output)
    world = GridWorld.from_text("I...A\n....B\n")
    found = read_foreign("agent.csv", "agent", Expected({"hall": world}, {"hall": "AB"}, 2, 3, 1000))
    assert np.array_equal(found["hall", "B"].steps, [[30, 20, 10], [31, 21, 11]])
