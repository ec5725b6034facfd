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
    results = Path(script.output.made).parent
    # later looks at the claims are taken only if one is open
    jobs = [job for job in script.jobs if getattr(job, "look", 1) == 1 or (results / job.place).exists()]
    write_made(script.output.made, params.asked, params.codes, jobs, manifest.products)
