"""Write the manifest: the configuration, the versions of packages and a checksum of every product."""

import json
from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.manifest import build
from ptl.files.records import check_records
from ptl.report.job import running

with running(snakemake) as job:
    params = snakemake.params
    config = json.loads(params.config)
    check_records(Path(job.output.made).parent, job.input, config, params.asked, params.codes)
    folder = Path(job.output.manifest).parent
    manifest = build(map(Path, [*job.input, *params.study]), folder, config, params.maps)
    for path in (job.output.manifest, job.output.made):
        write_text(path, json.dumps(manifest, indent=1, sort_keys=True) + "\n")
    checked = Path(job.output.checked)
    for old in checked.parent.glob("*"):
        old.unlink()
    write_text(checked, manifest["content"] + "\n")
