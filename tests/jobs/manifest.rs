//! Valid manifests: how they resolve, how grids expand, and which keys the hash includes.

#![allow(clippy::unwrap_used)]

use gearatlas::analysis::Effort;
use gearatlas::gear::{BasicRack, Material, Relief, ToothForm};
use gearatlas::manifest::{
    self, CoastSpec, DampingSpec, Diagnostic, DiagnosticKind, FrictionSpec, Job, ManifestErrors,
    PointSpec, StiffnessSpec, StructureSource,
};
use gearatlas::model::{DriveShaft, InitialState, MeshHarmonic, Release};
use gearatlas::propagate::{KernelChoice, KernelSetting};
use std::path::Path;
use std::sync::Arc;

const MODAL: &str = include_str!("../manifests/modal.toml");

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/manifests")
}

fn parse(text: &str) -> Result<Job, ManifestErrors> {
    manifest::parse(text, "test.toml", &folder())
}

fn job(text: &str) -> Job {
    parse(text).unwrap_or_else(|errors| panic!("{errors}"))
}

fn shipped(name: &str) -> Job {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("manifests")
        .join(name);
    manifest::load(&path).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The text with one piece replaced; the piece must be there.
fn with(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "`{from}` is not in the manifest");
    text.replacen(from, to, 1)
}

#[test]
fn flex80_is_the_default_drive() {
    let job = shipped("flex80.toml");
    assert_eq!(
        (job.name.as_str(), job.seed, job.points.len()),
        ("flex80", 1, 80)
    );
    let names: Vec<_> = job
        .axes
        .iter()
        .map(|a| (a.name(), a.unit.as_str()))
        .collect();
    assert_eq!(names, [("load", "1"), ("speed", "rad/s")]);
    assert_eq!(
        job.axes[1].values.iter().collect::<Vec<f64>>(),
        [
            600., 700., 800., 900., 1000., 1100., 1200., 1300., 1400., 1500.
        ]
    );
    let point = &job.points.at(0);
    let StructureSource::Flexible(drive) = &point.model.source else {
        panic!("not a flexible drive");
    };
    assert_eq!(drive.gears.teeth, [20, 30]);
    assert!((drive.gears.rated_force() - 1330.2).abs() < 0.1);
    assert_eq!(drive.gears.body_length, [0.07, 0.04]);
    assert_eq!(drive.shafts[0].diameter, 0.022);
    assert_eq!(drive.shafts[1].end_inertia, 5e-3);
    for shaft in &drive.shafts {
        assert_eq!(
            (shaft.span, shaft.overhang, shaft.gear_position),
            (0.12, 0.04, 0.45)
        );
        let [first, second] = shaft.bearings;
        assert_eq!((first.x, first.y, first.tilt), (1.25e8, 1e8, 2e4));
        assert_eq!((first.axial, second.axial), (1e8, 0.0));
        assert_eq!(second.tilt, 2e4);
    }
    assert_eq!(
        (drive.young_modulus, drive.shear_modulus, drive.density),
        (206e9, 79e9, 7850.0)
    );
    assert_eq!((drive.elements, drive.damping), ([3, 5, 7], 0.01));
    assert_eq!(
        (point.model.modes, point.model.retained, point.model.mta),
        (40, 40, false)
    );
    assert_eq!(point.mesh.half_gap, 1e-5);
    assert_eq!(point.mesh.damping, DampingSpec::Coefficient(1483.0));
    let StiffnessSpec::Piecewise(values) = &point.mesh.stiffness else {
        panic!("not piecewise");
    };
    assert_eq!(values.len(), 60);
    assert!((values[35] - 4.444e8).abs() < 1e5 && (values[36] - 3.333e8).abs() < 1e5);
    assert_eq!(
        point.run.kernel,
        KernelSetting::Named(KernelChoice::Volterra)
    );
    assert_eq!((point.run.transient, point.run.cycles), (500, 160_000));
    assert_eq!(point.analyses.lyapunov.unwrap().stop_at_stderr, Some(0.01));
    assert_eq!(point.analyses.poincare.as_ref().unwrap().samples, 200);
    assert_eq!(point.analyses.nvh.unwrap().harmonics, 10);
}

#[test]
fn points_are_row_major_and_share_the_structure() {
    let job = shipped("flex80.toml");
    let StructureSource::Flexible(first) = &job.points.at(0).model.source else {
        panic!("not a flexible drive");
    };
    for (i, point) in job.points.iter().enumerate() {
        assert_eq!(point.point_id, i as u64);
        assert_eq!(point.load, job.axes[0].values.get(i / 10));
        assert_eq!(point.speed, job.axes[1].values.get(i % 10));
        assert_eq!(point.axis_values, [point.load, point.speed]);
        let StructureSource::Flexible(drive) = &point.model.source else {
            panic!("not a flexible drive");
        };
        assert!(Arc::ptr_eq(first, drive));
    }
}

#[test]
fn a_modal_file_is_the_structure() {
    let job = job(MODAL);
    let StructureSource::Modal(structure) = &job.points.at(0).model.source else {
        panic!("not modal");
    };
    assert_eq!(structure.frequency, [0.0, 0.0, 4452.8]);
    assert_eq!((structure.teeth, structure.wheel_teeth), (20, None));
    assert_eq!(structure.friction, [0.0; 3]);
    assert_eq!(structure.pinion_torque, None);
    assert_eq!(job.points.at(0).model.retained, 3);
    assert_eq!(
        job.points.at(0).mesh.stiffness,
        StiffnessSpec::Constant(4e8)
    );
}

#[test]
fn no_rigid_mode_of_a_modal_file_may_be_dropped() {
    let retained = |count: usize| {
        let kind = format!("kind = \"modal\"\nretained = {count}");
        parse(&with(MODAL, "kind = \"modal\"", &kind))
    };
    assert_eq!(retained(2).unwrap().points.at(0).model.retained, 2);
    let errors = retained(1).unwrap_err();
    assert_eq!(errors.diagnostics[0].key, "model.retained");
}

/// The manifest with the drawing of the quickstart's gears.
fn with_gear(text: &str) -> String {
    let quickstart = include_str!("../../manifests/quickstart.toml");
    let (_, gear) = quickstart.split_once("\n[gear]").unwrap();
    let (gear, _) = gear.split_once("\n[shafts]").unwrap();
    with(text, "[mesh]", &format!("[gear]{gear}\n[mesh]"))
}

/// A modal file has no drawing; only friction uses one.
#[test]
fn friction_has_its_drawing_beside_a_modal_file() {
    let law = "friction_law = \"schlenk\"\nroughness = \"0.5 um\"\noil_viscosity = \"20 mPa*s\"";
    let rubbing = with(MODAL, "[mesh]", &format!("[mesh]\n{law}"));
    let FrictionSpec::Mean { gears, .. } = &job(&with_gear(&rubbing)).points.at(0).mesh.friction
    else {
        panic!("a constant coefficient");
    };
    assert_eq!(gears.teeth, [20, 30]);
    let said = parse(&rubbing).unwrap_err().to_string();
    assert!(said.contains("pair on parallel axes"), "{said}");
    assert_eq!(idle(&with_gear(MODAL)), ["gear"]);
    let constant = with(MODAL, "[mesh]", "[mesh]\nfriction = 0.05");
    let mesh = &job(&with_gear(&constant)).points.at(0).mesh;
    // ε and g_f/p_b of 20/30 teeth of 20 deg with a whole addendum.
    let pairs = mesh.sliding.unwrap();
    assert!((pairs.contact_ratio - 1.605_176_092_139_061_6).abs() < 1e-12);
    assert!((pairs.pitch_phase - 0.826_756_940_451_482_4).abs() < 1e-12);
    let said = parse(&constant).unwrap_err().to_string();
    assert!(
        said.contains("pitch point") && said.contains("[gear]"),
        "{said}"
    );
    let none = with(MODAL, "[mesh]", "[mesh]\nfriction = 0");
    assert_eq!(job(&none).points.at(0).mesh.sliding, None);
}

/// Pairs share the load while the law of two levels has two of them in contact; a drawing determines the rest.
#[test]
fn friction_steps_where_the_stiffness_of_two_levels_does() {
    let ratio = |text: &str| {
        job(text)
            .points
            .at(0)
            .mesh
            .sliding
            .map(|own| own.contact_ratio)
    };
    let flex80 = include_str!("../../manifests/flex80.toml");
    assert_eq!(ratio(flex80), Some(1.6));
    let drawn = ratio(
        &with(
            &with(flex80, "contact_ratio = 1.6", ""),
            "mean_stiffness = \"4e8 N/m\"\n",
            "values = [\"4e8 N/m\", \"3e8 N/m\"]\n",
        )
        .lines()
        .filter(|line| !line.starts_with("single_pair_drop") && !line.starts_with("segments"))
        .map(|line| format!("{line}\n"))
        .collect::<String>(),
    );
    assert!((drawn.unwrap() - 1.605_176_092_139_061_6).abs() < 1e-12);
    assert_eq!(
        ratio(&with(flex80, "friction = 0.05", "friction = 0")),
        None
    );
    assert_eq!(
        ratio(include_str!("../../manifests/flex80-table.toml")),
        None
    );
}

/// Round-off of an eigenvalue solver in frequency and damping of a rigid motion counts as zero.
#[test]
fn round_off_of_a_rigid_motion_is_none() {
    let modal = "teeth = 20\nrated_force = 1330.0\nfrequency = [5e-13, 1e-12, 4452.8]\ndamping = [0.0, 0.0, 0.01]\n\
                 mesh = [1.3, 0.2, 0.3]\ntorque = [1.3, 0.2, 0.3]\n\
                 damping_matrix = [[3e-31, 0, 8e-15], [0, 0, 0], [8e-15, 0, 40.0]]\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("oscillator.modal.toml"), modal).unwrap();
    let job = manifest::parse(MODAL, "test.toml", folder.path());
    let job = job.unwrap_or_else(|errors| panic!("{errors}"));
    let StructureSource::Modal(structure) = &job.points.at(0).model.source else {
        panic!("not modal");
    };
    assert_eq!(structure.frequency, [0.0, 0.0, 4452.8]);
    let damping = &structure.coupling.as_ref().unwrap().damping;
    assert_eq!(damping, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 40.0]);
}

#[test]
fn the_matrices_of_a_modal_file_couple_its_modes() {
    let modal = include_str!("../manifests/oscillator.modal.toml");
    let read = |more: &str| {
        let folder = tempfile::tempdir().unwrap();
        let content = format!("{modal}\n{more}\n");
        std::fs::write(folder.path().join("oscillator.modal.toml"), content).unwrap();
        let job = manifest::parse(MODAL, "test.toml", folder.path())
            .unwrap_or_else(|errors| panic!("{errors}"));
        let StructureSource::Modal(structure) = &job.points.at(0).model.source else {
            panic!("not modal");
        };
        ((**structure).clone(), job.hash)
    };
    let (plain, hash) = read("");
    let (zeros, same) =
        read("constant_load = [0, 0, 0]\ndamping_matrix = [[0,0,0],[0,0,0],[0,0,0]]");
    assert_eq!(zeros, plain);
    assert_eq!(hash, same);
    assert!(
        plain.coupling.is_none()
            && plain.constant_load.is_empty()
            && plain.load_by_speed.is_empty()
    );
    let (found, other) = read(
        "damping_matrix = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]\n\
         gyroscopic_matrix = [[0, 0.5, 0.25], [-0.5, 0, 0.1], [-0.25, -0.1000001, 0]]\n\
         load_by_speed = [0, 0.02, 0.01]",
    );
    assert_ne!(hash, other);
    let coupling = found.coupling.unwrap();
    assert_eq!(coupling.damping, [1., 2., 3., 4., 5., 6., 7., 8., 9.]);
    assert_eq!(coupling.stiffness, [0.0; 9]);
    // The file has few digits, but the matrix is exactly skew-symmetric.
    assert!((coupling.gyroscopic[5] - 0.10000005).abs() < 1e-15);
    assert_eq!(coupling.gyroscopic[7], -coupling.gyroscopic[5]);
    assert_eq!(found.load_by_speed, [0.0, 0.02, 0.01]);
    assert!(found.constant_load.is_empty());
}

#[test]
fn what_damps_and_couples_shafts_is_read() {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/flex80.toml"),
    )
    .unwrap();
    let text = with(&text, "modes = 40", "modes = 40\ngyroscopic = true");
    let text = with(
        &text,
        "axial = [\"1e8 N/m\", 0]",
        "axial = [\"1e8 N/m\", 0]\ndamping_x = \"400 N*s/m\"\ndamping_y = [300, 200]\n\
         cross_xy = [2e6, 0]\ncross_yx = [-2e6, 0]\ndamping_xy = -20\ndamping_yx = -10",
    );
    let text = with(
        &text,
        "\"26 mm\"",
        "\"26 mm\"\ndrag = \"2 N*mm*s/rad\"\ndrag_torque = \"0.4 N*m\"\nbearings.damping_x = 100",
    );
    let job = job(&text);
    let StructureSource::Flexible(drive) = &job.points.at(0).model.source else {
        panic!("not a flexible drive");
    };
    assert!(drive.gyroscopic);
    let [pinion, wheel] = &drive.shafts;
    let bearings = [pinion.bearings[0], pinion.bearings[1], wheel.bearings[1]];
    assert_eq!(
        bearings.map(|bearing| bearing.damping),
        [(400.0, 300.0), (400.0, 200.0), (100.0, 200.0)].map(|(x, y)| [[x, -20.0], [-10.0, y]])
    );
    assert_eq!(
        bearings.map(|bearing| bearing.cross),
        [[2e6, -2e6], [0.0; 2], [0.0; 2]]
    );
    assert_eq!((pinion.drag.viscous, pinion.drag.constant), (0.0, 0.0));
    assert_eq!((wheel.drag.viscous, wheel.drag.constant), (2e-3, 0.4));
}

#[test]
fn defaults_are_the_documented_ones() {
    let job = job(MODAL);
    let run = &job.points.at(0).run;
    // If no rule ends a point earlier, it has the cycles of the first look at verified errors.
    let cycles = Effort::Verified.first_look();
    assert_eq!((job.seed, run.transient, run.cycles), (1, 200, cycles));
    assert_eq!((run.audit_cycles, run.event_limit), (20, 1000));
    assert_eq!(run.initial, InitialState::Static);
    assert_eq!(run.kernel, KernelSetting::Auto);
    let analyses = &job.points.at(0).analyses;
    assert!(analyses.lyapunov.is_none() && analyses.poincare.is_none() && analyses.nvh.is_none());
    let all = job_with(
        "[grid]",
        "[analyses]\nlyapunov = {}\npoincare = {}\nnvh = {}\n\n[grid]",
    );
    let analyses = &all.points.at(0).analyses;
    let lyapunov = analyses.lyapunov.unwrap();
    assert_eq!(
        (lyapunov.exponents, lyapunov.align, lyapunov.twin),
        (1, 100, true)
    );
    assert_eq!(lyapunov.stop_at_stderr, None);
    let evidence = (lyapunov.effort, lyapunov.lifetime, lyapunov.chains);
    assert_eq!(evidence, (Effort::Verified, None, false));
    assert_eq!(analyses.poincare.as_ref().unwrap().samples, 200);
    let nvh = analyses.nvh.unwrap();
    assert_eq!((nvh.harmonics, nvh.stop_at_stderr), (10, None));
    let asked = job_with(
        "[grid]",
        "[analyses]\nnvh = { stop_at_stderr = 0.03 }\n\n[grid]",
    );
    let point = asked.points.at(0);
    let nvh = point.analyses.nvh.unwrap();
    assert_eq!(nvh.stop_at_stderr, Some(0.03));
    // A rule ends points, so that the limit of cycles is higher.
    assert_eq!(point.run.cycles, 160_000);
    let precise = job_with(
        "[grid]",
        "[analyses]\nlyapunov = { stop_at_stderr = 0.01, lifetime = 20000, effort = \"survey\", chains = true }\n\n[grid]",
    );
    let point = precise.points.at(0);
    let lyapunov = point.analyses.lyapunov.unwrap();
    let evidence = (lyapunov.effort, lyapunov.lifetime, lyapunov.chains);
    assert_eq!(evidence, (Effort::Survey, Some(20_000), true));
    assert_eq!(point.run.cycles, 160_000);
    assert_ne!(asked.hash, all.hash);
}

/// Every kernel by name, its settings, and its separate hash.
#[test]
fn kernels_are_named_in_the_manifest() {
    let mut hashes = Vec::new();
    for (settings, kernel) in [
        ("\"volterra\"", KernelChoice::Volterra),
        ("\"closed_modes\"", KernelChoice::ClosedModes),
        ("\"stepping\"", KernelChoice::Stepping { steps: 4096 }),
        (
            "\"stepping\"\nsteps = 64",
            KernelChoice::Stepping { steps: 64 },
        ),
    ] {
        let job = job_with("[grid]", &format!("[run]\nkernel = {settings}\n\n[grid]"));
        assert_eq!(job.points.at(0).run.kernel, KernelSetting::Named(kernel));
        hashes.push(job.hash);
    }
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 4);
}

#[test]
fn probes_are_integrated_as_long_as_the_point_unless_told_otherwise() {
    let probes = |analyses: &str| {
        let run = "[run]\ntransient = 50\ncycles = 400\naudit_cycles = 0\n";
        let text = format!("{run}\n[analyses]\nmultistability = {analyses}\n\n[grid]");
        let job = job_with("[grid]", &text);
        job.points.at(0).analyses.multistability.unwrap()
    };
    let default = probes("{}");
    assert_eq!((default.initial_conditions, default.decades), (32, 4.0));
    assert_eq!((default.transient, default.cycles), (50, 400));
    let given = probes("{ initial_conditions = 2, decades = 0, transient = 0, cycles = 320 }");
    assert_eq!((given.initial_conditions, given.decades), (2, 0.0));
    assert_eq!((given.transient, given.cycles), (0, 320));
}

/// The published probe, 128 trajectories, and the bistable point.
#[test]
fn shipped_probes_are_sound() {
    for (name, points, probes, half_gap) in [
        ("multistability.toml", 4, 128, 10e-6),
        ("bistable.toml", 2, 128, 9e-6),
    ] {
        let job = shipped(name);
        assert_eq!(job.points.len(), points, "{name}");
        let asked = |p: PointSpec| p.analyses.multistability.unwrap().initial_conditions;
        assert_eq!(job.points.iter().map(asked).sum::<u32>(), probes, "{name}");
        assert!(job.points.iter().all(|p| p.mesh.half_gap == half_gap));
    }
}

/// Two chains over 0.55 … 1.70 of the reference speed, every step 5 rad/s.
#[test]
fn the_shipped_sweep_is_two_chains() {
    let job = shipped("speed-sweep.toml");
    assert_eq!((job.points.len(), job.chain_length()), (554, 277));
    let points: Vec<_> = job.points.iter().collect();
    let (up, down) = points.split_at(277);
    for (a, b) in up.iter().zip(down.iter().rev()) {
        assert_eq!((a.speed, a.load), (b.speed, 0.05));
    }
    assert!(
        up.windows(2)
            .all(|pair| (pair[1].speed - pair[0].speed - 5.0).abs() < 1e-9)
    );
}

fn job_with(from: &str, to: &str) -> Job {
    job(&with(MODAL, from, to))
}

#[test]
fn shafts_override_what_they_share() {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/quickstart.toml"),
    )
    .unwrap();
    let text = with(
        &text,
        "[shafts.wheel]",
        "[shafts.wheel.bearings]\ntilt = [1e4, 3e4]\n\n[shafts.wheel]\nspan = \"150 mm\"",
    );
    let job = job(&text);
    let StructureSource::Flexible(drive) = &job.points.at(0).model.source else {
        panic!("not a flexible drive");
    };
    let [pinion, wheel] = &drive.shafts;
    assert_eq!((pinion.span, wheel.span), (0.12, 0.15));
    assert_eq!(pinion.bearings.map(|b| b.tilt), [2e4, 2e4]);
    assert_eq!(wheel.bearings.map(|b| b.tilt), [1e4, 3e4]);
    assert_eq!(wheel.bearings.map(|b| b.y), [1e8, 1e8]);
}

#[test]
fn ripple_needs_and_finds_its_columns() {
    let folder = tempfile::tempdir().unwrap();
    let modal = include_str!("../manifests/oscillator.modal.toml");
    let columns =
        "teeth_wheel = 30\ntorque_pinion = [13.8, -11.4, 8.2]\ntorque_wheel = [-9.2, 7.6, -5.5]\n";
    std::fs::write(
        folder.path().join("oscillator.modal.toml"),
        format!("{modal}{columns}"),
    )
    .unwrap();
    let text = with(
        MODAL,
        "[grid]",
        "torque_ripple = [{ shaft = \"wheel\", order = 0.5, amplitude = \"3 N*m\" }]\n\n[grid]",
    );
    let job = manifest::parse(&text, "test.toml", folder.path()).unwrap_or_else(|e| panic!("{e}"));
    let ripple = job.points.at(0).excitation.torque_ripple[0];
    assert_eq!(
        (ripple.shaft, ripple.order, ripple.amplitude, ripple.phase),
        (DriveShaft::Wheel, 0.5, 3.0, 0.0)
    );
    let StructureSource::Modal(structure) = &job.points.at(0).model.source else {
        panic!("not modal");
    };
    assert_eq!(structure.wheel_teeth, Some(30));
    assert_eq!(
        structure.wheel_torque.as_deref(),
        Some(&[-9.2, 7.6, -5.5][..])
    );
}

#[test]
fn any_numeric_model_key_can_be_an_axis() {
    let job = job(&with(
        &with_gear(MODAL),
        "load = 0.1",
        "load = 0.1\n\"mesh.half_gap\" = { from = \"5 um\", to = \"20 um\", count = 3, spacing = \"log\" }\n\"model.retained\" = { values = [2, 3] }\n\"excitation.transmission_error.0.amplitude\" = { values = [\"1 um\", 2e-6] }\n\"mesh.contact_damping\" = { values = [\"1000 N*s/m\", \"2 kN*s/m\"] }\n\"mesh.friction\" = 0.1",
    ));
    let names: Vec<_> = job.axes.iter().map(|axis| axis.name()).collect();
    assert_eq!(
        names,
        [
            "excitation.transmission_error.0.amplitude",
            "mesh.contact_damping",
            "mesh.friction",
            "mesh.half_gap",
            "model.retained",
            "load",
            "speed"
        ]
    );
    assert_eq!(job.axes[1].unit, "N*s/m");
    assert_eq!(job.points.len(), 2 * 2 * 3 * 2 * 10);
    for point in job.points.iter() {
        let [
            amplitude,
            damping,
            friction,
            half_gap,
            retained,
            load,
            speed,
        ] = point.axis_values[..]
        else {
            panic!("{} axis values", point.axis_values.len());
        };
        assert_eq!(point.excitation.transmission_error[0].amplitude, amplitude);
        assert_eq!(point.mesh.damping, DampingSpec::Coefficient(damping));
        assert_eq!(
            (point.mesh.friction.constant(), point.mesh.half_gap),
            (Some(friction), half_gap)
        );
        assert_eq!(point.model.retained as f64, retained);
        assert_eq!((point.load, point.speed), (load, speed));
        assert_eq!(point.excitation.transmission_error[0].harmonic, 1);
    }
    assert!((job.axes[3].values.get(1) - 1e-5).abs() < 1e-20);
}

#[test]
fn an_axis_may_give_a_key_that_its_table_leaves_out() {
    let text = with(MODAL, "half_gap = \"15 um\"\n", "");
    let text = with(
        &text,
        "load = 0.1",
        "load = 0.1\n\"mesh.half_gap\" = { values = [1e-5, \"20 um\"] }",
    );
    let job = job(&text);
    assert_eq!(job.points.at(0).mesh.half_gap, 1e-5);
    assert_eq!(job.points.at(10).mesh.half_gap, 2e-5);
}

#[test]
fn the_hash_ignores_how_it_is_written() {
    let reference = job(MODAL).hash;
    assert_eq!(reference.len(), 64);
    let same = [
        ("half_gap = \"15 um\"", "half_gap = 1.5e-5 # a comment"),
        ("half_gap = \"15 um\"", "half_gap = \"0.015 mm\""),
        (
            "mean_stiffness = \"4e8 N/m\"",
            "mean_stiffness = \"400 N/um\"",
        ),
        (
            "half_gap = \"15 um\"\nstiffness = \"constant\"",
            "stiffness = \"constant\"\nhalf_gap = \"15 um\"",
        ),
        ("name = \"case\"", "name = \"another\""),
        ("name = \"case\"", "name = \"case\"\nseed = 1"),
        (
            "contact_damping = 0.05",
            "contact_damping = \"5 %\"\nfriction = -0.0",
        ),
        ("load = 0.1", "load = { values = [0.1] }"),
        (
            "{ from = 600, to = 1500, count = 10 }",
            "{ values = [600, 700, 800, 900, 1000, 1100, 1200, 1300, 1400, 1500] }",
        ),
        (
            "load = 0.1\nspeed = { from = 600, to = 1500, count = 10 }",
            "speed = { from = 600, to = 1500, count = 10 }\nload = 0.1",
        ),
        (
            "[grid]",
            "[run]\ntransient = 200\nkernel = \"auto\"\n\n[grid]",
        ),
        (
            "amplitude = \"5 um\"",
            "amplitude = \"5 um\", phase = \"0 deg\"",
        ),
    ];
    for (from, to) in same {
        assert_eq!(job_with(from, to).hash, reference, "{to}");
    }
}

#[test]
fn a_continuous_law_keeps_its_transition_and_its_mean() {
    let continuous = |ratio: &str| {
        let law =
            format!("stiffness = \"continuous\"\ncontact_ratio = {ratio}\nsingle_pair_drop = 0.25");
        let job = job_with("stiffness = \"constant\"", &law);
        match &job.points.at(0).mesh.stiffness {
            StiffnessSpec::Continuous(levels) => *levels,
            other => panic!("{other:?}"),
        }
    };
    let levels = continuous("1.63");
    assert!((levels.transition - 0.63).abs() < 1e-15);
    assert!((levels.mean() / 4e8 - 1.0).abs() < 1e-15);
    assert!((levels.single_pair / levels.double_pair - 0.75).abs() < 1e-15);
    let (stiffness, transitions) = levels.divisions();
    assert_eq!(stiffness, [levels.double_pair, levels.single_pair]);
    assert_eq!(transitions, [levels.transition]);
    // Near an end of the cycle one level remains.
    for (ratio, level) in [("1.0000000000001", 0), ("1.9999999999999", 1), ("2", 1)] {
        let levels = continuous(ratio);
        let (stiffness, transitions) = levels.divisions();
        assert_eq!(stiffness, [[levels.single_pair, levels.double_pair][level]]);
        assert!(transitions.is_empty());
        assert!((stiffness[0] / 4e8 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_hash_sees_every_change_that_matters() {
    let changes = [
        ("half_gap = \"15 um\"", "half_gap = \"15.000001 um\""),
        (
            "mean_stiffness = \"4e8 N/m\"",
            "mean_stiffness = \"4.1e8 N/m\"",
        ),
        (
            "stiffness = \"constant\"\nmean_stiffness = \"4e8 N/m\"",
            "stiffness = \"piecewise\"\nvalues = [4e8]",
        ),
        (
            "stiffness = \"constant\"",
            "stiffness = \"continuous\"\ncontact_ratio = 1.6\nsingle_pair_drop = 0.25",
        ),
        (
            "stiffness = \"constant\"",
            "stiffness = \"continuous\"\ncontact_ratio = 1.63\nsingle_pair_drop = 0.25",
        ),
        (
            "stiffness = \"constant\"",
            "stiffness = \"continuous\"\ncontact_ratio = 1.63\nsingle_pair_drop = 0.2",
        ),
        ("contact_damping = 0.05", "contact_damping = 0.06"),
        ("contact_damping = 0.05", "contact_damping = \"0.05 N*s/m\""),
        ("harmonic = 1", "harmonic = 2"),
        ("amplitude = \"5 um\"", "amplitude = \"6 um\""),
        (
            "amplitude = \"5 um\"",
            "amplitude = \"5 um\", phase = \"1 deg\"",
        ),
        ("load = 0.1", "load = 0.2"),
        ("count = 10", "count = 11"),
        ("name = \"case\"", "name = \"case\"\nseed = 2"),
        ("kind = \"modal\"", "kind = \"modal\"\nretained = 2"),
        ("kind = \"modal\"", "kind = \"modal\"\nmta = true"),
        ("[grid]", "[run]\ntransient = 201\n\n[grid]"),
        ("[grid]", "[run]\ncycles = 801\n\n[grid]"),
        ("[grid]", "[run]\nkernel = \"stepping\"\n\n[grid]"),
        (
            "[grid]",
            "[run]\nkernel = \"stepping\"\nsteps = 8192\n\n[grid]",
        ),
        ("[grid]", "[run]\ninitial = \"rest\"\n\n[grid]"),
        (
            "[grid]",
            "[run]\ninitial = { displacement = [0, 0, 1e-6], velocity = [0, 0, 0] }\n\n[grid]",
        ),
        (
            "[grid]",
            "[run]\ninitial = { displacement = [0, 0, 0], velocity = [0, 0, 1e-6] }\n\n[grid]",
        ),
        ("[grid]", "[run]\naudit_cycles = 50\n\n[grid]"),
        ("[grid]", "[run]\nevent_limit = 100\n\n[grid]"),
        ("[grid]", "[analyses]\nlyapunov = {}\n\n[grid]"),
        (
            "[grid]",
            "[analyses]\nlyapunov = { exponents = 2 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nlyapunov = { stop_at_stderr = 0.01 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nlyapunov = { twin = false }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nlyapunov = { effort = \"survey\" }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nlyapunov = { lifetime = 100 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nlyapunov = { chains = true }\n\n[grid]",
        ),
        ("[grid]", "[analyses]\npoincare = {}\n\n[grid]"),
        ("[grid]", "[analyses]\nnvh = {}\n\n[grid]"),
        ("[grid]", "[analyses]\nnvh = { spectrum = {} }\n\n[grid]"),
        ("[grid]", "[analyses]\nmultistability = {}\n\n[grid]"),
        (
            "[grid]",
            "[analyses]\nmultistability = { initial_conditions = 31 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nmultistability = { decades = 4.5 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nmultistability = { transient = 201 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\nmultistability = { cycles = 801 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\npoincare = { phase = 0.25 }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\npoincare = { section = \"entry\" }\n\n[grid]",
        ),
        (
            "[grid]",
            "[analyses]\npoincare = { section = \"extremum\" }\n\n[grid]",
        ),
        ("[grid]", "[grid]\norder = \"sweep-up\""),
        ("[grid]", "[grid]\norder = \"sweep-down\""),
        ("[grid]", "[grid]\norder = \"both\""),
        (
            "[grid]",
            "[analyses]\npoincare = { refine = 3 }\n\n[grid]\norder = \"both\"",
        ),
        ("load = 0.1", "load = 0.1\n\"mesh.half_gap\" = \"15 um\""),
    ];
    let mut seen = std::collections::HashMap::from([(job(MODAL).hash, "the original")]);
    for (from, to) in changes {
        let earlier = seen.insert(job_with(from, to).hash, to);
        assert_eq!(earlier, None, "{to} hashes like it");
    }
}

#[test]
fn the_hash_sees_a_modal_file_by_its_content() {
    let modal = include_str!("../manifests/oscillator.modal.toml");
    let hash = |content: &str| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("oscillator.modal.toml"), content).unwrap();
        manifest::parse(MODAL, "test.toml", folder.path())
            .unwrap_or_else(|errors| panic!("{errors}"))
            .hash
    };
    let reference = hash(modal);
    assert_eq!(reference, job(MODAL).hash);
    assert_eq!(
        reference,
        hash(&format!("# moved\n{modal}\nmesh_tilt = [0, 0, 0]\n"))
    );
    for (from, to) in [
        ("4452.8", "4452.9"),
        ("teeth        = 20", "teeth = 21"),
        ("0.02", "0.03"),
    ] {
        assert_ne!(reference, hash(&with(modal, from, to)), "{to}");
    }
}

/// The manifest without a half gap, which then follows from the drawing.
fn without_half_gap(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("half_gap"));
    lines.map(|line| format!("{line}\n")).collect()
}

#[test]
fn the_default_drive_hash_sees_every_field() {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/flex80.toml"),
    )
    .unwrap();
    let mut seen = std::collections::HashSet::from([job(&text).hash]);
    for (from, to) in [
        ("teeth = [20, 30]", "teeth = [20, 31]"),
        ("\"4 mm\"", "\"4.1 mm\""),
        ("\"20 deg\"", "\"21 deg\""),
        ("\"20 mm\"", "\"21 mm\""),
        ("\"40 mm\"]", "\"41 mm\"]"),
        ("\"50 N*m\"", "\"51 N*m\""),
        ("[gear]", "[gear]\nprofile_shift = [0.3, -0.1]"),
        ("[gear]", "[gear]\nprofile_shift = [-0.1, 0.3]"),
        ("[gear]", "[gear]\nrack.addendum = 0.95"),
        ("[gear]", "[gear]\nrack.dedendum = 1.3"),
        ("[gear]", "[gear]\nrack.tip_radius = 0.3"),
        ("[gear]", "[gear]\nthinning = \"30 um\""),
        ("[gear]", "[gear]\nthinning = [\"30 um\", 0]"),
        // This thinning gives the same half gap as the one before.
        ("[gear]", "[gear]\nthinning = [0, \"30 um\"]"),
        ("[gear]", "[gear]\ncentre_distance = \"100.1 mm\""),
        ("[gear]", "[gear]\ntip_diameter = [\"88 mm\", \"128 mm\"]"),
        ("[gear]", "[gear]\nbore = [\"88 mm\", \"128 mm\"]"),
        (
            "[gear]",
            "[gear]\ntip_relief = { amount = \"10 um\", length = \"3 mm\" }",
        ),
        (
            "[gear]",
            "[gear]\nroot_relief = { amount = \"10 um\", length = \"3 mm\" }",
        ),
        (
            "[gear]",
            "[gear]\nyoung_modulus = [\"206 GPa\", \"115 GPa\"]",
        ),
        ("[gear]", "[gear]\npoisson_ratio = 0.28"),
        ("\"206 GPa\"", "\"207 GPa\""),
        ("\"79 GPa\"", "\"80 GPa\""),
        ("\"7850 kg/m^3\"", "\"7800 kg/m^3\""),
        ("shear_coefficient = 0.9", "shear_coefficient = 0.85"),
        ("span = \"120 mm\"", "span = \"121 mm\""),
        ("overhang = \"40 mm\"", "overhang = \"41 mm\""),
        ("gear_position = 0.45", "gear_position = 0.46"),
        ("[3, 5, 7]", "[3, 7, 5]"),
        ("\"22 mm\"", "\"23 mm\""),
        ("\"5e-3 kg*m^2\"", "\"6e-3 kg*m^2\""),
        ("\"1.25e8 N/m\"", "\"1.26e8 N/m\""),
        ("y = \"1e8 N/m\"", "y = \"1.1e8 N/m\""),
        ("\"2e4 N*m/rad\"", "[2e4, 3e4]"),
        ("[\"1e8 N/m\", 0]", "[0, \"1e8 N/m\"]"),
        ("modes = 40", "modes = 41"),
        ("modes = 40", "modes = 40\ngyroscopic = true"),
        ("[\"1e8 N/m\", 0]", "[\"1e8 N/m\", 0]\ndamping_x = 400"),
        ("[\"1e8 N/m\", 0]", "[\"1e8 N/m\", 0]\ndamping_y = 400"),
        (
            "[\"1e8 N/m\", 0]",
            "[\"1e8 N/m\", 0]\ndamping_y = [400, 300]",
        ),
        ("[\"1e8 N/m\", 0]", "[\"1e8 N/m\", 0]\ndamping_xy = -20"),
        ("[\"1e8 N/m\", 0]", "[\"1e8 N/m\", 0]\ndamping_yx = -20"),
        ("[\"1e8 N/m\", 0]", "[\"1e8 N/m\", 0]\ncross_xy = 2e6"),
        ("[\"1e8 N/m\", 0]", "[\"1e8 N/m\", 0]\ncross_yx = 2e6"),
        ("\"22 mm\"", "\"22 mm\"\ndrag = 2e-3"),
        ("\"22 mm\"", "\"22 mm\"\ndrag_torque = 0.4"),
        ("\"26 mm\"", "\"26 mm\"\ndrag = 2e-3"),
        ("\"26 mm\"", "\"26 mm\"\ndrag_torque = 0.4"),
        ("damping = 0.01", "damping = 0.02"),
        (
            "damping = 0.01",
            "damping = 0.01\ndamping_overrides = [{ mode = 7, ratio = 0.02 }]",
        ),
        ("contact_ratio = 1.6", "contact_ratio = 1.5"),
        ("single_pair_drop = 0.25", "single_pair_drop = 0.2"),
        ("segments = 60", "segments = 120"),
    ] {
        let changed = with(&text, from, to);
        let changed = if to.contains("thinning") || to.contains("centre_distance") {
            without_half_gap(&changed)
        } else {
            changed
        };
        assert!(seen.insert(job(&changed).hash), "{to} is not seen");
    }
}

#[test]
fn a_drawing_may_say_more_of_its_teeth() {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/flex80.toml"),
    )
    .unwrap();
    let gears = |text: &str| match &job(text).points.at(0).model.source {
        StructureSource::Flexible(drive) => drive.gears.clone(),
        other => panic!("not a flexible drive but {}", other.kind()),
    };
    assert_eq!(gears(&text).form, ToothForm::default());
    let full = gears(&without_half_gap(&with(
        &text,
        "[gear]",
        r#"[gear]
profile_shift = [0.3, -0.1]
rack = { addendum = 0.95, dedendum = 1.3, tip_radius = 0.3 }
thinning = ["30 um", 0]
centre_distance = "100.9 mm"
tip_diameter = ["90 mm", "127 mm"]
tip_relief = { amount = ["10 um", "8 um"], length = "3 mm" }
root_relief = { amount = "5 um", length = ["2 mm", "1 mm"] }
bore = "30 mm"
young_modulus = ["206 GPa", "115 GPa"]
poisson_ratio = [0.28, 0.25]"#,
    )));
    let relief = |amount, length| Relief {
        amount,
        length,
        ..Relief::default()
    };
    let material = |young_modulus, poisson_ratio| Material {
        young_modulus,
        poisson_ratio,
    };
    let expected = ToothForm {
        profile_shift: [0.3, -0.1],
        rack: BasicRack {
            addendum: 0.95,
            dedendum: 1.3,
            tip_radius: 0.3,
        },
        thinning: [30e-6, 0.0],
        centre_distance: Some(0.1009),
        tip_diameter: [Some(0.09), Some(0.127)],
        tip_relief: [relief(10e-6, 3e-3), relief(8e-6, 3e-3)],
        root_relief: [relief(5e-6, 2e-3), relief(5e-6, 1e-3)],
        bore: [Some(0.03); 2],
        material: [material(206e9, 0.28), material(115e9, 0.25)],
        ..ToothForm::default()
    };
    assert_eq!(full.form, expected);
    assert_eq!(full.on_shafts([0.02; 2]).form.bore, [Some(0.03); 2]);
    let shafted = gears(&text).on_shafts([0.022, 0.026]);
    assert_eq!(shafted.form.bore, [Some(0.022), Some(0.026)]);
}

#[test]
fn all_faults_of_a_file_come_at_once_in_its_order() {
    let text = with(MODAL, "half_gap = \"15 um\"", "half_gap = \"15 N\"");
    let text = with(&text, "name = \"case\"", "name = 3");
    let text = with(&text, "load = 0.1", "load = \"0.1 N\"");
    let errors = parse(&text).unwrap_err();
    let found: Vec<_> = errors
        .diagnostics
        .iter()
        .map(|d| (d.kind, d.key.as_str(), d.line))
        .collect();
    assert_eq!(
        found,
        [
            (DiagnosticKind::WrongType, "job.name", 2),
            (DiagnosticKind::WrongUnit, "mesh.half_gap", 9),
            (DiagnosticKind::WrongUnit, "grid.load", 18),
        ]
    );
}

/// The limits of the list of faults act on every combination alone.
#[test]
fn faults_of_every_combination_are_counted_once() {
    let faulty: Vec<String> = (1..=60)
        .map(|harmonic| format!("{{ harmonic = {harmonic}, amplitude = \"5 N\" }}"))
        .collect();
    let text = with(
        &text_of("quickstart.toml"),
        "transmission_error = [{ harmonic = 1, amplitude = \"5 um\" }]",
        &format!("transmission_error = [{}]", faulty.join(", ")),
    );
    let gaps = "[grid]\n\"mesh.half_gap\" = { values = [\"10 um\", \"20 um\"] }\n";
    let errors = parse(&with(&text, "[grid] ", &format!("{gaps}#"))).unwrap_err();
    assert_eq!((errors.count(), errors.more), (60, 0));
    assert!(
        errors
            .diagnostics
            .iter()
            .all(|fault| fault.at_point.is_none())
    );
}

#[test]
fn colours_are_asked_for() {
    let errors = parse("").unwrap_err();
    assert!(!errors.render(false).contains('\u{1b}'));
    assert!(errors.render(true).contains('\u{1b}'));
    assert_eq!(errors.to_string(), errors.render(false));
}

#[test]
fn ten_million_points_are_the_most() {
    let grid = |count: &str| {
        let text = with(
            MODAL,
            "load = 0.1",
            "load = { from = 0.1, to = 0.3, count = 100000 }",
        );
        with(&text, "count = 10 }", count)
    };
    let errors = parse(&grid("count = 101 }")).unwrap_err();
    assert_eq!(errors.diagnostics.len(), 1);
    assert_eq!(errors.diagnostics[0].kind, DiagnosticKind::GridTooLarge);
}

mod no_panic {
    use super::*;
    use proptest::prelude::*;

    /// Pieces of manifests, combined at random.
    const PIECES: [&str; 28] = [
        "[mesh]\n",
        "[grid]\n",
        "[model]\n",
        "[run]\n",
        "[excitation]\n",
        "[analyses]\n",
        "[shafts]\n",
        "half_gap = ",
        "load = ",
        "speed = ",
        "kind = ",
        "initial = ",
        "\"mesh.half_gap\" = ",
        "\"excitation.transmission_error.0.amplitude\" = ",
        "transmission_error = ",
        "\"15 um\"",
        "-1",
        "nan",
        "\"modal\"",
        "\"flexible\"",
        "[",
        "]",
        "{ values = [",
        "] }",
        "{ from = 0, to = 1, count = 3 }",
        "\n",
        "= ",
        "µ",
    ];

    proptest! {
        #[test]
        fn whatever_the_text(pieces in proptest::collection::vec(0..PIECES.len(), 0..24)) {
            let text: String = pieces.iter().map(|&i| PIECES[i]).collect();
            let errors = parse(&text).unwrap_err();
            prop_assert!(!errors.render(false).is_empty());
            for d in &errors.diagnostics {
                prop_assert!(d.line >= 1 && d.column >= 1);
            }
        }

        /// A manifest cut at any position gives a result, mostly errors.
        #[test]
        fn wherever_it_is_cut(cut in 0..MODAL.len(), insert in "\\PC{0,3}") {
            if MODAL.is_char_boundary(cut) {
                let text = format!("{}{insert}{}", &MODAL[..cut], &MODAL[cut..]);
                if let Err(errors) = parse(&text) {
                    prop_assert!(!errors.render(false).is_empty());
                }
                if let Err(errors) = parse(&MODAL[..cut]) {
                    prop_assert!(!errors.render(false).is_empty());
                }
            }
        }
    }
}

#[test]
fn points_share_what_they_have_in_common() {
    let text = with(
        MODAL,
        "load = 0.1",
        "load = { from = 0.1, to = 0.2, count = 3 }\n\"mesh.half_gap\" = { values = [1e-5, 2e-5] }",
    );
    let text = with(
        &text,
        "stiffness = \"constant\"\nmean_stiffness = \"4e8 N/m\"",
        "stiffness = \"piecewise\"\nvalues = [4e8, 3e8]",
    );
    let job = job(&text);
    assert_eq!(job.points.len(), 60);
    let first = &job.points.at(0);
    let stiffness = |point: &PointSpec| match &point.mesh.stiffness {
        StiffnessSpec::Piecewise(values) => values.clone(),
        other => panic!("not piecewise but {other:?}"),
    };
    for point in job.points.iter() {
        assert!(Arc::ptr_eq(&stiffness(&point), &stiffness(first)));
        assert!(Arc::ptr_eq(&point.excitation, &first.excitation));
        assert!(Arc::ptr_eq(&point.run, &first.run));
        assert!(Arc::ptr_eq(&point.analyses, &first.analyses));
    }
    // Only variants with different half gaps are stored; points are made on request.
    assert_eq!(job.points.variants().len(), 2);
}

/// The default drive with a drawing that states backlash, and the given `[mesh]`.
fn drawn(gear: &str, gap: &str) -> Result<Job, ManifestErrors> {
    let text = include_str!("../../manifests/flex80.toml");
    let text = with(text, "rated_torque =", &format!("{gear}\nrated_torque ="));
    parse(&with(&text, "half_gap = \"10 um\" ", &format!("{gap} ")))
}

const APART: &str = "centre_distance = \"100.5 mm\"\nthinning = \"30 um\"";

#[test]
fn the_half_gap_is_that_of_the_drawing() {
    let half_gap = |gear, gap| drawn(gear, gap).unwrap().points.at(0).mesh.half_gap;
    // Twice the base radii times the difference of the involute function, plus the thinning of the teeth on the base
    // circles.
    let (cos, base_radii) = (20f64.to_radians().cos(), 0.1 * 20f64.to_radians().cos());
    let involute = |angle: f64| angle.tan() - angle;
    let apart = involute((base_radii / 0.1005).acos()) - involute(20f64.to_radians());
    let exact = base_radii * apart + 30e-6 * cos;
    assert!((half_gap(APART, "") / exact - 1.0).abs() < 1e-9);
    assert!(exact > 190e-6);
    // A number that agrees within a hundredth has priority.
    assert_eq!(half_gap(APART, "half_gap = \"202 um\""), 202e-6);
    // If the drawing has no backlash, [mesh] determines it.
    assert_eq!(half_gap("", "half_gap = \"12 um\""), 12e-6);
    assert_eq!(half_gap("", "normal_backlash = \"30 um\""), 15e-6);
    let round = half_gap("", "circumferential_backlash = \"30 um\"");
    assert!((round - 15e-6 * cos).abs() < 1e-18);
    let errors = drawn("", "").unwrap_err();
    assert_eq!(errors.diagnostics.len(), 1);
    assert_eq!(errors.diagnostics[0].kind, DiagnosticKind::MissingKey);
}

#[test]
fn a_half_gap_that_contradicts_the_drawing_is_an_error() {
    for gap in [
        "half_gap = \"10 um\"",
        "normal_backlash = \"20 um\"",
        "circumferential_backlash = \"21 um\"",
    ] {
        let errors = drawn(APART, gap).unwrap_err();
        let [fault] = &errors.diagnostics[..] else {
            panic!("{errors}");
        };
        let key = gap.split(' ').next().unwrap();
        assert_eq!(fault.kind, DiagnosticKind::Inconsistent);
        assert_eq!(fault.key, format!("mesh.{key}"));
        assert!(fault.message.contains("a half gap of 202.3"), "{errors}");
        assert!(fault.remedy.as_ref().unwrap().contains(key), "{errors}");
    }
    let twice = "half_gap = \"10 um\"\nnormal_backlash = \"20 um\"";
    let errors = drawn("", twice).unwrap_err();
    assert_eq!(errors.diagnostics[0].key, "mesh.normal_backlash");
}

/// Detects metres instead of microns: compares the half gap with the teeth if they are known, else with the deflection
/// under the rated force. An oscillator without units has a separate scale.
#[test]
fn a_half_gap_has_the_size_of_a_half_gap() {
    let modal = with(MODAL, "half_gap = \"15 um\"", "half_gap = 37.3");
    for errors in [
        drawn("", "half_gap = 37.3").unwrap_err(),
        parse(&modal).unwrap_err(),
    ] {
        let [fault] = &errors.diagnostics[..] else {
            panic!("{errors}");
        };
        assert_eq!(fault.kind, DiagnosticKind::OutOfRange);
        assert_eq!(fault.key, "mesh.half_gap");
        assert!(
            fault.remedy.as_ref().unwrap().contains("metres"),
            "{errors}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("one.modal.toml"),
        "teeth = 1\nrated_force = 1.0\nfrequency = [0.0]\ndamping = [0.0]\nmesh = [1.0]\ntorque = [1.0]\n",
    )
    .unwrap();
    let text = "[job]\nname = \"one\"\n[model]\nkind = \"modal\"\nfile = \"one.modal.toml\"\n\
        [mesh]\nhalf_gap = 1\nstiffness = \"constant\"\nmean_stiffness = 1\ncontact_damping = 0.02\n\
        [grid]\nload = 0.1\nspeed = 0.8\n[run]\ntransient = 10\ncycles = 400\n";
    let job = manifest::parse(text, "one.toml", folder.path());
    let job = job.unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(job.points.at(0).mesh.half_gap, 1.0);
}

/// The coast flanks of a job's first point.
fn coast(text: &str) -> CoastSpec {
    job(text).points.at(0).mesh.coast
}

#[test]
fn coast_flanks_have_their_own_line_unless_nothing_says_which() {
    // Half a tooth of the pinion behind its drive flank at the pitch point.
    let drawn = shipped("flex80.toml").points.at(0);
    let symmetry = drawn.model.source.gears().unwrap().symmetry().unwrap();
    assert_eq!(drawn.mesh.coast, CoastSpec::Mirrored { symmetry });
    // 20 and 30 teeth, 20°: tips at 44 and 64 mm, base pitch 11.809 mm.
    let approach = (64f64.powi(2) - (60.0 * 20f64.to_radians().cos()).powi(2)).sqrt()
        - 60.0 * 20f64.to_radians().sin();
    let base_pitch = 4.0 * std::f64::consts::PI * 20f64.to_radians().cos();
    let by_hand = (approach / base_pitch + 0.25).rem_euclid(0.5);
    assert!((symmetry - by_hand).abs() < 1e-14, "{symmetry} {by_hand}");

    let flex80 = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/flex80.toml"),
    )
    .unwrap();
    let keyed = |keys: &str| coast(&with(&flex80, "[mesh]", &format!("[mesh]\n{keys}\n#")));
    assert_eq!(keyed("coast_flank = \"same_line\""), CoastSpec::SameLine);
    let given = keyed("coast_symmetry = 0.3");
    assert_eq!(given, CoastSpec::Mirrored { symmetry: 0.3 });

    // A modal file without their participations has one line, one with them has two.
    assert_eq!(coast(MODAL), CoastSpec::SameLine);
    let known = with(MODAL, "oscillator", "coast");
    assert_eq!(coast(&known), CoastSpec::Mirrored { symmetry: 0.0 });
    let levels = "stiffness = \"continuous\"\ncontact_ratio = 1.6\nsingle_pair_drop = 0.25";
    let CoastSpec::Mirrored { symmetry } = coast(&with(&known, "stiffness = \"constant\"", levels))
    else {
        panic!("one line");
    };
    assert!((symmetry - 0.05).abs() < 1e-15, "{symmetry}");
    let StructureSource::Modal(structure) = job(&known).points.at(0).model.source else {
        panic!("no modal file");
    };
    let flank = structure.coast.clone().unwrap();
    assert_eq!(flank.mesh, [0.52, -0.43, 0.12]);
    assert_eq!(flank.friction, [0.0, 0.0, -0.1]);
    assert_eq!((&flank.tilt, &flank.lever), (&vec![0.0; 3], &vec![0.0; 3]));
}

#[test]
fn contacts_let_go_as_asked() {
    let of = |keys: &str| {
        let job = job(&with(MODAL, "[mesh]", &format!("[mesh]\n{keys}")));
        (job.points.at(0).mesh.release, job.hash)
    };
    let (release, hash) = of("");
    assert_eq!(release, Release::Deflection);
    assert_eq!(of("release = \"deflection\""), (release, hash.clone()));
    let (release, other) = of("release = \"force\"");
    assert_eq!(release, Release::Force);
    assert_ne!(hash, other);
}

#[test]
fn coast_flanks_may_have_an_error_of_their_own() {
    let text = with(MODAL, "oscillator", "coast");
    let own = with(
        &text,
        "[excitation]",
        "[excitation]\ncoast_transmission_error = [{ harmonic = 2, amplitude = \"3 um\" }]",
    );
    let of = |text: &str| {
        let excitation = job(text).points.at(0).excitation;
        excitation.coast_transmission_error.clone()
    };
    assert_eq!(of(&text), None);
    assert_eq!(of(&own), Some(vec![MeshHarmonic::new(2, 3e-6, 0.0)]));
    assert_ne!(job(&text).hash, job(&own).hash);
}

/// Keys of analyses and the seed can be axes like those of the drive: each point has its value, and so has the content
/// hash.
#[test]
fn analyses_and_the_seed_are_axes() {
    let axes = |separations: &str, seeds: &str| {
        let text = format!(
            "[analyses]\nlyapunov = {{ exponents = 2 }}\n\n[grid]\n\
             \"analyses.lyapunov.separation\" = {{ values = {separations} }}\n\
             \"job.seed\" = {{ values = {seeds} }}\n"
        );
        job_with("[grid]\n", &text)
    };
    let job = axes("[1e-8, 1e-7]", "[3, 5, 8]");
    let names: Vec<&str> = job.axes.iter().map(|axis| axis.name()).collect();
    let keys = ["analyses.lyapunov.separation", "job.seed", "load", "speed"];
    assert_eq!(names, keys);
    let inner = job.points.len() / 6;
    for (nth, (separation, seed)) in [1e-8, 1e-7]
        .into_iter()
        .flat_map(|separation| [3, 5, 8].map(|seed| (separation, seed)))
        .enumerate()
    {
        let point = job.points.at(nth * inner);
        let asked = point.analyses.lyapunov.unwrap();
        assert_eq!((asked.separation, asked.exponents), (separation, 2));
        assert_eq!((point.seed, point.axis_values[1]), (seed, seed as f64));
    }
    let other = axes("[1e-8, 1e-7]", "[3, 5, 9]");
    assert_ne!(job.hash, other.hash);
    assert_ne!(job.hash, axes("[1e-9, 1e-7]", "[3, 5, 8]").hash);
}

/// The kind and the key of every fault.
fn faults(text: &str) -> Vec<(DiagnosticKind, String)> {
    let errors = parse(text).unwrap_err();
    let of = |fault: &Diagnostic| (fault.kind, fault.key.clone());
    errors.diagnostics.iter().map(of).collect()
}

/// Keys that a manifest has without effect, according to its warnings.
fn idle(text: &str) -> Vec<String> {
    let warnings = job(text).warnings.diagnostics.into_iter();
    let of = |warning: Diagnostic| {
        assert_eq!(warning.kind, DiagnosticKind::NoEffect);
        warning.key
    };
    warnings.map(of).collect()
}

fn text_of(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Springs of pairs have the error of the flanks in their gaps, for any number of harmonics.
#[test]
fn pairs_know_no_harmonics_of_their_error() {
    let text = text_of("pairs.toml");
    let text = with(&text, "[excitation]", "[excitation]\ntable_harmonics = 5");
    assert_eq!(idle(&text), ["excitation.table_harmonics"]);
}

/// Harmonics belong to one law of the stiffness.
#[test]
fn harmonics_of_the_stiffness_need_a_fourier_series() {
    let harmonics = "stiffness_harmonics = [{ harmonic = 1, amplitude = 5e7 }]";
    let constant = "stiffness = \"constant\"\nmean_stiffness = \"4e8 N/m\"";
    let levels = "mean_stiffness = 4e8\ncontact_ratio = 1.6\nsingle_pair_drop = 0.25";
    for law in [
        constant.to_owned(),
        format!("stiffness = \"piecewise\"\n{levels}"),
        "stiffness = \"piecewise\"\nvalues = [4e8, 3e8]".to_owned(),
        format!("stiffness = \"continuous\"\n{levels}"),
    ] {
        let text = with(MODAL, constant, &format!("{law}\n{harmonics}"));
        assert_eq!(idle(&text), ["mesh.stiffness_harmonics"], "{law}");
    }
    let text = with(
        &text_of("pairs.toml"),
        "[mesh]",
        &format!("[mesh]\n{harmonics}"),
    );
    assert_eq!(idle(&text), ["mesh.stiffness_harmonics"]);
}

/// A range of integers has no fractions: seeds would be truncated and points computed twice.
#[test]
fn a_range_of_seeds_is_of_whole_numbers() {
    let range = |count: u32| {
        let axis = format!("[grid]\n\"job.seed\" = {{ from = 1, to = 4, count = {count} }}");
        with(MODAL, "[grid]", &axis)
    };
    assert_eq!(job(&range(4)).points.at(10).seed, 2);
    let fault = (DiagnosticKind::WrongType, "grid.\"job.seed\"".to_owned());
    assert_eq!(faults(&range(3)), [fault]);
}

/// A common key that both shafts override is checked, too.
#[test]
fn an_overridden_key_of_shafts_is_checked() {
    let own = |text: &str| {
        let text = with(text, "[shafts.pinion]", "[shafts.pinion]\nspan = 0.12");
        with(&text, "[shafts.wheel]", "[shafts.wheel]\nspan = 0.12")
    };
    let text = own(&text_of("quickstart.toml"));
    job(&text);
    let wrong = with(&text, "span = \"120 mm\"", "span = \"5 kg\"");
    let fault = |key: &str| (DiagnosticKind::WrongUnit, key.to_owned());
    assert_eq!(faults(&wrong), [fault("shafts.span")]);
    let bearings = "[shafts.pinion.bearings]\ny = 1e8\n\n[shafts.wheel.bearings]\ny = 1e8\n\n[shafts.bearings]";
    let text = with(&text, "[shafts.bearings]", bearings);
    job(&text);
    let wrong = with(&text, "y = \"1e8 N/m\"", "y = \"1e8 N\"");
    assert_eq!(faults(&wrong), [fault("shafts.bearings.y")]);
}

/// Bifurcations are followed over a second axis; without one `curves` has no meaning.
#[test]
fn curves_need_a_second_axis() {
    let alone = format!("{MODAL}\n[continuation]\nover = \"speed\"\ncurves = \"all\"\n");
    assert_eq!(idle(&alone), ["continuation.curves"]);
    let plane = with(&alone, "load = 0.1", "load = { values = [0.1, 0.2] }");
    job(&with(&plane, "curves =", "second = \"load\"\ncurves ="));
}

/// Results name the forces of bearings by the names of a modal file.
#[test]
fn bearings_of_a_modal_file_have_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let modal = include_str!("../manifests/oscillator.modal.toml");
    let read = |names: [&str; 2]| {
        let bearing =
            |name: &str| format!("\n[[bearing]]\nname = \"{name}\"\ngain = [1.0, 0.0, 0.0]\n");
        let text = names.map(bearing).concat();
        std::fs::write(
            folder.path().join("oscillator.modal.toml"),
            format!("{modal}{text}"),
        )
        .unwrap();
        manifest::parse(MODAL, "test.toml", folder.path())
    };
    read(["b x", "b_x"]).unwrap();
    let errors = read(["b x", "b x"]).unwrap_err();
    assert_eq!(errors.diagnostics.len(), 1);
    assert_eq!(errors.diagnostics[0].key, "bearing.1.name");
}
