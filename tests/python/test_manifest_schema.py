"""The JSON Schema of manifests, docs/manifest.schema.json: whatever the program accepts satisfies it,
and slips that one key shows are refused. `cargo test --lib manifest::manual` holds the file to the
tables of keys that it is written from.
"""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "docs/manifest.schema.json").read_text())
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)

SHIPPED = sorted(
    path for path in (ROOT / "manifests").rglob("*.toml") if not path.name.endswith((".modal.toml", ".housing.toml"))
)
# Bad manifests whose fault one key shows, and where it stands.
REFUSED = {
    "choices": {"model.kind"},
    "gear_form": {"gear", "gear.rack.tip_radius", "gear.tip_diameter", "gear.bore"},
    "grid_axis_value_out_of_range": {"grid.mesh.half_gap", "grid.mesh.friction"},
    "grid_keys": {"grid.load", "grid.speed"},
    "grid_unknown_axis": {"grid"},
    "missing_tables": {""},
    "multistability_ranges": {"analyses.multistability.decades"},
    "number_without_unit": {"mesh.half_gap", "grid.load"},
    "orbit_periods": {"analyses.orbits.periods.3"},
    "out_of_range": {"mesh.friction"},
    "unknown_key": {"mesh"},
    "unknown_table": {""},
    "unknown_unit": {"mesh.half_gap"},
    "wrong_types": {"mesh.half_gap"},
    "wrong_unit": {"mesh.half_gap"},
}


def faults(text: str) -> set[str]:
    """Paths of the values that the schema refuses."""
    errors = VALIDATOR.iter_errors(tomllib.loads(text))
    return {".".join(map(str, error.absolute_path)) for error in errors}


def quickstart(old: str, new: str) -> str:
    text = (ROOT / "manifests/quickstart.toml").read_text()
    assert old in text
    return text.replace(old, new, 1)


def test_the_schema_is_one():
    jsonschema.Draft7Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_manifests_satisfy_it_and_name_it(path):
    text = path.read_text()
    assert faults(text) == set()
    directive, _, named = text.splitlines()[0].partition(" ")
    assert directive == "#:schema"
    assert (path.parent / named).resolve() == ROOT / "docs/manifest.schema.json"


@pytest.mark.parametrize("name", REFUSED)
def test_bad_manifests_are_refused(name):
    text = (ROOT / f"tests/manifests/bad/{name}.toml").read_text()
    assert REFUSED[name] <= faults(text)


def test_defaults_and_examples_satisfy_their_keys():
    found = 0

    def walk(node):
        nonlocal found
        if isinstance(node, list):
            for child in node:
                walk(child)
        elif isinstance(node, dict):
            own = VALIDATOR.evolve(schema=node | {"definitions": SCHEMA["definitions"]})
            for value in [node[name] for name in ["default"] if name in node] + node.get("examples", []):
                own.validate(value)
                found += 1
            for child in node.values():
                walk(child)

    walk(SCHEMA["properties"])
    assert found > 150, found


@pytest.mark.parametrize(
    "text",
    ["15 um", "15um", "1.5e-5 m", "+15 µm", "0.015 mm", "1_5 um", "15 μm", "15 mm^1", 1.5e-5, 1],
)
def test_lengths_that_the_program_reads_are_accepted(text):
    assert faults(quickstart('half_gap = "10 um"', f"half_gap = {json.dumps(text)}")) == set()


@pytest.mark.parametrize("text", ["15", "15 N", "15 furlong", "15,0 um", "um", "-1 m s", True, 0, -1.0])
def test_lengths_that_it_refuses_are_refused(text):
    found = faults(quickstart('half_gap = "10 um"', f"half_gap = {json.dumps(text)}"))
    assert found == {"mesh.half_gap"}


@pytest.mark.parametrize(
    "axis",
    [
        'speed = "11460 rpm"',
        'speed = { values = ["100 Hz", 700, "10 rev/s"] }',
        'speed = { from = 600, to = "1500 rad/s", count = 3, spacing = "log" }',
        'speed = 600\n"mesh.half_gap" = { values = ["5 um", 1e-5] }',
        'speed = 600\n"shafts.wheel.bearings.y.1" = "1 kN/mm"',
        'speed = 600\n"gear.teeth.0" = { values = [19, 20] }',
        'speed = 600\n"excitation.transmission_error.0.amplitude" = 5e-6',
        'speed = 600\n"mesh.contact_damping" = { values = ["5 %", "7 %"] }',
    ],
)
def test_axes_are_accepted(axis):
    assert faults(quickstart("speed = {", f"{axis}\n#")) == set()


@pytest.mark.parametrize(
    "axis",
    [
        "",
        "speed = []",
        "speed = { values = [] }",
        "speed = { from = 600, to = 700 }",
        "speed = { values = [600], count = 1 }",
        'speed = 600\n"mesh.half_gpa" = 1e-5',
        'speed = 600\n"mesh.stiffness" = "table"',
        'speed = 600\n"gear.teeth.0" = 19.5',
        'speed = 600\n"shafts.third.span" = 0.1',
    ],
)
def test_bad_axes_are_refused(axis):
    assert faults(quickstart("speed = {", f"{axis}\n#"))


def test_a_key_that_an_axis_gives_may_be_absent():
    text = quickstart('half_gap = "10 um"', "").replace(
        "[grid]", '[grid]\n"mesh.half_gap" = { values = [1e-5] }'
    )
    assert faults(text) == set()
