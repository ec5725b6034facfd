"""Write the manifest: the configuration, the versions of packages and a checksum of every product."""

import json
from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.manifest import build
from ptl.report.job import running

with running(snakemake) as job:
    folder = Path(job.output.manifest).parent
    manifest = build(map(Path, job.input), folder, json.loads(snakemake.params.config))
    for path in job.output:
        write_text(Path(path), json.dumps(manifest, indent=1, sort_keys=True) + "\n")
