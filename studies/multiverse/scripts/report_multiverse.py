"""Summarise the verdicts of all settings: ledger of degrees, compatibility, ways to use a skill, figures and page."""

from pathlib import Path

import pandas as pd

from ptl.files.atomic import write_text
from ptl.files.csv import read_csv, write_csv
from ptl.report.figures import saving
from ptl.report.script import running
from ptl.report.table import write
from ptl.text import number
from studies.multiverse import adoption, compatibility, curves, figures, page, shares
from studies.multiverse.design import read_study
from studies.multiverse.learning import COMPLETE

CAPTIONS = {
    "jump_start": "How much shorter PTL's first episode is than without transfer",
    "transfer_ratio": "How many of all steps PTL saves",
    "threshold_episode": "In how many episodes PTL learns a task",
}


def tables(paths: list[str]) -> pd.DataFrame:
    """Return the rows of some tables."""
    return pd.concat([read_csv(path, dtype={"runs": str}) for path in paths], ignore_index=True)


with running(snakemake) as script:
    study = read_study(script.input.study)
    level, reference = snakemake.params.confidence, snakemake.params.reference
    titles = snakemake.params.titles
    folder = Path(script.output.page).parent
    verdicts, estimates, states = (tables(script.input[name]) for name in ("verdicts", "estimates", "states"))
    printed = read_csv(script.input.printed, dtype={"runs": str})
    changes = {point.name: point.changes for point in study.points() if point.name not in study.named}
    named = {name: own.title for name, own in study.named.items()}

    ledger = shares.ledger(verdicts, printed, read_csv(script.input.classes), level)
    held = compatibility.tables(verdicts)
    pairs = compatibility.pair_table(held)
    scores = compatibility.score_table(verdicts)
    ways = adoption.way_table(verdicts, changes)
    chosen, alike = adoption.adopted(ways, study.unknowns[adoption.UNKNOWN].options)
    frame = curves.curve_frame(estimates)
    associations = curves.association_table(frame[frame["setting"].isin(changes)], changes, study.unknowns)

    settings = states.merge(scores, on="setting")
    settings = settings.join(pd.DataFrame(settings["setting"].map(lambda name: changes.get(name, {})).tolist()))
    incomplete = int((states["status"] != COMPLETE).sum())

    ledger_table = page.ledger_table(ledger)
    write(ledger_table, folder / "ledger", ledger)
    write_csv(shares.share_table(shares.drawn(verdicts), level), folder / "shares.csv")
    write_csv(ways, folder / "ways.csv")
    write_csv(settings, folder / "settings.csv")
    write_csv(associations, folder / "associations.csv")
    write_csv(verdicts, folder / "verdicts.csv.gz")
    write_csv(estimates, folder / "estimates.csv.gz")

    saving.save(figures.draw_shares(ledger), ledger, folder / "degrees.png")
    saving.save(figures.draw_compatibility(pairs), pairs, folder / "compatibility.png")
    way_of = {setting: str(own[adoption.UNKNOWN]) for setting, own in changes.items()}
    saving.save(figures.draw_scores(scores, way_of, named), scores, folder / "scores.png")
    for headline in curves.HEADLINES:
        figure = figures.draw_curve(frame, associations, changes, study.unknowns, titles, headline, reference)
        saving.save(figure, frame[frame["headline"] == headline], folder / f"{headline}.png")

    text = page.page(
        introduction=(
            "The article's equations, maps, tables and parameters are lost. Instead of one choice of all that it leaves"
            f" open, {number(study.settings)} choices were drawn at random and learned, and every statement of the"
            " article was judged in each, under every reading of its words. Nothing here was selected by its outcome."
        ),
        conclusions=[*page.conclusions(scores, chosen, alike, reference)],
        sections=[
            {
                "heading": "How far each statement holds",
                "lines": [],
                "figures": [
                    {
                        "name": "degrees",
                        "alt": "Share of the settings in which each claim holds",
                        "caption": (
                            "Share of the drawn settings in which each claim holds, with intervals. The strip at the"
                            " left shows its class in the published run."
                        ),
                    }
                ],
                "tables": [(ledger_table, True)],
            },
            {
                "heading": "What can hold together",
                "lines": [*compatibility.sentences(pairs)],
                "figures": [
                    {
                        "name": "compatibility",
                        "alt": "How often two claims hold together",
                        "caption": (
                            "Red: where one of the two claims holds, the other hardly does. Grey: one of the two holds"
                            " in no setting."
                        ),
                    },
                    {
                        "name": "scores",
                        "alt": "Share of the claims that hold by way to use a skill",
                        "caption": (
                            "Drawn settings by the way to use a skill (dark line: mean), and the named settings."
                        ),
                    },
                ],
                "tables": [
                    (page.score_table(scores, named, {name: own.fitted for name, own in study.named.items()}), True),
                    (page.way_table(ways, chosen), True),
                ],
            },
            {
                "heading": "The headline estimates in every setting",
                "lines": [],
                "figures": [
                    {
                        "name": headline,
                        "alt": figures.HEADINGS[headline],
                        "caption": (
                            f"{CAPTIONS[headline]}, in every drawn setting: sorted on B to F together, with intervals;"
                            " below, the unknowns that it depends on most, a mark for each setting."
                            + (" Savings below −100% are drawn there." if headline in figures.FLOOR else "")
                        ),
                    }
                    for headline in curves.HEADLINES
                ],
                "tables": [(page.unknown_table(study.unknowns), False)],
            },
        ],
        method_lines=page.method_lines(study, incomplete),
    )
    write_text(script.output.page, text)
