"""Build the explorer of the second study from one life of some methods on a few maps."""

from ptl import methods
from ptl.config import Measures
from ptl.files.atomic import write_text
from ptl.report.explorer.data import collect
from ptl.report.explorer.page import build
from ptl.report.script import running
from studies.beyond.design import SecondStudy
from studies.beyond.page import FAMILY_TITLES
from studies.beyond.planned import population_of, shown

with running(snakemake) as script:
    study = SecondStudy.read(snakemake.params.study)
    kinds = {job.method: methods.load(job.reference) for job in script.jobs}
    window = min(Measures().window, study.learning.episodes)
    population = population_of(study)
    titles = {population[place].name: f"{FAMILY_TITLES[place[0]]}, map {place[1]}" for place in shown(study)}
    data = collect(script.results(script.input), window=window, titles=titles, kinds=kinds)
    write_text(script.output[0], build(data))
