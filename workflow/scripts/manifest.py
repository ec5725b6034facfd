"""Write the manifest of all products: configuration, versions and checksums."""

from pathlib import Path

from ptl.files.aging import write_made
from ptl.files.atomic import write_text
from ptl.files.manifest import build, to_json
from ptl.report.script import running

with running(snakemake) as script:
    params = snakemake.params
    folder = Path(script.output.manifest).parent
    manifest = build(map(Path, script.input), folder, params.asked["config"], params.asked["maps"])
    write_text(script.output.manifest, to_json(manifest))
    write_made(script.output.made, params.asked, params.codes, script.jobs, manifest.products)
