"""Count the operations of a skill selection and the bytes of a library, against their sizes."""

from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.study.library_cost import library_bytes, selection_operations

with running(snakemake) as job:
    states = sorted({world.n_states for world in job.worlds.values()})
    write_csv(selection_operations(), job.output.selection, sealed=True)
    write_csv(library_bytes(states), job.output.storage, sealed=True)
