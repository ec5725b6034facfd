"""In what share of samples of the article's 30 runs each claim would be printed, in the reference setting."""

from ptl.config import Configuration
from ptl.files.csv import write_csv
from ptl.measures.statistics import named_generator
from ptl.report.script import running
from studies.multiverse.judging import replicated, settings_in

with running(snakemake) as script:
    run = Configuration.from_dict(snakemake.params.run)
    [result] = script.results(script.input)
    [setting] = settings_in(result, run)
    random = named_generator("multiverse", "printed", setting.name)
    write_csv(replicated(setting, snakemake.params.replicates, random), script.output.printed)
