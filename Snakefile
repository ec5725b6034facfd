# Partial transfer learning with a skill library: the whole reproduction.
#
#   map -> learning, growth, survey (HDF5) -> measures -> tables, figures, claims -> report
#
# `snakemake -j2` makes everything; the rules with a short name below make one stage.

from snakemake.utils import min_version

min_version("9.27")


configfile: "config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/learning.smk"
include: "workflow/rules/growth.smk"
include: "workflow/rules/subgoal_frequencies.smk"
include: "workflow/rules/measures.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/fernandez_veloso.smk"
include: "workflow/rules/robustness.smk"
include: "workflow/rules/fit.smk"
include: "workflow/rules/explorer.smk"
include: "workflow/rules/products.smk"
include: "workflow/rules/benchmark.smk"


localrules:
    all,
    learning,
    growth,
    subgoal_frequencies,
    tables,
    figures,
    claims,
    explorer,
    fernandez_veloso,
    fernandez_veloso_learning,
    misleading_prior_learning,
    robustness,
    fit,
    benchmark,


rule all:
    default_target: True
    # The results come first: the products of the published run are tracked, so asking for them alone would be content
    # with what was checked out and run nothing.
    input:
        rules.learning.input,
        rules.growth.input,
        rules.subgoal_frequencies.input,
        rules.fernandez_veloso_learning.input,
        rules.misleading_prior_learning.input,
        rules.tables.input,
        rules.figures.input,
        rules.claims.input,
        rules.policy_reuse_table.output,
        rules.explorer.input,
        rules.front_page.output,
        rules.manifest.output,
