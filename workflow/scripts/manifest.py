"""Hold products against their run and write the manifest: configuration, versions and checksums of products."""

import json
from pathlib import Path

from ptl.files.atomic import write_text
from ptl.files.manifest import build
from ptl.files.records import check_records
from ptl.report.job import running

with running(snakemake) as job:
    params = snakemake.params
    config = json.loads(params.config)
    check_records(Path("results", config["run"]), job.input, config, params.asked, params.codes)
    folder = Path("reports", config["run"])
    manifest = build(map(Path, [*job.input, *params.get("study", ())]), folder, config, params.maps)
    for path in job.output[:-1]:
        write_text(path, json.dumps(manifest, indent=1, sort_keys=True) + "\n")
    checked = Path(job.output.checked)
    for old in checked.parent.glob("*"):
        old.unlink()
    write_text(checked, manifest["content"] + "\n")
