"""Records of the published run for catalogues and journals: RO-Crate, Croissant and the metadata of ReScience C.

All are made from ``CITATION.cff``, a manifest and the files themselves by ``ptl docs``. The formats are those of
RO-Crate 1.1 (https://w3id.org/ro/crate/1.1), Croissant 1.0 (http://mlcommons.org/croissant/1.0) and the template of
ReScience C (https://github.com/ReScience/template).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ptl.files.manifest import MANIFEST, read
from ptl.files.regular import sha256

ROOT = Path(__file__).parents[2]
ARTICLE = "https://doi.org/10.1177/1729881419831555"
LICENCE = "https://spdx.org/licenses/MIT"

CRATE = "ro-crate-metadata.json"
"""Name of the record in a report folder, which RO-Crate prescribes."""

FORMATS = {
    ".csv": "text/csv", ".gz": "application/gzip", ".html": "text/html", ".json": "application/json",
    ".md": "text/markdown", ".png": "image/png", ".rst": "text/x-rst", ".svg": "image/svg+xml", ".tex": "text/x-tex",
}  # fmt: skip
"""Media types of products by the suffix of the file."""


def citation() -> dict[str, Any]:
    """Return the contents of ``CITATION.cff`` in the checkout."""
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def ro_crate(folder: Path) -> str:
    """Return the RO-Crate of a report folder: every product with its size and checksum, and what made it.

    Raises
    ------
    UserError
        If the folder has no manifest.
    """
    manifest, cited = read(folder / MANIFEST), citation()
    products = {**manifest.products, MANIFEST: sha256(folder / MANIFEST)}
    files = [
        {
            "@id": name,
            "@type": "File",
            "name": name,
            "encodingFormat": FORMATS[Path(name).suffix],
            "contentSize": str((folder / name).stat().st_size),
            "sha256": digest,
        }
        for name, digest in sorted(products.items())
    ]
    software = [
        {"@id": f"#{name}", "@type": "SoftwareApplication", "name": name, "version": version}
        for name, version in sorted(manifest.versions.items())
    ]
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Products of the run {manifest.config['run']} of {cited['title']}",
        "description": " ".join(cited["abstract"].split()),
        "datePublished": str(cited["date-released"]),
        "license": {"@id": LICENCE},
        "author": {"@id": "#authors"},
        "version": cited["version"],
        "keywords": ", ".join(cited["keywords"]),
        "isBasedOn": {"@id": ARTICLE},
        "mentions": {"@id": "#run"},
        "hasPart": [{"@id": file["@id"]} for file in files],
    }
    graph = [
        {
            "@id": CRATE,
            "@type": "CreativeWork",
            "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
            "about": {"@id": "./"},
        },
        root,
        {"@id": LICENCE, "@type": "CreativeWork", "name": "MIT License", "identifier": "MIT"},
        {"@id": "#authors", "@type": "Organization", "name": cited["authors"][0]["name"]},
        {"@id": ARTICLE, "@type": "ScholarlyArticle", "name": "The article that is reproduced", "identifier": ARTICLE},
        {
            "@id": "#run",
            "@type": "CreateAction",
            "name": "make reproduce",
            "instrument": [{"@id": item["@id"]} for item in software],
            "result": {"@id": "./"},
        },
        *software,
        *files,
    ]
    # the context of RO-Crate 1.1 is older than this term of schema.org
    context = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "https://schema.org/sha256"}]
    return _text({"@context": context, "@graph": graph})


def croissant(table: Path, name: str, description: str, columns: Mapping[str, tuple[str, str]]) -> str:
    """Return the Croissant record of a CSV table, which lies beside the record.

    Parameters
    ----------
    columns : mapping
        Type (``sc:Text``, ``sc:Integer`` or ``sc:Float``) and meaning of each column.
    """
    cited = citation()
    file = {
        "@type": "cr:FileObject",
        "@id": table.name,
        "name": table.name,
        "contentUrl": table.name,
        "contentSize": f"{table.stat().st_size} B",
        "encodingFormat": "text/csv",
        "sha256": sha256(table),
    }
    fields = [
        {
            "@type": "cr:Field",
            "@id": f"{name}/{column}",
            "name": column,
            "description": meaning,
            "dataType": kind,
            "source": {"fileObject": {"@id": table.name}, "extract": {"column": column}},
        }
        for column, (kind, meaning) in columns.items()
    ]
    return _text(
        {
            "@context": _CROISSANT,
            "@type": "sc:Dataset",
            "conformsTo": "http://mlcommons.org/croissant/1.0",
            "name": name,
            "description": description,
            "license": LICENCE,
            "creator": {"@type": "sc:Organization", "name": cited["authors"][0]["name"]},
            "datePublished": str(cited["date-released"]),
            "version": cited["version"],
            "citeAs": f"{cited['title']}, version {cited['version']}",
            "distribution": [file],
            "recordSet": [{"@type": "cr:RecordSet", "@id": name, "name": name, "field": fields}],
        }
    )


_CROISSANT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "dct": "http://purl.org/dc/terms/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "recordSet": "cr:recordSet",
    "source": "cr:source",
}
"""The terms of Croissant that the record uses."""


def rescience() -> str:
    """Return ``metadata.yaml`` of a submission to ReScience C; what only its authors know is left empty."""
    cited = citation()
    content = {
        "title": f"[Re] {cited['title'].partition(' for ')[2].capitalize()}",
        "authors": [{"name": cited["authors"][0]["name"], "orcid": None, "email": None, "affiliations": "1,*"}],
        "affiliations": [{"code": 1, "name": None, "address": None}],
        "keywords": f"rescience c, {', '.join(cited['keywords'])}, python",
        "code": [{"url": cited.get("repository-code")}, {"doi": None}, {"swh": None}],
        "data": [{"url": None}, {"doi": None}],
        "replication": [
            {"cite": "International Journal of Advanced Robotic Systems, 2019; authors and title as its DOI says"},
            {"bib": None},
            {"url": ARTICLE},
            {"doi": ARTICLE.removeprefix("https://doi.org/")},
        ],
        "abstract": " ".join(cited["abstract"].split()),
        "bibliography": None,
        "type": "Replication",
        "domain": "Reinforcement Learning",
        "language": "Python",
        "review": [{"url": None}],
        "contributors": [{"name": None, "orcid": None, "role": role} for role in ("editor", "reviewer", "reviewer")],
        "dates": [{"received": None}, {"accepted": None}, {"published": None}],
        "article": [{"number": None}, {"doi": None}, {"url": None}],
        "journal": [{"name": "ReScience C"}, {"issn": "2430-3658"}, {"volume": None}, {"issue": None}],
    }
    head = "# Metadata of a submission to ReScience C, made by `ptl docs` from CITATION.cff; fill in what is empty.\n"
    return head + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=110).replace(" null\n", "\n")


def _text(content: Mapping[str, Any]) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"
