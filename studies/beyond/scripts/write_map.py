"""Write a map of the population, or one of another format, as text with start and goals."""

from ptl.files.atomic import write_text
from ptl.report.script import running
from ptl.world.map_files import load_map
from studies.beyond.maps import checked_map

with running(snakemake) as script:
    world = load_map(script.input[0]) if script.input else checked_map(*snakemake.params.generated)
    write_text(script.output[0], world.text)
