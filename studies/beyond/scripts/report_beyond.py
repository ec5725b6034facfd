"""Estimate costs, draw the figures and write the tables and the page of the second study."""

from pathlib import Path

import pandas as pd

from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.measures.statistics import Resampling
from ptl.report.figures import saving
from ptl.report.script import running
from ptl.report.table import write
from studies.beyond import figures, page, summary
from studies.beyond.collect import certain, foreign_lives, per_life_harder, read_lives, read_tasks
from studies.beyond.design import SecondStudy
from studies.beyond.maps import MAIN
from studies.beyond.population import read_population

with running(snakemake) as script:
    study = SecondStudy.read(snakemake.params.study)
    folder = Path(script.output.page).parent
    how = Resampling(study.statistics.confidence, study.statistics.resamples)
    lives = [frame for frame in (read_lives(script.input.lives), foreign_lives(study)) if len(frame)]
    lives = pd.concat(lives, ignore_index=True)
    all_tasks = read_tasks(script.input.tasks)
    tasks = all_tasks[certain(all_tasks)]
    looks = page.looks_of(study, lives["method"])
    main = summary.main_lives(lives)
    titles = page.titles_of(dict.fromkeys(main["family"]), study.article_maps)
    generated = [family for family in titles if family not in study.article_maps]
    curves = page.in_figures(looks)

    costs = summary.costs(main, how)
    components = summary.variance_components(main)
    sizes = summary.by_library_size(tasks, how)
    sequences = summary.by_sequence(lives, how)
    windings = summary.by_winding(main, read_population())
    trends = summary.winding_trends(windings)
    of_tasks = "random" if "random" in study.sequences.names else MAIN
    places = summary.by_task(tasks, of_tasks, how)
    profiles = summary.profiles(main, how)
    write_csv(trends, folder / "winding_trends.csv")
    write_csv(sequences, folder / "sequences.csv")
    pictures = {}

    def of_costs(*columns):
        """Return some of what was estimated for each family and method."""
        return costs[["family", "method", *columns]]

    def picture(name, figure, frame, alt, caption):
        """Save a figure; pages name it."""
        saving.save(figure, frame, folder / f"{name}.png")
        pictures[name] = {"name": name, "alt": alt, "caption": caption}

    picture(
        "strip",
        figures.strip(costs, looks, titles),
        of_costs("cost"),
        "Cost of every method in every family of maps, as numbers",
        "Cost as a multiple of the optimum (1 cannot be beaten), geometric mean over maps and lives; the cheapest"
        " methods on top, PTL in bold.",
    )
    picture(
        "overview",
        figures.overview(costs, looks, titles),
        of_costs("cost", "low", "high"),
        "Cost of every method in each family of maps",
        "Cost of every method, one panel a family, with intervals.",
    )
    if len(sizes):
        picture(
            "library_size",
            figures.library_size(sizes, costs, looks, titles, ("no_transfer", "rmax_memory"), ("ptl", "all_goals")),
            sizes,
            "Cost against the size of the library, a curve for each finder of subgoals",
            "Cost against the size of the library at the beginning of the tasks after the first: a curve for each"
            " finder, with 1, 2, 4 … skills added after every task whether needed or not. Diamonds: PTL as it is;"
            " squares: a skill to every state; dashed: methods without a library.",
        )
    picture(
        "profiles",
        figures.profile(profiles[profiles["method"].isin(curves)], curves, titles),
        profiles,
        "Performance profiles in each family of maps",
        "Share of lives whose cost is at most τ times the optimum; higher and further left is better.",
    )
    picture(
        "tasks",
        figures.tasks(places[places["method"].isin(curves)], curves, titles),
        places,
        "Cost of each task against the number of tasks learned before",
        f"Cost of each task in its place of the life, tasks in {of_tasks} order (the article’s order on its maps)."
        " Without memory of earlier tasks a curve changes with the tasks’ distance only. Methods without a curve were"
        " not run in this order.",
    )
    if len(windings):
        picture(
            "winding",
            figures.winding(windings[windings["method"].isin(curves)], curves, titles),
            windings,
            "Cost against the winding of the map",
            "Cost on each map against its winding: the mean over its goals of shortest path ÷ straight line. Spearman’s"
            " coefficients for each family: winding_trends.csv.",
        )

    def table(name, made, numbers):
        """Write a table and return it."""
        write(made, folder / name, numbers)
        return made

    note = "Bold: least in the column. Brackets: intervals."
    cost_table = table(
        "costs",
        page.wide_table(
            costs, looks, titles, "family", "cost", ("low", "high"), "Cost as a multiple of the optimum",
            "Geometric mean over maps and lives.", (note,),
        ),
        of_costs("maps", "seeds", "cost", "low", "high", "library_size"),
    )  # fmt: skip
    ratio_table = table(
        "ratios",
        page.wide_table(
            costs, looks, titles, "family", "ratio", ("ratio_low", "ratio_high"), "Cost as a multiple of PTL’s",
            "Geometric mean of the ratio on the same maps; below 1 a method is cheaper than PTL.", (note,),
        ),
        of_costs("ratio", "ratio_low", "ratio_high"),
    )  # fmt: skip
    chances = table(
        "improvement",
        page.wide_table(
            costs, looks, titles, "family", "improvement", ("improvement_low", "improvement_high"),
            "Probability of improvement over PTL",
            "Chance that a life costs less than one under PTL on the same map, ties counting half.", best=False,
        ),
        of_costs("improvement", "improvement_low", "improvement_high"),
    )  # fmt: skip
    spread = {
        "heading": "Across maps, tasks and sequences",
        "text": "How the cost is spread over lives, how it changes over a life, and what it depends on.",
        "figures": [pictures[name] for name in ("profiles", "tasks", "winding") if name in pictures],
        "tables": [(table("components", page.component_table(components, looks, titles), components), False)],
    }
    sections = [
        {
            "heading": "Costs",
            "text": "All methods, each family by itself.",
            "figures": [pictures["overview"]],
            "tables": [(cost_table, True), (ratio_table, False), (chances, False)],
        },
        {
            "heading": "Which part does the work",
            "text": "The same agent with subgoals from elsewhere, in libraries of any size.",
            "figures": [pictures[name] for name in ("library_size",) if name in pictures],
            "tables": [],
        },
        spread,
        {
            "heading": "What each method may know",
            "text": "A comparison is fair only between methods that may know the same.",
            "figures": [],
            "tables": [(page.knowledge_table(looks), True)],
        },
    ]
    questions = page.answers(costs, looks, generated, components, titles)
    if study.is_harder:
        harder = per_life_harder(all_tasks)
        write_csv(harder, folder / "per_life_harder.csv")
        worlds = summary.harder_costs(harder, main, how)
        picture(
            "slips",
            figures.slips(worlds, looks, titles),
            worlds,
            "Cost where steps slip or the map changes between tasks",
            "Cost of some methods where steps slip, as a multiple of the optimum of the same world, and where the map"
            " changes between tasks, which methods are not told. On the maps that all of these worlds share.",
        )
        sections.insert(
            1,
            {
                "heading": "Where moves slip and maps change",
                "text": "With probability p a step goes in a random direction. A door changes: the narrowest passage"
                " closes, if there is one, and another opens if a goal is cut off. Cells change: one in twenty.",
                "figures": [pictures["slips"]],
                "tables": [(table("harder", page.harder_table(worlds, looks, titles), worlds), False)],
            },
        )
        questions.append(page.harder_answer(worlds, looks))
    if len(sequences):
        for family in dict.fromkeys(sequences["family"]):
            part = sequences[sequences["family"] == family]
            made = page.wide_table(
                part, looks, {name: name for name in dict.fromkeys(part["sequence"])}, "sequence", "cost",
                ("low", "high"), f"Sequences of tasks: {titles[family]}",
                "Cost as a multiple of the optimum on the same maps, by the order in which goals come.",
            )  # fmt: skip
            spread["tables"].append((made, False))
    write_text(
        folder / "index.html",
        page.page(
            introduction=page.introduction(study, lives),
            lead=page.lead(costs, looks, generated),
            strip=pictures["strip"],
            answers=questions,
            explorer=page.explorer_line(study, looks),
            reading=page.READING,
            sections=[section for section in sections if section["figures"] or section["tables"]],
            method_lines=page.method_lines(study),
        ),
    )
