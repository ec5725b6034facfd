"""The records for catalogues and journals: what their formats require, and that they agree with the files."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from projects import ROOT

from ptl.report import records

PUBLISHED = ROOT / "reports/published"
POPULATION = ROOT / "studies/beyond/config/population.croissant.json"


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def graph() -> dict[str, dict[str, Any]]:
    """Entities of the published crate by identifier."""
    crate = json.loads((PUBLISHED / records.CRATE).read_text(encoding="utf-8"))
    assert crate["@context"][0] == "https://w3id.org/ro/crate/1.1/context"
    entities = {entity["@id"]: entity for entity in crate["@graph"]}
    assert len(entities) == len(crate["@graph"]) and all("@type" in entity for entity in crate["@graph"])
    return entities


def references(value: Any) -> list[str]:
    """Identifiers that the values of an entity refer to."""
    if isinstance(value, list):
        return [name for item in value for name in references(item)]
    return [value["@id"]] if isinstance(value, dict) else []


def test_the_crate_describes_itself_and_its_root(graph):
    descriptor, root = graph["ro-crate-metadata.json"], graph["./"]
    assert descriptor["@type"] == "CreativeWork" and descriptor["about"] == {"@id": "./"}
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert root["@type"] == "Dataset" and {"name", "description", "datePublished", "license"} <= {*root}
    named = {name for entity in graph.values() for value in entity.values() for name in references(value)}
    assert named - {*graph} == {"https://w3id.org/ro/crate/1.1"}


def test_the_crate_has_every_product_with_its_checksum(graph):
    files = {name: entity for name, entity in graph.items() if entity["@type"] == "File"}
    assert {item["@id"] for item in graph["./"]["hasPart"]} == {*files}
    products = json.loads((PUBLISHED / "manifest.json").read_text())["products"]
    assert {*files} == {*products, "manifest.json"}
    for name, entity in files.items():
        assert entity["sha256"] == digest(PUBLISHED / name), f"{name}: run make docs"
        assert int(entity["contentSize"]) == (PUBLISHED / name).stat().st_size


@pytest.mark.skipif(not POPULATION.exists(), reason="the second study has been removed")
def test_the_record_of_the_maps_has_every_column_of_the_table():
    record = json.loads(POPULATION.read_text(encoding="utf-8"))
    assert record["conformsTo"] == "http://mlcommons.org/croissant/1.0" and record["@type"] == "sc:Dataset"
    [file], [rows] = record["distribution"], record["recordSet"]
    table = POPULATION.parent / file["contentUrl"]
    assert file["sha256"] == digest(table), "run: make docs"
    frame = pd.read_csv(table)
    kinds = {field["source"]["extract"]["column"]: field["dataType"] for field in rows["field"]}
    assert list(kinds) == list(frame.columns)
    wanted = {"sc:Integer": "i", "sc:Float": "f", "sc:Text": "O"}
    assert {column: wanted[kind] for column, kind in kinds.items()} == {c: frame[c].dtype.kind for c in frame}
    assert all(field["source"]["fileObject"] == {"@id": file["@id"]} for field in rows["field"])


def test_metadata_of_rescience_has_the_keys_of_its_template():
    text = (ROOT / "metadata.yaml").read_text(encoding="utf-8")
    assert text == records.rescience(), "run: make docs"
    metadata = yaml.safe_load(text)
    assert list(metadata) == [
        "title", "authors", "affiliations", "keywords", "code", "data", "replication", "abstract", "bibliography",
        "type", "domain", "language", "review", "contributors", "dates", "article", "journal",
    ]  # fmt: skip
    assert metadata["title"].startswith("[Re] ") and metadata["type"] == "Replication"
    assert metadata["replication"][3] == {"doi": "10.1177/1729881419831555"}
