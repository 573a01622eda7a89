"""The JSON Schema of robot files is in step with what reads them. Nothing here imports jax."""

import json
import pathlib
import re
import tomllib
from typing import Any

import jsonschema
import pytest

from cpr_jax.errors import InputError
from cpr_jax.robots.labels import parameter_dimensions
from cpr_jax.robots.reading import FORMAT, parse_specification
from cpr_jax.robots.schema import FILE, schema_text
from cpr_jax.robots.tables import CHOICES, KEYS

from .documents import DOCUMENTS, edited
from .test_malformed import MISTAKES

ROOT = pathlib.Path(__file__).parents[2]
SCHEMA = json.loads(schema_text())
DEFINITIONS = SCHEMA["$defs"]
CHECK = jsonschema.Draft202012Validator(SCHEMA)

# Mistakes in keys, words and kinds of values, as the reader words them.
STRUCTURE = re.compile(
    r"must be (one of the keys|'|a table of keys|a list with at least one entry|true or false)"
    r"|must be given alone|must be left out"
)


def test_it_is_a_schema_beside_the_reader() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert schema_text().isascii()
    assert SCHEMA["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert (ROOT / "cpr_jax" / "robots" / FILE).read_text(encoding="utf-8") == schema_text()


@pytest.mark.parametrize("kind", KEYS)
def test_keys_are_those_of_the_reader(kind: str) -> None:
    table = SCHEMA if kind == "file" else DEFINITIONS[kind]
    assert tuple(table["properties"]) == KEYS[kind]
    assert table["additionalProperties"] is False


def test_words_are_those_of_the_reader() -> None:
    words = {
        "geometry": SCHEMA["properties"]["geometry"]["enum"],
        "platform": DEFINITIONS["platform"]["properties"]["kind"]["enum"],
        "motor": DEFINITIONS["motor-kind"]["enum"],
        "joint": DEFINITIONS["joint-name"]["enum"],
        "moment_row": DEFINITIONS["legs"]["properties"]["moment_row"]["enum"],
        "section": [DEFINITIONS[k]["properties"]["kind"]["const"] for k in CHOICES["section"]],
    }
    assert {place: tuple(given) for place, given in words.items()} == CHOICES
    assert SCHEMA["properties"]["format"]["const"] == FORMAT


def test_every_reference_leads_somewhere() -> None:
    names = re.findall(r'"\$ref": "#/\$defs/([^"/]+)(?:/properties/([^"/]+))?"', schema_text())
    assert {name for name, _ in names} == set(DEFINITIONS)
    assert all(not key or key in DEFINITIONS[name]["properties"] for name, key in names)


def test_labels_of_uncertain_parameters() -> None:
    for geometry in ("plane", "space"):
        for label in parameter_dimensions(geometry, [1] * 11 + [11]):
            assert CHECK.evolve(schema=SCHEMA["properties"]["uncertainty"]).is_valid({label: 1.0})
    for label in ("k_b0", "base", "base1", "f_Q_y", "K_b1"):
        assert not CHECK.evolve(schema=SCHEMA["properties"]["uncertainty"]).is_valid({label: 1.0})


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.toml")), ids=lambda p: p.stem)
def test_examples_are_valid(path: pathlib.Path) -> None:
    CHECK.validate(tomllib.loads(path.read_text(encoding="utf-8")))
    assert path.read_text(encoding="utf-8").startswith(f"#:schema ../cpr_jax/robots/{FILE}\n")


@pytest.mark.parametrize("name", DOCUMENTS)
def test_good_documents_are_valid(name: str) -> None:
    CHECK.validate(tomllib.loads(DOCUMENTS[name]))


@pytest.mark.parametrize(
    ("document", "path", "value"),
    [
        ("point", "legs.0.base", ["−100 mm", " .1"]),
        ("point", "legs.0.rod.length", "+250mm"),
        ("body", "legs.1.motor", "prismatic"),
        ("body", "legs.1.joint.free", [False, 1.0, False]),
        ("body", "legs.1.a", [0.1, "-1 mm"]),
        ("space", "legs.0.rod.bending_stiffness", 1),
        ("motors", "home.rotation", ["1 deg", 0, 0]),
        ("motors", "legs.0.base_joint", "clamped"),
    ],
)
def test_both_accept(document: str, path: str, value: Any) -> None:
    mapping = edited(document, path, value)
    CHECK.validate(mapping)
    parse_specification(mapping)


def test_both_refuse_mistakes_of_structure() -> None:
    caught = 0
    for document, path, value, _ in MISTAKES:
        mapping = edited(document, path, value)
        with pytest.raises(InputError) as raised:
            parse_specification(mapping)
        if STRUCTURE.search(str(raised.value)):
            assert not CHECK.is_valid(mapping), (document, path, value)
            caught += 1
    assert caught > 60
