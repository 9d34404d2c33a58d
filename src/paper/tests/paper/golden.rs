//! Recorded results of the paper's kernels, to the digits that `tests/golden` compares: do changes of the code change a
//! result?

use crate::common;
use gearatlas::analysis::{PointOutcome, investigate};
use gearatlas::manifest::ManifestText;
use gearatlas::model::Model;
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::Kernel;
use gearatlas::sweep::build::point_config;
use gearatlas_paper::kernels::{Dyadic, Fused, Hermite, Spectral};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Smallest number of cells per cycle, as published.
const CELLS: u32 = 60;
const LIMIT: u32 = 1000;

/// Tolerance of a number, relative to its size.
const RELATIVE: f64 = 1e-7;

/// Additional tolerance, relative to the largest number of its kind.
const FLOOR: f64 = 1e-10;

/// Values by the name of their column, in the order of the points.
type Columns = BTreeMap<String, Vec<f64>>;

/// Cases: a name, a manifest, the changed keys, and the kernel.
macro_rules! golden {
    ($($name:ident: $manifest:literal [$($set:literal),* $(,)?] |$model:ident| $kernel:expr;)*) => {
        $(#[test]
        fn $name() {
            let mut found = Columns::new();
            each(concat!("../../", $manifest), &[$($set),*], |$model, ask| {
                add(&mut found, &ask.of(&$kernel));
            });
            compare(stringify!($name), &found);
        })*
    };
}

golden! {
    dyadic: "manifests/tiers/torsional.toml" [
        "grid.load=0.3", "run.transient=2", "run.cycles=10",
        "run.settle=false", "mesh.coast_flank=same_line", "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ] |model| Dyadic::new(model, 40, LIMIT).unwrap();
    hermite: "manifests/tiers/translational.toml" [
        "grid.load=0.3", "grid.speed=1400", "run.transient=2",
        "run.cycles=10", "run.settle=false", "mesh.coast_flank=same_line", "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ] |model| Hermite::new(model, CELLS, LIMIT).unwrap();
    spectral: "manifests/tiers/translational.toml" [
        "grid.load=0.3", "grid.speed=1200", "run.transient=2",
        "run.cycles=10", "run.settle=false", "mesh.coast_flank=same_line",
        r#"excitation.torque_ripple=[{shaft="pinion",order=2,amplitude="3 N*m"}]"#, "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ] |model| Spectral::new(model, CELLS, LIMIT, None).unwrap();
    event_grid: "manifests/tiers/torsional.toml" [
        "grid.load=0.3", "run.transient=2",
        "run.cycles=10", "run.settle=false", "mesh.coast_flank=same_line", "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ] |model| Spectral::new(model, CELLS, LIMIT, Some(64)).unwrap();
    fused: "manifests/tiers/tilting.toml" [
        "grid.load=0.3", "grid.speed=1200", "run.transient=2",
        "run.cycles=10", "run.settle=false", "mesh.coast_flank=same_line", "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ] |model| Fused::new(model, CELLS, LIMIT).unwrap();
    ripple_fused: "manifests/tiers/translational.toml" [
        "grid.load=0.3", "grid.speed=1200", "run.transient=2", "run.cycles=8",
        "run.settle=false", "analyses.lyapunov={align=2}", "analyses.poincare.samples=3",
        "mesh.coast_flank=same_line", r#"excitation.torque_ripple=[{shaft="wheel",order=1.5,amplitude="3 N*m"}]"#,
        "mesh.friction=0.1",
    ] |model| Fused::new(model, CELLS, LIMIT).unwrap();
    dyadic_continuous: "manifests/tiers/torsional.toml" [
        "mesh.stiffness=continuous", "mesh.segments=",
        "mesh.coast_flank=same_line", "grid.load=0.3", "grid.speed=1200", "run.transient=2", "run.cycles=8",
        "run.settle=false", "analyses.lyapunov={align=2}", "analyses.poincare.samples=3",
    ] |model| Dyadic::new(model, CELLS, LIMIT).unwrap();
    hermite_continuous: "manifests/tiers/torsional.toml" [
        "mesh.stiffness=continuous", "mesh.segments=",
        "mesh.coast_flank=same_line", "grid.load=0.3", "grid.speed=1200", "run.transient=2", "run.cycles=8",
        "run.settle=false", "analyses.lyapunov={align=2}", "analyses.poincare.samples=3",
    ] |model| Hermite::new(model, CELLS, LIMIT).unwrap();
}

/// Analyses of a point.
struct Ask<'a> {
    model: &'a Model,
    point: gearatlas::manifest::PointSpec,
}

impl Ask<'_> {
    fn of<K: Kernel>(&self, kernel: &K) -> PointOutcome {
        let seed = PointSeed {
            seed: self.point.seed,
            point_id: self.point.point_id,
        };
        let start = self.model.start(&self.point.run.initial);
        let config = point_config(&self.point, seed);
        investigate(self.model, kernel, start, &config, &AtomicBool::new(false)).unwrap()
    }
}

/// Calls `see` with every point of a manifest, after changes of some keys.
fn each(manifest: &str, set: &[&str], mut see: impl FnMut(&Model, &Ask<'_>)) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(manifest);
    let text = fs::read_to_string(&path).unwrap();
    let changes: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    let changed = ManifestText {
        text: &text,
        changes: &changes,
    };
    let job = changed.job("m.toml", path.parent().unwrap()).unwrap();
    for point in job.points.iter() {
        let model = &common::parts().model(&point).unwrap();
        see(model, &Ask { model, point });
    }
}

/// Adds the results of a point.
fn add(columns: &mut Columns, found: &PointOutcome) {
    let nvh = found.nvh.as_ref().unwrap();
    let values = &nvh.values;
    let mut put = |name: &str, value: f64| columns.entry(name.to_owned()).or_default().push(value);
    for sample in &found.poincare {
        put("poincare deflection", sample.deflection);
        put("poincare velocity", sample.velocity);
    }
    for (name, value) in [
        ("events_per_cycle", found.events_per_cycle.unwrap()),
        ("grazing_count", found.grazing_count as f64),
        ("cycles", found.cycles as f64),
        ("fraction_drive", values.fractions[0]),
        ("fraction_free", values.fractions[1]),
        ("fraction_coast", values.fractions[2]),
        ("fraction_both", values.fractions[3]),
        ("deflection_mean", values.deflection_mean),
        ("deflection_rms", values.deflection_rms),
        ("deflection_pp", nvh.deflection_pp),
        ("deflection_peak", nvh.deflection_peak),
        ("deflection_crest", nvh.deflection_crest),
        ("deflection_kurtosis", values.deflection_kurtosis),
        ("force_mean", values.force_mean),
        ("force_std", values.force_std),
        ("force_peak", nvh.force_peak),
        ("power_loss", values.power_loss.unwrap_or_default()),
        ("impact_rate", values.impact_rate),
        ("impacts_drive", nvh.impacts[0] as f64),
        ("impacts_coast", nvh.impacts[1] as f64),
        ("impact_velocity", values.impact_velocity),
        ("impact_power", values.impact_power),
        ("rattle_index", values.rattle_index),
        ("flights", nvh.flights as f64),
        ("flight_mean", values.flight_mean.unwrap_or_default()),
        ("flight_median", values.flight_median.unwrap_or_default()),
        ("contacts", nvh.contacts as f64),
        ("contact_mean", values.contact_mean.unwrap_or_default()),
        ("contact_median", values.contact_median.unwrap_or_default()),
    ] {
        put(name, value);
    }
    for (name, values) in [
        ("harmonics", &values.harmonics),
        (
            "deflection_peak_quantiles",
            &values.deflection_peak_quantiles,
        ),
        ("force_peak_quantiles", &values.force_peak_quantiles),
        (
            "impact_velocity_quantiles",
            &values.impact_velocity_quantiles,
        ),
        ("contact_force", &values.contact_force),
    ] {
        for (number, value) in values.iter().enumerate() {
            put(&format!("{name}_{}", number + 1), *value);
        }
    }
}

/// Compares a case with its recorded results.
fn compare(case: &str, found: &Columns) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/paper/values");
    let text = fs::read_to_string(folder.join(format!("{case}.tsv"))).unwrap();
    let recorded = text.lines().map(|line| {
        let mut cells = line.split('\t');
        let name = cells.next().unwrap();
        let values = cells.map(|cell| match cell {
            "" => 0.0,
            cell => cell.parse().unwrap(),
        });
        (name.to_owned(), values.collect())
    });
    let recorded: Columns = recorded.collect();
    assert_eq!(
        recorded.keys().collect::<Vec<_>>(),
        found.keys().collect::<Vec<_>>(),
        "{case}"
    );
    for (name, recorded) in &recorded {
        let found = &found[name];
        assert_eq!(found.len(), recorded.len(), "{case}: {name}");
        let largest = recorded.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (a, b) in found.iter().zip(recorded) {
            let off = (a - b).abs();
            assert!(
                off <= RELATIVE * b.abs() + FLOOR * largest,
                "{case}: {name}: {a} and not {b}"
            );
        }
    }
}
