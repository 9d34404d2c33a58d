//! Checks of tooth geometry, load sharing and mesh tables.

use super::drives::default_gears;
use super::flank::EvenFlank;
use super::report::worse;
use super::{CheckError, Line, Subjects};
use crate::gear::{
    Contact, Face, FaceLaw, Flanks, GearPair, IndependentSlices, LoadSharing, MeshTable,
    MeshTableInputs, ToothForm, pairs_at,
};
use crate::store::{Origin, TableStore};

/// A steel pair for which results of another program are published: 62/62 teeth, module 2 mm, 20 mm wide,
/// bores of 35 mm.
fn published_pair() -> Result<Flanks, CheckError> {
    Ok(Flanks::new(&GearPair {
        teeth: [62, 62],
        module: 2e-3,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm {
            bore: [Some(35e-3); 2],
            ..ToothForm::default()
        },
    })?)
}

/// Contact ratio of a published pair.
pub fn geometry(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    let ratio = published_pair()?.contact_ratio();
    Ok(vec![Line::at_most(
        format!("contact ratio of 62/62 teeth, {ratio:.5}"),
        "1.78978 (another code)",
        (ratio - 1.78978).abs(),
        1e-5,
        "1",
    )])
}

/// Mean stiffness of the published pair, without the coupling of two tooth pairs by the gear bodies, compared with
/// another program. The rule of thumb of that program, ε b E/18, gives 4.0966e8 N/m. Its teeth are cantilevers on a
/// fitted foundation, which count a part of the root twice and are 5 % softer than elastic teeth. Such programs differ
/// by 5 % among themselves, because of the lever of the load and the root angle.
pub fn stiffness(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    const PHASES: u32 = 500;
    const PUBLISHED: f64 = 3.737e8;
    let flanks = published_pair()?;
    let path = flanks.path();
    let alone = |s: f64| flanks.face_width / flanks.compliance(s).total();
    let mut sum = 0.0;
    for i in 0..PHASES {
        let s = path.position((f64::from(i) + 0.5) / f64::from(PHASES));
        let next = s + path.base_pitch;
        sum += alone(s);
        if next <= path.end {
            sum += alone(next);
        }
    }
    let mean = sum / f64::from(PHASES);
    Ok(vec![Line::between(
        format!("mean stiffness of 62/62 teeth, {:.3}e8 N/m", 1e-8 * mean),
        "3.737e8 N/m (another code)",
        100.0 * (mean / PUBLISHED - 1.0),
        [0.0, 12.0],
        "%",
    )])
}

/// Stiffness and load centroid of a misaligned flank. The load is on a wedge of the length `√(2 F / (k' ε))`, with the
/// stiffness k' per width and the misalignment ε. This length determines stiffness and centroid.
pub fn wedge(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    let width = 20e-3;
    let stiffness = 4e8 / width;
    let force = default_gears()?.rated_force();
    let angle = 1e-3;
    let law = EvenFlank::new(1.0, stiffness);
    let length = (2.0 * force / (stiffness * angle)).sqrt();
    let mut worst = [0.0f64; 2];
    for misalignment in [angle, -angle] {
        for slices in [1, 7, 64] {
            let face = Face { width, slices };
            let pairs = pairs_at(&law, 0.5, face)?;
            let load = LoadSharing::new(&pairs, face, misalignment)?.distribute(force);
            let centre = -misalignment.signum() * (0.5 * width - length / 3.0);
            worst[0] = worse(
                worst[0],
                (load.stiffness / (stiffness * length) - 1.0).abs(),
            );
            worst[1] = worse(worst[1], (load.centre / centre - 1.0).abs());
        }
    }
    let part = 100.0 * length / width;
    let against = "wedge of length sqrt(2 F / (k' eps))";
    Ok(vec![
        Line::at_most(
            format!("stiffness at 1 mrad, {part:.1} % of the face loaded"),
            against,
            worst[0],
            1e-13,
            "relative",
        ),
        Line::at_most(
            "load centroid at 1 mrad",
            against,
            worst[1],
            1e-13,
            "relative",
        ),
    ])
}

/// Compares a mesh table with direct load sharing between the nodes of the table, and with itself after
/// writing and reading.
pub fn mesh_table(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let gears = default_gears()?;
    let inputs = MeshTableInputs {
        misalignment: vec![0.0, 1e-4],
        torque: vec![25.0, 50.0],
        slices: 8,
        face: FaceLaw::Independent,
        contact: Contact::Linear,
        ..MeshTableInputs::of_gears(&gears)
    };
    let flanks = Flanks::new(&gears)?;
    let table = MeshTable::build(&flanks, &inputs, &|_, _| ())?;
    let face = Face {
        width: gears.face_width,
        slices: inputs.slices,
    };
    let places = subjects.extent.pick(97, 997);
    let mut worst = 0.0f64;
    for (i, &misalignment) in inputs.misalignment.iter().enumerate() {
        for j in 0..inputs.torque.len() {
            let cycle = table.cycle(i, j);
            for place in 0..places {
                let phase = (f64::from(place) + 0.37) / f64::from(places);
                let pairs = pairs_at(&IndependentSlices(&flanks), phase, face)?;
                let load = LoadSharing::new(&pairs, face, misalignment)?.distribute(cycle.force);
                let found = cycle.value(&cycle.stiffness, phase);
                worst = worse(worst, (found / load.stiffness - 1.0).abs());
            }
        }
    }

    let folder = tempfile::tempdir()?;
    let store = TableStore::open(folder.path());
    let built = store.mesh_table(&gears, &inputs, &|_, _| ())?;
    let found = store.mesh_table(&gears, &inputs, &|_, _| ())?;
    let differing = match found.origin {
        Origin::Found => differing(&built.table, &found.table) + differing(&table, &found.table),
        Origin::Built | Origin::BuiltInMemory => {
            return Err(CheckError::Missing {
                what: "the table that was just written",
            });
        }
    };
    Ok(vec![
        Line::at_most(
            "table's stiffness between nodes, default pair",
            "direct load sharing",
            worst,
            1e-9,
            "relative",
        ),
        Line::at_most(
            format!("table read back, {} numbers", numbers(&found.table).len()),
            "table as it was computed",
            differing as f64,
            0.0,
            "numbers",
        ),
    ])
}

/// All numbers of a table.
fn numbers(table: &MeshTable) -> Vec<f64> {
    [
        &table.misalignment,
        &table.torque,
        &table.breaks,
        &table.node,
        &table.stiffness,
        &table.centre,
        &table.transmission_error,
        &table.friction,
        &table.friction_lever,
        &table.contact_fraction,
        &table.share,
        &table.pattern,
    ]
    .into_iter()
    .flatten()
    .copied()
    .collect()
}

/// Number of values of two tables that differ in any bit.
pub(super) fn differing(a: &MeshTable, b: &MeshTable) -> usize {
    let (a, b) = (numbers(a), numbers(b));
    let unequal = a.iter().zip(&b).filter(|(a, b)| a.to_bits() != b.to_bits());
    unequal.count() + a.len().abs_diff(b.len())
}
