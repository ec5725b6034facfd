"""Build the explorer from the learning files of some seeds."""

from ptl.files.atomic import write_text
from ptl.files.outside import configured
from ptl.report.explorer.data import collect
from ptl.report.explorer.page import build
from ptl.report.script import running

with running(snakemake) as script:
    kinds = {name: configured(*given) for name, given in snakemake.params.given.items()}
    data = collect(
        script.results(script.input), titles=script.titles, window=script.groups.measures.window, kinds=kinds
    )
    write_text(script.output[0], build(data))
