"""Write the manifest: the configuration, the versions of packages and a checksum of every product."""

import json
from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.manifest import build
from ptl.report.job import running

with running(snakemake) as job:
    [output] = map(Path, job.output)
    manifest = build(map(Path, job.input), output.parent, json.loads(snakemake.params.config))
    write_text(output, json.dumps(manifest, indent=1, sort_keys=True) + "\n")
