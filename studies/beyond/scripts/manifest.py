"""Write the manifest of the products: configuration, versions and checksums."""

from pathlib import Path

from ptl.files.aging import write_made
from ptl.files.atomic import write_text
from ptl.files.manifest import build, to_json
from ptl.report.script import running

with running(snakemake) as script:
    params, path = snakemake.params, Path(script.output.manifest)
    manifest = build(map(Path, script.input), path.parent, params.asked["config"], params.asked["maps"])
    write_text(path, to_json(manifest))
    write_made(script.output.made, params.asked, params.codes, script.jobs, manifest.products)
