"""Judge the claims after a look, and write which environments and methods need more runs."""

import json

from ptl.claims import judge
from ptl.claims.decision import confidence_at, evidence_of, open_pairs
from ptl.files.atomic import write_text
from ptl.report.script import running

with running(snakemake) as script:
    look, looks = int(snakemake.wildcards.look), script.groups.decision.looks
    confidence = confidence_at(look, looks, script.groups.statistics.confidence)
    judgements = judge(evidence_of(script.results(script.input), script.groups, confidence))
    pairs = open_pairs(judgements) if look < len(looks) else set()
    content = {"look": look, "runs": looks[look - 1], "confidence": confidence, "open": sorted(pairs)}
    write_text(script.output.open, json.dumps(content, indent=1) + "\n")
