"""Count the operations of a skill selection and the bytes of a library, against their sizes."""

from ptl.files.csv import write_csv
from ptl.measures.library_cost import library_bytes, selection_operations
from ptl.report.script import running

with running(snakemake) as script:
    states = sorted({world.n_states for world in script.worlds.values()})
    write_csv(selection_operations(), script.output.selection)
    write_csv(library_bytes(states), script.output.storage)
