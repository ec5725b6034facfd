"""From estimates to tables 1-6: one model of a table, and a small writer for each format.

Each environment has two tables, as in the article: jump start, asymptotic performance and time to threshold;
total performance and transfer ratio. Mean and standard deviation are the article's form; the interval of the
mean and the probability of improvement beside them are ours.
"""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from ptl.errors import UserError
from ptl.files import write_csv, write_text
from ptl.statistics import Better

DASH = "–"
MINUS = "−"
NOT_REACHED = "not reached"


@dataclass(frozen=True)
class Settings:
    """Parameters behind the numbers, for the text under a table."""

    window: int
    threshold_factor: float
    confidence: float
    resamples: int
    base: str = "no_transfer"


@dataclass(frozen=True)
class Column:
    """One measure of a table.

    Attributes
    ----------
    key : str
        Metric in the metrics table.
    heading, unit : str
    better : "lower" or "higher"
    format : function
        Number to text; it must not turn the order of two numbers round.
    against_base : bool
        Whether the measure is a comparison with the base, for which it is 0 by definition.
    with_share, with_improvement : bool
        Whether a column with the share of seeds that reached the threshold, or with the probability of
        improvement over the base, follows.
    """

    key: str
    heading: str
    unit: str
    better: Better
    format: Callable[[float], str]
    with_share: bool = False
    with_improvement: bool = False
    against_base: bool = False

    @property
    def width(self) -> int:
        """Number of columns on the page."""
        return 1 + self.with_share + self.with_improvement


@dataclass(frozen=True)
class Cell:
    """One measure of one method: the texts a reader sees and the numbers behind them."""

    text: str
    interval: str
    share: str
    improvement: str
    best: bool
    numbers: Mapping[str, float]


@dataclass(frozen=True)
class Row:
    """One method in one task."""

    task: str
    method: str
    label: str
    colour: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Group:
    """The rows of one task."""

    task: str
    heading: str
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Table:
    """A table before it takes the form of a format."""

    number: int
    title: str
    columns: tuple[Column, ...]
    groups: tuple[Group, ...]
    notes: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of its files without the suffix."""
        return f"table{self.number}"


# -- numbers as text -----------------------------------------------------------------------------------------


def count_text(value: float) -> str:
    """Whole number with three significant digits and thousands separators: 35412.6 -> 35,400."""
    rounded = _significant(value, 3)
    return _sign(f"{rounded:,.0f}")


def decimal_text(digits: int) -> Callable[[float], str]:
    """Format with a fixed number of decimals, which keeps the points of a column below each other."""

    def text(value: float) -> str:
        return _sign(f"{value:,.{digits}f}")

    return text


def _significant(value: float, digits: int) -> float:
    if value == 0 or not math.isfinite(value):
        return value
    place = digits - 1 - math.floor(math.log10(abs(value)))
    return round(value, min(place, 0))


def _sign(text: str) -> str:
    negative = text.startswith("-") and text.strip("-0.,") != ""
    return (MINUS if negative else "") + text.lstrip("-")


# -- the model -----------------------------------------------------------------------------------------------

TRANSFER_COLUMNS = (
    Column("jump_start", "Jump start", "steps", "higher", count_text,
           with_improvement=True, against_base=True),
    Column("jump_start_percent", "Jump start", "% of the base's mean", "higher", decimal_text(1),
           against_base=True),
    Column("asymptotic", "Asymptotic performance", "steps", "lower", decimal_text(1), with_improvement=True),
    Column(
        "threshold_episode", "Time to threshold", "episodes", "lower", decimal_text(1),
        with_share=True, with_improvement=True,
    ),
)  # fmt: skip
"""Columns of the odd tables."""

TOTAL_COLUMNS = (
    Column("total_steps", "Total performance", "steps", "lower", count_text, with_improvement=True),
    Column(
        "transfer_ratio",
        "Transfer ratio",
        "mean of per-seed ratios",
        "higher",
        decimal_text(3),
        against_base=True,
    ),
    Column(
        "transfer_ratio_of_means",
        "Transfer ratio",
        "ratio of the means",
        "higher",
        decimal_text(3),
        against_base=True,
    ),
)
"""Columns of the even tables."""


def build_tables(
    metrics: pd.DataFrame,
    settings: Settings,
    labels: Mapping[str, tuple[str, str]],
    environments: Mapping[str, str] | None = None,
    source: str = "metrics.csv",
) -> list[Table]:
    """Two tables for each environment.

    Parameters
    ----------
    metrics : DataFrame
        As `ptl.statistics.summarise` makes it.
    settings : Settings
    labels : mapping
        Method to its label and colour (CSS).
    environments : mapping, optional
        Environment to title, in the order of the tables; by default those of the metrics, without titles.
    source : str
        File that the caption names as the origin.

    Raises
    ------
    UserError
        When an environment is not in the metrics.
    """
    if environments is None:
        environments = dict.fromkeys(metrics["environment"].unique(), "")
    tables: list[Table] = []
    for environment, title in environments.items():
        frame = metrics[metrics["environment"] == environment]
        if frame.empty:
            raise UserError(f"{source}: no environment {environment!r}; measure its learning files first")
        place = title or environment
        origin = f"{source}, environment {environment}"
        tables.append(
            _build(len(tables) + 1, f"Jump start, asymptotic performance and time to threshold, {place}",
                   TRANSFER_COLUMNS, frame, labels, settings.base,
                   _transfer_notes(frame, settings, labels, origin))
        )  # fmt: skip
        tables.append(
            _build(len(tables) + 1, f"Total performance and transfer ratio, {place}",
                   TOTAL_COLUMNS, frame, labels, settings.base,
                   _total_notes(frame, settings, labels, origin))
        )  # fmt: skip
    return tables


def _build(
    number: int,
    title: str,
    columns: tuple[Column, ...],
    frame: pd.DataFrame,
    labels: Mapping[str, tuple[str, str]],
    base: str,
    notes: Sequence[str],
) -> Table:
    groups = []
    for position, (task, part) in enumerate(frame.groupby("task", sort=True)):
        by_key = part.set_index(["method", "metric"])
        methods = list(part["method"].unique())
        # In the first task nothing is transferred: a best value there would only be a lucky one.
        best = {
            column.key: best_methods(column, {m: by_key.loc[m, column.key] for m in methods})
            for column in columns
            if position > 0
        }
        rows = tuple(
            Row(
                task=str(task),
                method=method,
                label=labels[method][0],
                colour=labels[method][1],
                cells=tuple(
                    _cell(c, by_key.loc[method, c.key], method in best.get(c.key, ()), method == base) for c in columns
                ),
            )
            for method in methods
        )
        heading = f"Task {task}"
        if position == 0:
            heading += ": nothing to transfer yet, all methods start equal"
        groups.append(Group(str(task), heading, rows))
    return Table(number, title, columns, tuple(groups), tuple(notes))


def best_methods(column: Column, values: Mapping[str, pd.Series]) -> set[str]:
    """Methods whose number goes in bold: the best, and those that read the same; none if all read the same.

    A time to threshold competes only among the methods that reached it in the most seeds: a mean over few
    lucky seeds is not better than one over all.
    """
    present = {method: row for method, row in values.items() if not math.isnan(row["mean"])}
    if not present:
        return set()
    contenders = present
    if column.with_share:
        most = max(row["reached"] for row in present.values())
        contenders = {method: row for method, row in present.items() if row["reached"] == most}
    choose = min if column.better == "lower" else max
    best = column.format(choose(row["mean"] for row in contenders.values()))
    chosen = {method for method, row in contenders.items() if column.format(row["mean"]) == best}
    return set() if len(chosen) == len(values) else chosen


def _cell(column: Column, row: pd.Series, best: bool, is_base: bool) -> Cell:
    n, seeds = int(row["n"]), int(row["seeds"])
    by_definition = is_base and column.against_base
    if by_definition and n:
        text = column.format(0.0)
    elif n:
        text = column.format(row["mean"])
        if not math.isnan(row["std"]):
            text += f" ± {column.format(row['std'])}"
    else:
        text = NOT_REACHED if column.with_share else DASH
    interval = ""
    if not (by_definition or math.isnan(row["ci_low"])):
        interval = f"{column.format(row['ci_low'])} to {column.format(row['ci_high'])}"
    improvement = DASH if math.isnan(row["improvement"]) else f"{row['improvement']:.2f}"
    names: tuple[str, ...] = ("mean", "std", "ci_low", "ci_high", "n", "seeds")
    names += ("reached",) * column.with_share
    names += ("improvement", "improvement_low", "improvement_high") * column.with_improvement
    return Cell(
        text=text,
        interval=interval,
        share=f"{n} of {seeds}",
        improvement=improvement,
        best=best,
        numbers={name: row[name] for name in names},
    )


def _transfer_notes(
    frame: pd.DataFrame, settings: Settings, labels: Mapping[str, tuple[str, str]], origin: str
) -> list[str]:
    return [
        *_common_notes(frame, settings, labels, origin),
        "Jump start: first-episode steps of the base minus those of the method, same seed; positive is good."
        " Its percentage is a ratio of means; its P compares the first episodes.",
        f"Asymptotic performance: mean steps of the last {settings.window} episodes.",
        f"Time to threshold: first episode at which the mean of the last {settings.window} is at most"
        f" {settings.threshold_factor:g} times the shortest path. Its mean covers only the seeds that reached"
        " it, counted under “reached”; bold is given among the methods that reached it in the most seeds.",
    ]


def _total_notes(
    frame: pd.DataFrame, settings: Settings, labels: Mapping[str, tuple[str, str]], origin: str
) -> list[str]:
    return [
        *_common_notes(frame, settings, labels, origin),
        "Total performance: steps over all episodes of the task.",
        "Transfer ratio: (total of the base − total of the method) / total of the base; positive is good. The"
        " mean of the per-seed ratios counts every seed alike, the ratio of the means every step alike.",
    ]


def _common_notes(
    frame: pd.DataFrame, settings: Settings, labels: Mapping[str, tuple[str, str]], origin: str
) -> list[str]:
    runs = " or ".join(map(str, sorted({int(n) for n in frame["seeds"]})))
    notes = [
        f"Mean ± standard deviation over {runs} runs (seeds) of this reproduction; under it the"
        f" {100 * settings.confidence:g}% bootstrap interval of the mean (BCa, {settings.resamples:,}"
        " resamples; paired by seed where a method is compared with the base). Best value of a column within"
        " a task in bold; none is marked in the first task.",
    ]
    if settings.base in set(frame["method"]):
        notes.append(
            f"Base: {labels[settings.base][0]}. P: probability that a run of the method is better than a run"
            " of the base (ties count half; 0.5 is no difference).",
        )
    else:
        notes.append(f"The base {settings.base} is not in this run, so nothing is compared with it.")
    truncated = frame[(frame["metric"] == "truncated") & (frame["mean"] > 0)]
    if len(truncated):
        parts = [f"task {r.task}, {labels[r.method][0]}: {r.mean * r.n:.0f}" for r in truncated.itertuples()]
        notes.append(f"Episodes cut off at the step cap, counted with the cap's length: {'; '.join(parts)}.")
    notes.append(f"Computed from {origin}.")
    return notes


# -- the formats ---------------------------------------------------------------------------------------------


def write_tables(tables: Sequence[Table], folder: str | Path) -> list[Path]:
    """Write every table as .html, .md, .tex and .csv; returns the paths."""
    paths = []
    for table in tables:
        for suffix, render in ((".html", to_html), (".md", to_markdown), (".tex", to_latex)):
            path = Path(folder) / f"{table.name}{suffix}"
            write_text(path, render(table))
            paths.append(path)
        path = Path(folder) / f"{table.name}.csv"
        write_csv(to_frame(table), path)
        paths.append(path)
    return paths


def to_frame(table: Table) -> pd.DataFrame:
    """The numbers of a table, a row for each task and method."""
    records = []
    for group in table.groups:
        for row in group.rows:
            record: dict[str, object] = {"task": row.task, "method": row.method}
            for column, cell in zip(table.columns, row.cells, strict=True):
                record |= {f"{column.key}_{name}": value for name, value in cell.numbers.items()}
                record[f"{column.key}_best"] = cell.best
            records.append(record)
    return pd.DataFrame(records)


def to_markdown(table: Table) -> str:
    """A pipe table, one line for each task and method, notes below."""
    headings, rule = ["Task", "Method"], ["---", "---"]
    for column in table.columns:
        headings.append(f"{column.heading} ({column.unit})")
        headings += ["reached"] * column.with_share + ["P"] * column.with_improvement
        rule += ["---:"] * column.width
    lines = [f"**Table {table.number}.** {_escape_markdown(table.title)}", "", _pipe(headings), _pipe(rule)]
    for group in table.groups:
        for index, row in enumerate(group.rows):
            texts = [f"**{group.task}**" if index == 0 else "", _escape_markdown(row.label)]
            for column, cell in zip(table.columns, row.cells, strict=True):
                text = f"**{cell.text}**" if cell.best else cell.text
                texts.append(f"{text}<br>{cell.interval}" if cell.interval else text)
                texts += [cell.share] * column.with_share + [cell.improvement] * column.with_improvement
            lines.append(_pipe(texts))
    lines += ["", *(f"{_escape_markdown(note)}\n" for note in table.notes)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _pipe(texts: Sequence[str]) -> str:
    return "| " + " | ".join(texts) + " |"


def _escape_markdown(text: str) -> str:
    for character in "\\|*_<>":
        text = text.replace(character, f"\\{character}")
    return text


LATEX_CHARACTERS = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{",
    "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "±": r"$\pm$", MINUS: r"$-$",
    DASH: "--", "×": r"$\times$", "“": "``", "”": "''", "<": r"$<$", ">": r"$>$",
}  # fmt: skip


def escape_latex(text: str) -> str:
    """Text as LaTeX source; every special character is printed as itself."""
    return "".join(LATEX_CHARACTERS.get(character, character) for character in text)


def to_latex(table: Table) -> str:
    """A longtable with booktabs rules; two lines for each method, the interval in the second."""
    width = 1 + sum(column.width for column in table.columns)
    tops, units, rules = [], [], []
    position = 2
    for column in table.columns:
        last = position + column.width - 1
        tops.append(rf"\multicolumn{{{column.width}}}{{c}}{{{escape_latex(column.heading)}}}")
        rules.append(rf"\cmidrule(lr){{{position}-{last}}}")
        units += [escape_latex(column.unit)] + ["reached"] * column.with_share + ["$P$"] * column.with_improvement
        position = last + 1
    head = [
        r"\toprule",
        " & ".join(["", *tops]) + r" \\",
        "".join(rules),
        " & ".join(["Method", *units]) + r" \\",
        r"\midrule",
    ]
    lines = [
        r"% \usepackage{booktabs,longtable}; wide: put it in a landscape environment (pdflscape)",
        r"\begingroup\footnotesize\setlength{\tabcolsep}{4pt}",
        rf"\begin{{longtable}}{{@{{}}l{'r' * (width - 1)}@{{}}}}",
        rf"\caption{{{escape_latex(table.title)}.}}\label{{tab:{table.name}}}\\",
        *head,
        r"\endfirsthead",
        *head,
        r"\endhead",
        r"\bottomrule",
        r"\endlastfoot",
    ]
    for index, group in enumerate(table.groups):
        if index:
            lines.append(r"\midrule")
        lines.append(rf"\multicolumn{{{width}}}{{@{{}}l}}{{\textit{{{escape_latex(group.heading)}}}}} \\*")
        for row in group.rows:
            values, intervals = [escape_latex(row.label)], [""]
            for column, cell in zip(table.columns, row.cells, strict=True):
                text = escape_latex(cell.text)
                # \boldmath as well, because the signs are set in mathematics
                values.append(rf"{{\boldmath\textbf{{{text}}}}}" if cell.best else text)
                values += [cell.share] * column.with_share
                values += [escape_latex(cell.improvement)] * column.with_improvement
                intervals.append(rf"{{\scriptsize {escape_latex(cell.interval)}}}" if cell.interval else "")
                intervals += [""] * (column.width - 1)
            lines.append(" & ".join(values) + r" \\*")
            lines.append(" & ".join(intervals) + r" \\")
    lines.append(r"\end{longtable}")
    lines += [rf"\noindent {escape_latex(note)}\par" for note in table.notes]
    lines.append(r"\endgroup")
    return "\n".join(lines) + "\n"


STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #5b6470; --rule: #d5dae0;
  --strong: #1b1f24; --page: #ffffff; --band: #f4f6f8; --best: #e3f1e6; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ed; --soft: #9aa4b0; --rule: #343b44;
  --strong: #c9d0d8; --page: #14171b; --band: #1e2329; --best: #1f3a29; } }
* { box-sizing: border-box; }
body { margin: 0; padding: 1.5rem clamp(.75rem, 3vw, 2.5rem); background: var(--page); color: var(--ink);
  font: 15px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
figure { margin: 0 auto; width: fit-content; max-width: 100%; }
.scroll { overflow-x: auto; -webkit-overflow-scrolling: touch; }
table { border-collapse: collapse; border-block: 2px solid var(--strong);
  font-variant-numeric: tabular-nums; }
th, td { padding: .32rem .8rem; text-align: right; white-space: nowrap; vertical-align: top; }
thead th { font-weight: 600; text-align: right; vertical-align: bottom; }
thead tr:first-child th { text-align: center; padding-bottom: .1rem; }
thead tr:last-child th { font-weight: 400; font-size: .85em; color: var(--soft); padding-top: .1rem;
  border-bottom: 1px solid var(--strong); }
thead tr:first-child th:first-child { border-bottom: 1px solid var(--strong); }
thead th[colspan] { box-shadow: inset 0 -1px var(--rule); }
tbody th { text-align: left; font-weight: 400; }
tbody th.task { font-weight: 600; background: var(--band); padding-block: .4rem; }
tbody th.task span { position: sticky; left: .8rem; }
tbody + tbody { border-top: 1px solid var(--strong); }
tbody tr + tr { border-top: 1px solid var(--rule); }
tbody th[scope=row], thead tr:first-child th:first-child { position: sticky; left: 0; background: var(--page);
  text-align: left; z-index: 1; }
td small { display: block; font-size: .8em; color: var(--soft); }
td.best { background: var(--best); }
td.missing, td.side { color: var(--soft); }
.dot { display: inline-block; width: .7em; height: .7em; border-radius: 50%; margin-right: .5em; }
figcaption { max-width: 75ch; margin-bottom: 1rem; }
figcaption h1 { text-wrap: balance; font-size: 1.15rem; line-height: 1.3; margin: 0 0 .3rem; }
.notes { max-width: 90ch; margin: 1rem 0 0; padding: 0; list-style: none;
  font-size: .87em; color: var(--soft); }
.notes li { margin-bottom: .35rem; }
@media print { body { padding: 0; font-size: 10px; } .scroll { overflow: visible; } }
""".strip()


def to_html(table: Table) -> str:
    """A page of its own, without scripts or other files; light and dark, and wide tables scroll."""
    width = 1 + sum(column.width for column in table.columns)
    tops, units = ['<th scope="col" rowspan="2">Method</th>'], []
    for column in table.columns:
        spread = f' colspan="{column.width}"' if column.width > 1 else ""
        tops.append(f'<th scope="colgroup"{spread}>{html.escape(column.heading)}</th>')
        units.append(f'<th scope="col">{html.escape(column.unit)}</th>')
        units += ['<th scope="col">reached</th>'] * column.with_share
        units += ['<th scope="col"><abbr title="probability of improvement over the base">P</abbr></th>'] * (
            column.with_improvement
        )
    title = html.escape(f"Table {table.number}. {table.title}")
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title>",
        f"<style>\n{STYLE}\n</style>",
        "</head>",
        "<body>",
        "<figure>",
        f'<figcaption id="caption"><h1>{title}</h1>{html.escape(table.notes[0])}</figcaption>',
        '<div class="scroll" tabindex="0" role="region" aria-labelledby="caption">',
        '<table aria-labelledby="caption">',
        "<thead>",
        f"<tr>{''.join(tops)}</tr>",
        f"<tr>{''.join(units)}</tr>",
        "</thead>",
    ]
    for group in table.groups:
        heading = html.escape(group.heading)
        lines.append("<tbody>")
        lines.append(f'<tr><th class="task" colspan="{width}" scope="rowgroup"><span>{heading}</span></th></tr>')
        for row in group.rows:
            dot = f'<span class="dot" style="background:{html.escape(row.colour)}"></span>'
            cells = [f'<th scope="row">{dot}{html.escape(row.label)}</th>']
            for column, cell in zip(table.columns, row.cells, strict=True):
                cells += _html_cells(column, cell)
            lines.append(f"<tr>{''.join(cells)}</tr>")
        lines.append("</tbody>")
    notes = "".join(f"<li>{html.escape(note)}</li>" for note in table.notes[1:])
    lines += ["</table>", "</div>", f'<ul class="notes">{notes}</ul>', "</figure>", "</body>", "</html>"]
    return "\n".join(lines) + "\n"


def _html_cells(column: Column, cell: Cell) -> list[str]:
    text = html.escape(cell.text)
    if cell.best:
        text = f"<b>{text}</b>"
    if cell.interval:
        text += f"<small>{html.escape(cell.interval)}</small>"
    kind = "best" if cell.best else "missing" if not cell.interval and not cell.numbers["n"] else ""
    cells = [f'<td class="{kind}">{text}</td>' if kind else f"<td>{text}</td>"]
    cells += [f'<td class="side">{cell.share}</td>'] * column.with_share
    cells += [f'<td class="side">{html.escape(cell.improvement)}</td>'] * column.with_improvement
    return cells
