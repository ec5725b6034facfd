"""Build the explorer of the second study from one life of some methods on a few maps."""

from ptl import methods
from ptl.config import Measures
from ptl.files.atomic import write_text
from ptl.report.explorer.data import collect
from ptl.report.explorer.page import build
from ptl.report.script import running
from studies.beyond.design import Study, shown
from studies.beyond.methods import reference
from studies.beyond.page import FAMILY_TITLES

with running(snakemake) as script:
    study = Study.read(snakemake.params.study)
    kinds = {methods.identifier(name): methods.load(name) for name in map(reference, study.explorer.methods)}
    window = min(Measures().window, study.learning.episodes)
    titles = {name: f"{FAMILY_TITLES[family]}, map {seed}" for name, (family, seed) in shown(study).items()}
    write_text(script.output[0], build(collect(script.input, window=window, titles=titles, kinds=kinds)))
