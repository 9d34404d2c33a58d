//! Calls the program of by_hand/peer.c.

use crate::clock;
use gearatlas::model::{Model, Release, TrajectoryState};
use serde_json::{Value, json};
use std::ffi::{CString, c_char, c_int, c_long, c_void};
use std::path::Path;
use std::process::Command;

#[link(name = "by_hand", kind = "static")]
unsafe extern "C" {
    fn by_hand_load(path: *const c_char) -> *mut c_void;
    fn by_hand_free(drive: *mut c_void);
    fn by_hand_set(
        drive: *mut c_void,
        motion: *const f64,
        tangent: *const f64,
        closed: *const c_int,
    );
    fn by_hand_get(drive: *const c_void, column: c_int, out: *mut f64);
    fn by_hand_run(drive: *mut c_void, cycles: c_long, tangent: c_int);
}

/// Folder of descriptions and tables, from the root of the repository.
const FOLDER: &str = "target/by-hand";

/// Participation, relative to the largest one, below which a mode is left out.
const UNFELT: f64 = 1e-9;

/// A drive of two flanks in the form of the C program, with the modes that participate in a flank.
pub struct HandWritten {
    drive: *mut c_void,
    /// Indices of its modes in the model.
    felt: Vec<usize>,
    all: usize,
}

impl HandWritten {
    /// Writes a description of a model for `by_hand/tables.py` and loads the computed tables; both files have this
    /// name.
    pub fn new(model: &Model, name: &str) -> Self {
        let felt = felt(model);
        let [case, tables] =
            ["json", "tables"].map(|kind| Path::new(FOLDER).join(format!("{name}.{kind}")));
        std::fs::create_dir_all(FOLDER).expect("target can be written");
        std::fs::write(&case, format!("{:#}\n", description(model, &felt)))
            .expect("target can be written");
        let status = Command::new(".venv/bin/python")
            .arg("benches/peers/by_hand/tables.py")
            .args([&case, &tables])
            .status()
            .expect("scripts/setup --python has been run");
        assert!(status.success(), "no tables of {name}");
        let path =
            CString::new(tables.to_str().expect("the path is text")).expect("the path is text");
        // SAFETY: the path ends in a zero.
        let drive = unsafe { by_hand_load(path.as_ptr()) };
        assert!(!drive.is_null(), "the tables of {name} cannot be read");
        Self {
            drive,
            felt,
            all: model.modes(),
        }
    }

    /// Number of modes of the C program.
    pub fn modes(&self) -> usize {
        self.felt.len()
    }

    /// Selects the components of its modes from a vector over all components of a state.
    fn of_contact_modes(&self, all: &[f64]) -> Vec<f64> {
        let part = |offset: usize| self.felt.iter().map(move |i| all[offset + i]);
        part(0).chain(part(self.all)).collect()
    }

    /// Advances by whole cycles from the start of one, with a tangent unless it is empty; returns the seconds.
    pub fn advance(&mut self, start: &TrajectoryState, tangent: &[f64], cycles: u64) -> f64 {
        let motion = self.of_contact_modes(&start.state);
        let count = c_int::from(!tangent.is_empty());
        let tangent = match count {
            0 => vec![0.0; motion.len()],
            _ => self.of_contact_modes(tangent),
        };
        let closed = [0, 1].map(|flank| c_int::from(start.contact.holds(flank)));
        // SAFETY: the vectors have two numbers for each of the drive's modes, and there are two flanks.
        unsafe {
            by_hand_set(
                self.drive,
                motion.as_ptr(),
                tangent.as_ptr(),
                closed.as_ptr(),
            )
        };
        let begin = clock::now();
        // SAFETY: the drive was loaded and is this object's own.
        unsafe { by_hand_run(self.drive, cycles as c_long, count) };
        clock::now() - begin
    }

    /// The motion (column 0) or tangent (column 1) of the C program minus another one, over all components. Components
    /// of omitted modes are zero.
    pub fn difference(&self, column: usize, other: &[f64]) -> Vec<f64> {
        let mut own = vec![0.0; 2 * self.modes()];
        // SAFETY: there is room for two numbers for each of the drive's modes.
        unsafe { by_hand_get(self.drive, column as c_int, own.as_mut_ptr()) }
        let mut apart = vec![0.0; 2 * self.all];
        for (place, &i) in self.felt.iter().enumerate() {
            for (own, i) in [(own[place], i), (own[self.modes() + place], self.all + i)] {
                apart[i] = own - other[i];
            }
        }
        apart
    }
}

impl Drop for HandWritten {
    fn drop(&mut self) {
        // SAFETY: the drive was loaded, and nothing else has it.
        unsafe { by_hand_free(self.drive) }
    }
}

/// Participations (w, g) of a model's flanks in deflection and force, one entry per mode.
fn participations(model: &Model) -> Vec<[Vec<f64>; 2]> {
    let direction = |flank: usize| model.contacts[flank].cycles[0].segments[0].direction;
    (0..2)
        .map(|flank| model.participations(direction(flank)))
        .collect()
}

/// The modes that participate in a flank.
fn felt(model: &Model) -> Vec<usize> {
    let w: Vec<_> = participations(model).into_iter().map(|[w, _]| w).collect();
    let largest = w
        .iter()
        .flatten()
        .fold(0.0_f64, |most, w| most.max(w.abs()));
    let is_felt = |&i: &usize| w.iter().any(|w| w[i].abs() > UNFELT * largest);
    (0..model.modes()).filter(is_felt).collect()
}

/// The input of `by_hand/tables.py`. The program must support the drive.
fn description(model: &Model, felt: &[usize]) -> Value {
    assert!(
        model.contacts.len() == 2 && model.ripple.is_empty(),
        "two flanks, nothing else"
    );
    let block = |&i: &usize| {
        let block = &model.blocks[i];
        let [companion, [stiffness, damping]] = block.generator;
        assert_eq!(companion, [0.0, 1.0], "the modes are coupled");
        [-stiffness, -damping, block.static_input[1]]
    };
    let of_contact_modes = |all: Vec<f64>| -> Vec<f64> { felt.iter().map(|&i| all[i]).collect() };
    let flanks = participations(model)
        .into_iter()
        .zip(&model.contacts)
        .map(|([w, g], contact)| {
            let cycle = &contact.cycles[0];
            let first = &cycle.segments[0];
            let [error] = &model.lines[model.line(first)].transmission_error[..] else {
                panic!("the transmission error is one wave");
            };
            assert_eq!(
                error.turns_per_cycle, 1.0,
                "the transmission error has the mesh frequency"
            );
            assert!(contact.cycles.len() == 1 && contact.release == Release::Deflection);
            for segment in &cycle.segments {
                assert!(segment.stiffness.is_constant() && segment.error.is_none());
                assert_eq!(
                    (segment.direction, segment.damping),
                    (first.direction, first.damping)
                );
            }
            let segment = |s: &gearatlas::model::Segment| (s.end, s.stiffness.mean());
            json!({
                "w": of_contact_modes(w),
                "g": of_contact_modes(g),
                "error": [error.amplitude, error.phase],
                "segments": cycle.segments.iter().map(segment).collect::<Vec<_>>(),
            })
        });
    json!({
        "period": model.period(),
        "half_gap": model.half_gap,
        "contact_damping": model.first_cycle().segments[0].damping,
        "modes": felt.iter().map(block).collect::<Vec<_>>(),
        "flanks": flanks.collect::<Vec<_>>(),
    })
}
