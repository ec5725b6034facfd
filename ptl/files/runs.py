"""Runs that other programs have logged, turned into the table that `ptl.files.foreign` reads.

Each format has one function, which returns the episodes of a file in order. The rules that hold for all of them: what a
file does not say (environment, method, task) the caller says; without a column of seeds a file is a seed; seeds are
numbered in the natural order of their names within a task; all runs are cut to the length of the shortest one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.files.foreign import (
    COLUMNS,
    MAX_BYTES,
    OPTIONAL,
    as_text,
    natural,
    numbers_of_seeds,
    read_cells,
    whole_number,
)
from ptl.files.regular import NotReadable, read_bytes
from ptl.keys import repeated, shortened

TOTAL = "total_steps"
"""Column of the steps of a run until the end of an episode, for files that have these instead of each episode's."""

LENGTH = re.compile(r"ep(isod\w*)?[_ ]?len(gth)?", re.IGNORECASE)
"""Names that loggers give to the length of an episode: episode_len_mean, ep_len_mean, eplenmean, episodic_length."""


@dataclass
class Imported:
    """The table, and what was decided on the way (a sentence each)."""

    table: pd.DataFrame
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Source:
    """A file or folder with runs; ``task`` is empty if a column has it."""

    path: Path
    task: str = ""


def import_runs(
    sources: Iterable[Source],
    *,
    given: Mapping[str, str],
    columns: Mapping[str, str],
    episodes: int | None = None,
    max_steps: int | None = None,
) -> Imported:
    """Read runs and return them as one table.

    Parameters
    ----------
    given : mapping
        Environment, method and task of runs that do not say them.
    columns : mapping
        Columns of tables by what they mean: our name to theirs.
    episodes : int, optional
        Episodes of each run; by default as many as the shortest run has.
    max_steps : int, optional
        Episodes of this length were cut off.

    Raises
    ------
    UserError
        Naming the file and what is missing or unclear.
    """
    notes: list[str] = []
    remarked: dict[str, list[Path]] = {}
    parts = []
    for source in sources:
        for name, path, frame, remarks in _runs_of(source.path, columns):
            frame = frame.rename(columns={theirs: ours for ours, theirs in columns.items()})
            known = {**given, **({"task": source.task} if source.task else {})}
            parts.append(_tidied(frame, path, name, known))
            for remark in remarks:
                remarked.setdefault(remark, []).append(path)
    for remark, paths in remarked.items():
        notes.append(f"{paths[0]}{f' and {len(paths) - 1} more' if len(paths) > 1 else ''}: {remark}")
    table = pd.concat(parts, ignore_index=True)
    table = _with_numbers_of_seeds(table, notes)
    table = _cut(table, episodes, notes)
    if max_steps is not None:
        over = table["steps"] > max_steps
        if over.any():
            raise UserError(f"--max-steps: {max_steps} is less than an episode of {table['steps'].max()} steps")
        table[OPTIONAL] = table[OPTIONAL] | (table["steps"] == max_steps)
    elif not table[OPTIONAL].any():
        notes.append("no episode counts as cut off; give --max-steps if episodes had a limit")
    table[OPTIONAL] = table[OPTIONAL].astype(int)
    return Imported(table[[*COLUMNS, OPTIONAL]], notes)


# -- files --------------------------------------------------------------------------------------------------------

Run = tuple[str, Path, pd.DataFrame, list[str]]
"""Name of a seed, file, episodes, and remarks on how they were read."""


def _runs_of(path: Path, columns: Mapping[str, str]) -> Iterator[Run]:
    """Yield the runs in a file or folder; a folder is searched for monitor files, progress.csv or other CSV files."""
    if not path.is_dir():
        yield path.stem.removesuffix(".monitor"), path, *_read(path, columns)
        return
    kinds = ("*monitor.csv", "progress.csv", "*.csv")
    files: list[Path] = next(filter(None, (sorted(path.rglob(kind), key=natural) for kind in kinds)), [])
    if not files:
        events = " but event files of TensorBoard; export a scalar as CSV" if any(path.rglob("*tfevents*")) else ""
        raise UserError(f"{path}: has no CSV file{events or '; name a folder of monitor.csv, progress.csv or exports'}")
    for folder in dict.fromkeys(file.parent for file in files):
        here = [file for file in files if file.parent == folder]
        name = folder.relative_to(path).as_posix() if folder != path else path.name
        workers = [file for file in here if re.fullmatch(r"[0-9.]*\.monitor\.csv", file.name)]
        if len(workers) > 1:  # parallel environments of one run: 0.monitor.csv, 1.monitor.csv, ...
            frames = [_monitor(_text(file), file)[0] for file in workers]
            merged = pd.concat(frames).sort_values("ended", kind="stable")
            yield name, folder, merged, [f"{len(workers)} parallel environments of one run, by the end of the episode"]
            here = [file for file in here if file not in workers]
        for file in here:
            alone = file.name in ("monitor.csv", "progress.csv") or len(here) == 1
            own = file.name.removesuffix(".csv").removesuffix(".monitor")
            yield name if alone and folder != path else own, file, *_read(file, columns)


def _text(path: Path) -> str:
    try:
        return read_bytes(path, MAX_BYTES).decode("utf-8-sig")
    except NotReadable as error:
        raise UserError(f"{path}: cannot be read ({error.reason}); give a CSV file or a folder of them") from error
    except UnicodeDecodeError as error:
        what = f"byte {error.start + 1} is not UTF-8 text; save it as UTF-8"
        if "tfevents" in path.name:
            what = "is an event file of TensorBoard; export a scalar as CSV"
        raise UserError(f"{path}: {what}") from error


def _read(path: Path, columns: Mapping[str, str]) -> tuple[pd.DataFrame, list[str]]:
    """Read a file in the format that its name or its header shows."""
    text = _text(path)
    if path.name.endswith("monitor.csv") or re.match(r'\s*#\s*\{|"?r"?,"?l"?,"?t', text):
        return _monitor(text, path)
    frame = _table(path)
    names = list(frame)
    if set(columns.values()) & set(names):
        return frame, []
    if names == ["Wall time", "Step", "Value"]:
        return _tensorboard(frame, path)
    if any(" - " in name for name in names):
        return _wandb(frame, path)
    if {"episode", "episode_len", "steps"} <= set(names):
        return _bsuite(frame, path)
    if "steps" not in names and (_means(names) or _single(names)):
        return _progress(frame, path)
    return frame, []


def _table(path: Path) -> pd.DataFrame:
    """Return the cells of a table as texts, our columns in lower case.

    A column without a name, such as pandas' index, is left out.
    """
    cells = read_cells(path)
    ours = (*COLUMNS, OPTIONAL, TOTAL)
    header = [name.strip().lower() if name.strip().lower() in ours else name.strip() for name in cells.iloc[0]]
    kept = [name for name in header if name and not name.startswith("Unnamed: ")]
    if twice := repeated(kept):
        raise UserError(f"{path}: has two columns {twice[0]}; rename one of them")
    return cells.iloc[1:].set_axis(header, axis="columns")[kept]


# -- formats ------------------------------------------------------------------------------------------------------


def _monitor(text: str, path: Path) -> tuple[pd.DataFrame, list[str]]:
    """Read monitor.csv of Stable-Baselines3, Stable-Baselines or Baselines: reward, length and time of each episode.

    Its header is a comment in JSON and the line ``r,l,t``, with further columns. Either may be missing, repeated (runs
    that were continued) or run into the next line (Baselines issue 774, Stable-Baselines3 issue 2282).
    """
    rows: list[tuple[str, float, str]] = []
    names, began, dropped, headers = ["r", "l", "t"], 0.0, 0, 0
    cut = "TimeLimit.truncated"  # a column that users ask Stable-Baselines3 for
    lines = text.replace("\r\n", "\n").split("\n")
    for number, line in enumerate(lines, start=1):
        rest = line.strip()
        if comment := re.match(r"#\s*(\{.*\})?", rest):
            started = re.search(r'"t_start":\s*([0-9.]+)', comment[0])
            began = float(started[1]) if started else began
            rest = rest[comment.end() :].strip()
        if header := re.match(r'"?(?:r"?,"?l"?,"?t|l"?,"?r"?,"?t)"?((?:,"?[A-Za-z_][\w./]*"?)*)', rest):
            names = header[0].replace('"', "").split(",")
            headers += 1
            rest = rest[header.end() :].strip()
        if not rest:
            continue
        cells = [cell.strip() for cell in rest.split(",")]
        cells += [""] * (len(names) - len(cells))
        length, ended = cells[names.index("l")], cells[names.index("t")]
        if not whole_number(length) or not re.fullmatch(r"[0-9.]+([eE][-+]?[0-9]+)?", ended):
            if "".join(lines[number:]).strip():
                raise UserError(f"{path}: line {number}: {shortened(rest)!r} is no episode; give reward, length, time")
            dropped += 1
            continue
        rows.append((length, began + float(ended), cells[names.index(cut)] if cut in names else "0"))
    remarks = ["its last line, which is not whole, is left out"] * dropped
    remarks += ["it has no header: the columns are taken for reward, length and time"] * (headers == 0)
    return pd.DataFrame(rows, columns=["steps", "ended", OPTIONAL]), remarks


def _progress(frame: pd.DataFrame, path: Path) -> tuple[pd.DataFrame, list[str]]:
    """Read progress.csv of RLlib, Stable-Baselines3 or Baselines: a row for each iteration of training.

    RLlib's ``hist_stats/episode_lengths`` ends in the lengths of the iteration's episodes; other files have means only.
    """
    if single := _single(list(frame)):
        lengths: list[str] = []
        for cell, number in zip(frame[single[0]], frame[single[1]], strict=True):
            newest = int(whole_number(number)) if whole_number(number) else 0
            lengths += re.findall("[0-9]+", cell)[-newest:] if newest else []
        return pd.DataFrame({"steps": lengths}, dtype=str), []
    names = _means(list(frame))
    found = frame[names].replace(["", "nan", "NaN"], np.nan).bfill(axis=1).iloc[:, 0].dropna()
    return (
        pd.DataFrame({"steps": _rounded(found, names[0], path)}),
        [f"column {names[0]} has means over the episodes of an iteration: {AS_ONE}"],
    )


def _single(names: Sequence[str]) -> list[str]:
    """Return the columns with the lengths of single episodes and with their number, if there are both."""
    ends = ("hist_stats/episode_lengths", "episodes_this_iter")
    found = [next((name for name in names if name.endswith(end)), "") for end in ends]
    return found if all(found) else []


def _means(names: Sequence[str]) -> list[str]:
    """Return the columns with mean lengths: those of evaluation, between the episodes of learning, only if alone."""
    means = [name for name in names if LENGTH.search(name) and "mean" in name]
    return [name for name in means if "eval" not in name] or means


AS_ONE = "an iteration counts as one episode, its mean rounded to whole steps"


def _rounded(means: pd.Series, name: str, path: Path) -> pd.Series:
    """Return means of lengths as whole numbers."""
    numbers = pd.to_numeric(means, errors="coerce")
    if numbers.isna().any():
        raise UserError(
            f"{path}: {name} {shortened(means[numbers.isna()].iloc[0])!r} is not a number with a decimal point"
        )
    return numbers.round().astype(int).astype(str)


def _tensorboard(frame: pd.DataFrame, path: Path) -> tuple[pd.DataFrame, list[str]]:
    """Read a scalar that TensorBoard exported: the length of an episode, or what it returned at which step."""
    total = pd.to_numeric(frame["Step"], errors="coerce")
    value = pd.to_numeric(frame["Value"], errors="coerce")
    apart = total.diff().fillna(total)
    if LENGTH.search(path.name) and "mean" in path.name:
        return pd.DataFrame({"steps": _rounded(frame["Value"], "Value", path)}), [f"Value has means: {AS_ONE}"]
    if LENGTH.search(path.name) or (len(frame) > 1 and (value == apart).all()):
        return frame[["Value"]].rename(columns={"Value": "steps"}), ["Value is taken for the length of an episode"]
    if re.search("return|reward|rew_", path.name, re.IGNORECASE):
        return frame[["Step"]].rename(columns={"Step": TOTAL}), ["Step is taken for the end of an episode"]
    raise UserError(
        f"{path}: does not say whether Value is the length of an episode; give --columns steps=Value, or"
        f" --columns {TOTAL}=Step if every row is the end of an episode"
    )


def _wandb(frame: pd.DataFrame, path: Path) -> tuple[pd.DataFrame, list[str]]:
    """Read a chart that Weights & Biases exported, with a column for each run (also of CleanRL): "run - metric"."""
    names = [name for name in frame if LENGTH.search(name.rpartition(" - ")[2]) and not re.search("__M(IN|AX)$", name)]
    if not names:
        raise UserError(
            f"{path}: has no column with the length of an episode; export such a chart (charts/episodic_length)"
        )
    runs, mixed, rounded = [], 0, False
    for name in names:
        row = frame[frame[name] != ""]
        if "mean" in name.rpartition(" - ")[2]:
            rounded = True
            row = row.assign(**{name: _rounded(row[name], name, path)})
        if {f"{name}__MIN", f"{name}__MAX"} <= set(frame):
            mixed += int((row[f"{name}__MIN"] != row[f"{name}__MAX"]).sum())
        runs.append(pd.DataFrame({"seed": name.rpartition(" - ")[0], "steps": row[name]}))
    remark = f"{mixed} rows are means of several episodes; export the chart without sampling"
    return pd.concat(runs), [remark] * bool(mixed) + [f"the chart has means: {AS_ONE}"] * rounded


def _bsuite(frame: pd.DataFrame, path: Path) -> tuple[pd.DataFrame, list[str]]:
    """Read a CSV log of bsuite, whose ``steps`` is a running total; later episodes are logged in samples only."""
    return frame[["episode", "episode_len"]].rename(columns={"episode_len": "steps"}), []


# -- one table ----------------------------------------------------------------------------------------------------


def _tidied(frame: pd.DataFrame, path: Path, name: str, given: Mapping[str, str]) -> pd.DataFrame:
    """Return the columns of the table with names of seeds, and episodes counted from 1."""
    if frame.empty:
        raise UserError(f"{path}: has no episode; leave it out or let it run longer")
    theirs = list(map(str, frame))
    frame = frame.reset_index(drop=True)
    frame = frame.assign(**{key: value for key, value in given.items() if key not in frame})
    if "seed" not in frame:
        frame = frame.assign(seed=name)
    names = ("environment", "method", "task", "seed")
    if missing := [key for key in names if key not in frame]:
        ways = " and ".join(f"--{key} or --columns {key}=THEIRS" for key in missing)
        raise UserError(f"{path}: does not say the {' and '.join(missing)} of its runs; give {ways}")
    frame = frame.assign(**{key: frame[key].map(str) for key in names})
    runs = frame.groupby(list(names), sort=False)
    if "steps" not in frame and TOTAL in frame:
        total = _whole(frame, TOTAL, path)
        frame = frame.assign(steps=(total - total.groupby([frame[key] for key in names]).shift(fill_value=0)).map(str))
    if "steps" not in frame:
        raise UserError(
            f"{path}: has no column of steps among {shortened(', '.join(theirs), 200)}; give --columns"
            f" steps=THEIRS, or {TOTAL}=THEIRS for running totals"
        )
    episode = _whole(frame, "episode", path) if "episode" in frame else runs.cumcount() + 1
    first = episode.groupby([frame[key] for key in names]).transform("min")
    return pd.DataFrame(
        {key: frame[key] for key in names}
        | {"episode": episode - first + 1, "steps": _whole(frame, "steps", path)}
        | {OPTIONAL: _whole(frame, OPTIONAL, path) > 0 if OPTIONAL in frame else False}
    )


def _whole(frame: pd.DataFrame, column: str, path: Path) -> pd.Series:
    """Return a column as whole numbers; 40.0, True and numpy's np.int64(40) are some."""
    numbers = frame[column].map(whole_number)
    if (numbers == "").any():
        row = int((numbers == "").to_numpy().argmax())
        raise UserError(
            f"{path}: row {row + 1}: {column} {shortened(as_text(frame[column].iloc[row]))!r} is not allowed; give a"
            " whole number"
        )
    return numbers.astype(np.int64)


def _with_numbers_of_seeds(table: pd.DataFrame, notes: list[str]) -> pd.DataFrame:
    """Number the seeds of each task in the natural order of their names."""
    mappings: dict[str, dict[str, int]] = {}
    numbered = pd.Series(0, index=table.index)
    for (environment, method, task), part in table.groupby(["environment", "method", "task"], sort=False):
        mapping = numbers_of_seeds(part["seed"])
        mappings[f"task {task} of {environment} ({method})"] = mapping
        numbered[part.index] = part["seed"].map(mapping)
    sizes = {place: len(mapping) for place, mapping in mappings.items()}
    if len({*sizes.values()}) > 1:
        counts = ", ".join(f"{size} in {place}" for place, size in sizes.items())
        raise UserError(f"the number of seeds differs: {shortened(counts, 300)}; give every task the same seeds")
    for pairs in dict.fromkeys(tuple(mapping.items()) for mapping in mappings.values()):
        if any(name != str(number) for name, number in pairs):
            shown = ", ".join(f"{name} is {number}" for name, number in pairs)
            notes.append(f"seeds are numbered: {shortened(shown, 400)}")
    return table.assign(seed=numbered)


def _cut(table: pd.DataFrame, wanted: int | None, notes: list[str]) -> pd.DataFrame:
    """Cut all runs to one length: that asked for, or that of the shortest run up to its first missing episode."""
    keys = ["environment", "method", "task", "seed"]
    if (twice := table.duplicated([*keys, "episode"])).any():
        row = table[twice].iloc[0]
        place = f"episode {row['episode']} of seed {row['seed']}, task {row['task']} of {row['environment']}"
        raise UserError(f"{place} is given twice; name each run once, or its seed with --columns seed=THEIRS")
    table = table.sort_values([*keys, "episode"], kind="stable", ignore_index=True)
    whole = table[table["episode"] == table.groupby(keys).cumcount() + 1]
    lengths = whole.groupby(keys).size()
    place = " ".join(f"{key} {value}" for key, value in zip(keys, lengths.idxmin(), strict=True))
    shortest = int(lengths.min())
    if wanted is not None and shortest < wanted:
        raise UserError(
            f"--episodes: {wanted} is more than the {shortest} of {place}; ask for fewer or leave the run out"
        )
    kept = whole[whole["episode"] <= (wanted or shortest)]
    if len(kept) < len(table):
        left = len(table) - len(kept)
        rule = "as asked for" if wanted else f"the length of the shortest ({place}) up to its first missing episode"
        notes.append(
            f"all runs are cut to {wanted or shortest} episodes, {rule}: {left} of {len(table)} episodes are left out"
        )
    return kept


def parsed_columns(given: Sequence[str]) -> dict[str, str]:
    """Return the columns that ``ours=theirs`` texts name.

    Raises
    ------
    UserError
        For another text, and for a column that the table does not have.
    """
    known = (*COLUMNS, OPTIONAL, TOTAL)
    pairs = [part.strip().partition("=") for text in given for part in text.split(",")]
    for ours, equals, theirs in pairs:
        if ours not in known or not equals or not theirs:
            raise UserError(f"--columns: {ours + equals + theirs!r:.60} is not allowed; give OURS=THEIRS, ours one of"
                            f" {', '.join(known)}")  # fmt: skip
    return {ours: theirs for ours, _, theirs in pairs}
