use super::*;
use crate::manifest;
use crate::manifest::schema::{self, DefaultValue, HOUSING_FILE, Key, Kind, MANIFEST, MODAL_FILE};
use std::path::{Path, PathBuf};

const QUICKSTART: &str = include_str!("../../../../manifests/quickstart.toml");

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The files made from the tables. ATLAS_WRITE_MANUAL=1 writes them again.
#[test]
fn the_written_manual_is_what_the_tables_say() {
    let files = [
        ("docs/manifest.md", page()),
        ("docs/manifest.schema.json", json_schema()),
    ];
    for (name, text) in files {
        let path: PathBuf = root().join(name);
        if std::env::var_os("ATLAS_WRITE_MANUAL").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let written = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            written == text,
            "{name} is not what the tables of keys say; write it again with\n    \
             ATLAS_WRITE_MANUAL=1 cargo test --release -p gearatlas-jobs manifest::manual"
        );
    }
}

#[test]
fn every_key_is_described() {
    for key in [MANIFEST, MODAL_FILE, HOUSING_FILE]
        .into_iter()
        .flat_map(schema::all)
    {
        assert_eq!(
            key.about.is_empty(),
            key.path.ends_with(".*"),
            "{}",
            key.path
        );
        let whole = key.about.is_empty() || key.about.ends_with('.');
        assert!(
            whole && !key.about.contains("  "),
            "{}: {}",
            key.path,
            key.about
        );
    }
}

#[test]
fn every_key_has_its_place_in_overview_page_and_help() {
    let (overview, page) = (overview(), page());
    for key in [MANIFEST, MODAL_FILE, HOUSING_FILE]
        .into_iter()
        .flat_map(schema::all)
    {
        if !words::stands_alone(key) {
            continue;
        }
        if key.kind != Kind::Table {
            let name = words::name(key);
            assert!(overview.contains(&format!("\n  {name} ")), "{}", key.path);
            assert!(page.contains(&format!("\n| `{name}` |")), "{}", key.path);
        }
        assert!(explain(key.path).is_ok(), "{}", key.path);
    }
}

#[test]
fn help_finds_what_is_meant() {
    let half_gap = explain("mesh.half_gap").unwrap();
    // The name alone finds all keys that have it.
    assert!(explain("half_gap").unwrap().contains(&half_gap));
    for part in [
        "mesh.half_gap",
        "length [m]",
        "m, cm, mm, um, nm",
        "greater than 0",
        "half_gap = \"15 um\"",
        "\"mesh.half_gap\" in [grid]",
    ] {
        assert!(half_gap.contains(part), "{part}: {half_gap}");
    }
    assert!(explain("[run]").unwrap().contains("transient"));
    assert!(explain("shafts").unwrap().contains("bearings"));
    assert!(
        explain("shafts.wheel.bearings.tilt.1")
            .unwrap()
            .contains("N*m/rad")
    );
    assert!(
        explain("gear.bore.0")
            .unwrap()
            .contains("as an axis  \"gear.bore.0\"")
    );
    let error = explain("mesh.half_gpa").unwrap_err();
    assert_eq!(error.nearest.as_deref(), Some("mesh.half_gap"));
    assert!(error.to_string().contains("did you mean `mesh.half_gap`?"));
    assert!(explain("").is_err() && explain("..").is_err());
}

/// A manifest of a train in which the key at `path` has an effect. All lists except `path` itself have an
/// entry with the required keys.
fn train(path: &str) -> String {
    let list = |of: &str, entries: &str| {
        let name = of.rsplit('.').next().unwrap();
        if path == of { String::new() } else { format!("{name} = [{entries}]") }
    };
    let join = |parts: &[String]| {
        let parts = parts.iter().filter(|part| !part.is_empty());
        parts.cloned().collect::<Vec<_>>().join(", ")
    };
    let gear = |name: &str, at: f64, teeth: u32| {
        format!("{{ name = \"{name}\", at = {at}, teeth = {teeth}, module = 3e-3, width = 0.02 }}")
    };
    let rolling = rolling(path);
    let in_bearing = path == "train.bearing_load" || path.contains(".bearings.*.");
    let bearing = match rolling {
        Some(rolling) if in_bearing => format!("{{ at = 0, {rolling} }}"),
        _ => "{ at = 0, x = 1e8, y = 1e8 }".to_owned(),
    };
    let own = if path.contains(".body") || path.contains(".loose") {
        "body = { polar_inertia = 1e-3 }, loose = { x = 1e8 }, "
    } else {
        ""
    }
    .replace(
        if path.ends_with("loose.x") || path.contains(".loose.") && rolling.is_some() {
            "x = 1e8"
        } else {
            "no"
        },
        rolling.unwrap_or("y = 1e8"),
    );
    let spare = join(&[
        "name = \"spare\"".to_owned(),
        list("train.shaft.*.sections", "{ length = 0.1, outer = 0.03 }"),
        list("train.shaft.*.discs", "{ at = 0, polar_inertia = 1e-3 }"),
        list("train.shaft.*.bearings", &bearing),
        list(
            "train.shaft.*.gears",
            &gear("spare gear", 0.05, 20).replacen('{', &format!("{{ {own}"), 1),
        ),
    ]);
    let shafts = [("one", 0.0, 20), ("two", 0.075, 30)].map(|(name, x, teeth)| {
        let gears = [
            gear(&format!("{name} a"), 0.0, teeth),
            gear(&format!("{name} b"), 0.05, teeth),
        ];
        let section = "sections = [{ length = 0.1, outer = 0.02 }]";
        let gears = gears.join(", ");
        format!("{{ name = \"{name}\", origin = [{x}, 0, 0], {section}, gears = [{gears}] }}")
    });
    let wave = "[{ harmonic = 1, amplitude = 1e-6 }]";
    let order = "[{ gear = \"driven\", order = 1, amplitude = 1e-6 }]";
    let waves = [
        ("stiffness_harmonics", wave),
        ("transmission_error", wave),
        ("gear_error", order),
    ]
    .map(|(name, wave)| {
        if path.starts_with(&format!("train.mesh.*.{name}.")) {
            format!("{name} = {wave}, ")
        } else {
            String::new()
        }
    })
    .concat();
    let mesh =
        format!("{{ {waves}gears = [\"one b\", \"two b\"], half_gap = 1e-5, stiffness = 3e8 }}");
    let stages = if path.starts_with("train.coupling.*.stages.") {
        "stages = [{ gap = 0.1, stiffness = 100 }], "
    } else if path.starts_with("train.coupling.*.hysteresis.") {
        "hysteresis = [{ stiffness = 100, limit = 1 }], "
    } else {
        ""
    };
    let engine =
        "{ name = \"engine\", origin = [0, 0, -0.1], discs = [{ at = 0, polar_inertia = 1 }] }";
    let lists = [
        format!(
            "shaft = [{{ {spare} }}, {}, {}, {engine}]",
            shafts[0], shafts[1]
        ),
        list("train.mesh", &mesh),
        list(
            "train.coupling",
            &format!("{{ {stages}shafts = [\"engine\", \"one\"], at = [0, 0] }}"),
        ),
        list(
            "train.stop",
            "{ shaft = \"two\", at = 0, direction = [0, 0, 1], gap = 1e-5, stiffness = 1e8 }",
        ),
    ];
    let (head, rest) = QUICKSTART.split_once("[gear]").unwrap();
    let (_, tail) = rest.split_once("[mesh]").unwrap();
    format!(
        "{}[train]\ngears = [\"one a\", \"two a\"]\nrated_torque = 50\n{}\n\n[mesh]{tail}",
        head.replacen("flexible", "train", 1),
        lists.join("\n"),
    )
}

/// The rolling elements that a key needs.
fn rolling(path: &str) -> Option<&'static str> {
    if path.contains(".ball.") || path == "train.bearing_load" {
        Some("ball = { count = 9, diameter = 0.01, pitch_diameter = 0.05 }")
    } else if path.contains(".roller.") {
        Some("roller = { count = 9, diameter = 0.01, length = 0.01, pitch_diameter = 0.05 }")
    } else {
        None
    }
}

/// A manifest with planets, without two of their keys, and with the rolling elements that the key at `path` needs.
fn planetary(path: &str) -> String {
    let text = include_str!("../../../../manifests/trains/planetary.toml");
    let (before, own) = text.split_once("[[train.planetary]]").unwrap();
    let bodies = if path.contains(".body.") { "body = { polar_inertia = 1e-3 }" } else { "" };
    let own = own.replacen("thinning = \"40 um\"\n", "", 1).replacen(
        "bore = \"24 mm\"\n",
        &format!("{bodies}\n"),
        1,
    );
    let own = rolling(path).map_or(own.clone(), |rolling| {
        let (head, rest) = own.split_once("bearing = {").unwrap();
        let (_, tail) = rest.split_once('}').unwrap();
        format!("{head}bearing = {{ {rolling} }}{tail}")
    });
    format!("{before}[[train.planetary]]{own}")
}

/// A manifest in which a key has an effect.
fn surroundings(path: &str) -> String {
    if path.starts_with("train.planetary.*.") {
        return planetary(path);
    }
    if path.starts_with("train.") {
        return analyses(&train(path), "");
    }
    // The lines of these keys are removed: the test compares their defaults with the absent keys.
    let given = ["pressure_angle =", "transient =", "cycles ="];
    let kept = |line: &&str| !given.iter().any(|key| line.starts_with(key));
    let lines: Vec<&str> = QUICKSTART.lines().filter(kept).collect();
    let mut text = analyses(&lines.join("\n"), "");
    let mut put = |from: &str, to: &str| {
        assert!(text.contains(from), "{path}: {from}");
        text = text.replacen(from, to, 1);
    };
    match path {
        "run.steps" => put("[run]", "[run]\nkernel = \"stepping\" #"),
        "mesh.oil_factor" => {
            let law = "friction_law = \"schlenk\"\nroughness = 5e-7\noil_viscosity = 0.02";
            put("[mesh]", &format!("[mesh]\n{law}"));
        }
        _ if path.starts_with("mesh.tooth_fault.") => {
            let fault = if path.ends_with("loss") { "stiffness = 0.5" } else { "loss = 1e-5" };
            let tooth = "gear = \"pinion\"\ntooth = 2";
            text.push_str(&format!("[[mesh.tooth_fault]]\n{tooth}\n{fault}\n"));
        }
        _ if path.starts_with("mesh.film") => {
            text.push_str("[mesh.film]\nviscosity = 0.03\n");
        }
        "mesh.misalignment" | "mesh.shaft_tilt" | "mesh.contact" | "mesh.face"
        | "mesh.resolution" | "mesh.slices" => {
            if path == "mesh.slices" {
                put("[mesh]", "[mesh]\nresolution = \"pairs\"");
            }
            put("stiffness = \"piecewise\"", "stiffness = \"table\"");
            for key in ["mean_stiffness", "contact_ratio", "single_pair_drop"] {
                put(&format!("\n{key} = "), &format!("\n# {key} = "));
            }
        }
        _ if path.starts_with("mesh.stiffness_harmonics") => {
            put("stiffness = \"piecewise\"", "stiffness = \"fourier\"");
            for key in ["contact_ratio", "single_pair_drop"] {
                put(&format!("\n{key} = "), &format!("\n# {key} = "));
            }
            if path != "mesh.stiffness_harmonics" {
                let wave = "stiffness_harmonics = [{ harmonic = 1, amplitude = 1e7 }]";
                put("[mesh]", &format!("[mesh]\n{wave} #"));
            }
        }
        "excitation.transmission_error" => put("\ntransmission_error", "\n# transmission_error"),
        _ if path.starts_with("excitation.coast_transmission_error.") => {
            let error = "[{ harmonic = 1, amplitude = 1 }]";
            put(
                "[excitation]",
                &format!("[excitation]\ncoast_transmission_error = {error} #"),
            );
        }
        _ if path.starts_with("excitation.gear_error.") => {
            let error = "[{ shaft = \"wheel\", order = 1, amplitude = 1 }]";
            put(
                "[excitation]",
                &format!("[excitation]\ngear_error = {error} #"),
            );
        }
        _ if path.starts_with("gear.profile_points.") => {
            let points = "roll_length = [0.014, 0.016, 0.02], missing = [0, 0, 1e-6]";
            put(
                "[gear]",
                &format!("[gear]\nprofile_points = [{{ gear = \"pinion\", {points} }}] #"),
            );
        }
        _ if path.starts_with("gear.lead_points.") => {
            let points = "place = [0, 0.002, 0.004], missing = [0, 0, 1e-6]";
            put(
                "[gear]",
                &format!("[gear]\nlead_points = [{{ gear = \"pinion\", {points} }}] #"),
            );
        }
        _ if path.starts_with("excitation.torque_ripple.") => {
            let ripple = "[{ shaft = \"wheel\", order = 1, amplitude = 1 }]";
            put(
                "[excitation]",
                &format!("[excitation]\ntorque_ripple = {ripple} #"),
            );
        }
        _ if path.starts_with("excitation.imposed_motion.") => {
            let motion = "[{ shaft = \"wheel\", order = 1, amplitude = 1 }]";
            put(
                "[excitation]",
                &format!("[excitation]\nimposed_motion = {motion} #"),
            );
        }
        _ if path.starts_with("excitation.torque_curve.") => {
            let points = "[{ angle = 0, torque = 1 }, { angle = 3, torque = 2 }]";
            text.push_str(&format!("[excitation.torque_curve]\npoints = {points}\n"));
        }
        "grid.design" => {
            let axis = "\"mesh.half_gap\" = { uniform = [\"10 um\", \"20 um\"] }";
            put("[grid]", &format!("[grid]\nsamples = 4\n{axis}"));
        }
        "grid.displacement" => put("[grid]", "[grid]\norder = \"sweep-up\"\nalong = \"speed\""),
        _ if path.starts_with("runup.") => {
            text.push_str("[runup]\nspeed = { from = 10, to = 20, in = 1 }\n");
        }
        "continuation.curves" => text.push_str("[continuation]\nsecond = \"load\"\n"),
        _ if path.starts_with("continuation.states.") => {
            let still = ["0"; 12].join(", ");
            let state = format!("at = 1000, displacement = [{still}], velocity = [{still}]");
            text.push_str(&format!("[continuation]\nstates = [{{ {state} }}]\n"));
        }
        _ => {}
    }
    text
}

/// The text with other analyses.
fn analyses(text: &str, tables: &str) -> String {
    let (head, _) = text.split_once("[analyses]").unwrap();
    format!("{head}[analyses]\n{tables}\n")
}

/// The text with a line in the table of a key; the table exists even if `line` is empty.
fn with(text: &str, key: &Key, line: &str) -> String {
    // A key of either shaft is tested in the table of the wheel's shaft.
    let path = key.path.replace("<shaft>", "wheel");
    let (table, name) = path.rsplit_once('.').unwrap();
    if let Some(own) = ["body", "loose", "ball", "roller"]
        .iter()
        .find(|own| table.ends_with(&format!(".{own}")))
    {
        let open = format!("{own} = {{");
        let comma = if line.is_empty() { "" } else { "," };
        return text.replacen(&open, &format!("{open} {line}{comma}"), 1);
    }
    if let Some(list) = table.strip_suffix(".*") {
        let header = format!("[[{list}]]");
        if text.contains(&header) {
            return text.replacen(&header, &format!("{header}\n{line}"), 1);
        }
        let open = format!("{} = [{{", list.rsplit('.').next().unwrap());
        assert!(text.contains(&open), "{}", key.path);
        let comma = if line.is_empty() { "" } else { "," };
        return text.replacen(&open, &format!("{open} {line}{comma}"), 1);
    }
    match table {
        "analyses.multistability.slice" => analyses(
            text,
            &format!("[analyses.multistability.slice]\nmodes = [3, 4]\nextent = 1e-5\n{line}"),
        ),
        "analyses.poincare.surface" => analyses(
            text,
            &format!(
                "[analyses.poincare]\nsection = \"surface\"\n[{table}]\ndisplacement = [1{}]\n{line}",
                ", 0".repeat(11)
            ),
        ),
        "analyses.horizon" | "analyses.covariant" => {
            analyses(text, &format!("lyapunov = {{}}\n[{table}]\n{line}"))
        }
        "grid.refine" => {
            let by = match key.path {
                "grid.refine.tolerance" => "by = [\"events_per_cycle\"]",
                _ => "",
            };
            format!("{text}\n[grid.refine]\nlevels = 1\n{by}\n{line}\n")
        }
        _ if table.ends_with("_relief") => {
            format!("{text}\n[{table}]\namount = 1e-6\nlength = 1e-3\n{line}\n")
        }
        _ if table.starts_with("analyses.") => analyses(text, &format!("[{table}]\n{line}")),
        _ if text.contains(&format!("[{table}]")) => {
            let header = format!("[{table}]");
            text.replacen(&header, &format!("{header}\n{line}\n#"), 1)
        }
        _ => format!("{text}\n[{table}]\n{line}  # {name}\n"),
    }
}

fn hash(text: &str) -> String {
    match manifest::parse(text, "test.toml", root()) {
        // Followed orbits and run-ups do not change results of a run, so the hash does not include them.
        Ok(job) => {
            let others = format!("{} {:?} {:?}", job.hash, job.continuation, job.run_up);
            blake3::hash(others.as_bytes()).to_string()
        }
        Err(errors) => errors.to_string(),
    }
}

/// The fault of the stated default `value` of a key, if any.
fn faults(text: &str, key: &Key, value: &str) -> Option<String> {
    let name = key.path.rsplit('.').next().unwrap();
    let with = |value: &str| hash(&with(text, key, &format!("{name} = {value}")));
    let (absent, written) = (hash(&self::with(text, key, "")), with(value));
    // The example values of these keys need further keys.
    let alone = !matches!(
        key.path,
        "analyses.poincare.refine"
            | "gear.thinning"
            | "train.shaft.*.gears.*.thinning"
            | "train.shaft.*.gears.*.profile_shift"
    );
    let valid = absent.len() == 64 && absent == written && (!alone || with(key.example) != absent);
    (!valid).then(|| format!("{}\nabsent: {absent}\nwritten: {written}", key.path))
}

/// Writing out a default changes nothing, and another value changes the hash.
#[test]
fn defaults_are_what_an_absent_key_resolves_to() {
    let keys = schema::all(MANIFEST).filter_map(|key| match key.default {
        DefaultValue::Value(value) => Some((key, value)),
        _ => None,
    });
    let keys: Vec<_> = keys.collect();
    assert!(keys.len() > 50, "{}", keys.len());
    let faults: Vec<String> = keys
        .into_iter()
        .filter_map(|(key, value)| faults(&surroundings(key.path), key, value))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Defaults that depend on other keys are described in words; these are their values.
#[test]
fn defaults_in_words_are_what_is_computed() {
    let short = |cycles: u64| {
        let run = format!("[run]\ncycles = {cycles} #");
        surroundings("").replacen("[run]", &run, 1)
    };
    let rigid = surroundings("")
        .replacen("\"flexible\"", "\"translational\"", 1)
        .replacen("modes = 12", "", 1);
    let usual = surroundings("");
    let stopped = usual.replacen(
        "[analyses]",
        "[analyses]\nlyapunov.stop_at_stderr = 0.01 #",
        1,
    );
    let elastic = usual.replacen("modes = 12", "", 1);
    let checks = [
        ("model.modes", elastic.as_str(), "40"),
        ("model.modes", &rigid, "6"),
        ("model.retained", &usual, "12"),
        ("run.audit_cycles", &usual, "20"),
        ("run.audit_cycles", &short(9), "9"),
        ("analyses.poincare.samples", &usual, "200"),
        ("analyses.poincare.samples", &short(90), "90"),
        ("analyses.multistability.transient", &usual, "200"),
        ("analyses.multistability.cycles", &usual, "4000"),
        ("run.cycles", &usual, "40000"),
        ("run.cycles", &stopped, "160000"),
        ("analyses.multistability.cycles", &short(90), "320"),
    ];
    let faults: Vec<String> = checks
        .iter()
        .filter_map(|(path, text, value)| {
            let key = schema::find(MANIFEST, path).unwrap();
            assert!(matches!(key.default, DefaultValue::Words(_)), "{path}");
            faults(text, key, value)
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
