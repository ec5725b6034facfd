"""Estimate costs, draw the figures and write the tables and the page of the second study."""

from pathlib import Path

import pandas as pd

from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.measures.statistics import Resampling
from ptl.report.figures import saving
from ptl.report.script import running
from ptl.report.table import write
from studies.beyond import figures, lifelong, page, summary
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

    means = summary.Means(main, how)
    costs = summary.costs(means, main)
    overall = page.overall_ratios(means, generated)
    components = summary.variance_components(main)
    sizes = summary.by_library_size(tasks, how)
    sequences = summary.by_sequence(lives, how)
    hardness = summary.hardness(main, read_population(), page.against_hardness(looks))
    of_tasks = "random" if "random" in study.sequences.names else MAIN
    places = summary.by_task(tasks, of_tasks, how)
    profiles = summary.profiles(main, how)
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
        of_costs("cost", "ratio", "ratio_low", "ratio_high"),
        "Cost of every method in every family of maps, as numbers",
        "Cost as a multiple of the optimum (1 cannot be beaten), geometric mean over maps and lives; the cheapest"
        " methods on top, PTL in bold. ≈: cannot be told from PTL on the same maps.",
    )
    picture(
        "overview",
        figures.overview(costs, looks, titles),
        costs,
        "Cost of every method in each family of maps as a multiple of PTL’s",
        "Cost of every method as a multiple of PTL’s on the same maps, one panel a family, with intervals.",
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

    def table(name, made, numbers):
        """Write a table and return it."""
        write(made, folder / name, numbers)
        return made

    cost_table = table(
        "costs",
        page.wide_table(
            costs, looks, titles, "family", "cost", ("low", "high"), "Cost as a multiple of the optimum",
            "Geometric mean over maps and lives.", (page.BOLD, page.NOTE), "least",
        ),
        of_costs("maps", "seeds", "cost", "low", "high", "least", "library_size"),
    )  # fmt: skip
    ratios = pd.concat([overall, of_costs("ratio", "ratio_low", "ratio_high")], ignore_index=True)
    ratio_table = table(
        "ratios",
        page.wide_table(
            ratios, looks, {page.EVERY: "All generated families", **titles}, "family", "ratio",
            ("ratio_low", "ratio_high"), "Cost as a multiple of PTL’s",
            "Ratio on the same maps; below 1 a method is cheaper than PTL.", (page.NOTE,),
        ),
        ratios,
    )  # fmt: skip
    chances = table(
        "improvement",
        page.wide_table(
            costs, looks, titles, "family", "improvement", ("improvement_low", "improvement_high"),
            "Probability of improvement over PTL",
            "Chance that a life costs less than one under PTL on the same map, ties counting half.", (page.NOTE,),
        ),
        of_costs("improvement", "improvement_low", "improvement_high"),
    )  # fmt: skip
    of_sequences = [frame for _, frame in sequences.values()]
    sequence_table = table(
        "sequences",
        page.by_group_table(
            sequences, looks, titles, generated, "Sequences of tasks",
            "Cost as a multiple of PTL’s on the same maps, by the order in which goals come.",
        ),
        pd.concat(of_sequences) if of_sequences else pd.DataFrame(columns=["sequence", *costs.columns]),
    )  # fmt: skip
    spread = {
        "heading": "Across maps, tasks and sequences",
        "text": "How the cost is spread over lives, how it changes over a life, and what it depends on.",
        "figures": [pictures[name] for name in ("profiles", "tasks")],
        "tables": [
            (table("components", page.component_table(components, looks, titles), components), False),
            *([(sequence_table, False)] if sequences else []),
        ],
    }
    sections = [
        {
            "heading": "Costs",
            "text": "All methods on the same maps, each family by itself.",
            "figures": [pictures["overview"]],
            "tables": [(ratio_table, False), (cost_table, False), (chances, False)],
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
    questions = page.answers(means, looks, generated)
    if len(hardness):
        trends = summary.hardness_trends(hardness, how)
        picture(
            "hardness",
            figures.hardness(hardness, page.MEASURES, looks, titles),
            hardness,
            "Cost of some methods on each map against the diameter and the winding of the map",
            "Cost on each map, geometric mean over lives. Diameter: the longest of all shortest paths between two"
            " places of the map, in steps. Winding: shortest path from the start to a goal ÷ straight line, mean over"
            " the goals.",
        )
        correlations = table("hardness_trends", page.trends_table(trends, looks), trends)
        sections.insert(
            1,
            {
                "heading": "Hard maps",
                "text": "What makes a map hard: how far apart its places are, and how much paths wind.",
                "figures": [pictures["hardness"]],
                "tables": [(correlations, False)] if len(trends) else [],
            },
        )
        if len(trends):
            questions.append(page.hardness_answer(trends, looks))
    if study.returns:
        gains = lifelong.measures(tasks, generated, how)
        sections.insert(
            1,
            {
                "heading": "What a life keeps and gains",
                "text": lifelong.sentence(gains, looks),
                "figures": [],
                "tables": [(table("lifelong", lifelong.table(gains, looks), gains), True)],
            },
        )
    if study.is_harder:
        harder = per_life_harder(all_tasks)
        write_csv(harder, folder / "per_life_harder.csv")
        worlds = summary.by_world(harder, main, how)
        of_worlds = pd.concat([frame for _, frame in worlds.values()])
        picture(
            "slips",
            figures.slips(of_worlds, looks, titles),
            of_worlds,
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
                "tables": [
                    (
                        table(
                            "harder",
                            page.by_group_table(
                                worlds, looks, titles, generated, "Cost where moves slip and maps change",
                                "As a multiple of PTL’s in the same world, on the same maps.",
                            ),
                            of_worlds,
                        ),
                        False,
                    )
                ],
            },
        )  # fmt: skip
        questions.append(page.harder_answer({name: own for name, (own, _) in worlds.items()}, looks, generated))
    write_text(
        folder / "index.html",
        page.page(
            introduction=page.introduction(study, lives),
            lead=page.lead(means, looks, generated),
            strip=pictures["strip"],
            glossary=page.glossary(looks),
            answers=[answer for answer in questions if answer["lead"] or answer["lines"]],
            explorer=page.explorer_line(study, looks),
            reading=page.READING,
            sections=[section for section in sections if section["figures"] or section["tables"]],
            another_house=page.ANOTHER_HOUSE,
            method_lines=page.method_lines(study, how),
        ),
    )
