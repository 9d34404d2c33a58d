//! Random modal drives, and the manifests that describe them.

use super::dice::Dice;
use gearatlas::gear::{EvenSharing, GearPair, ToothForm};
use gearatlas::model::{
    Division, Drive, DriveShaft, InitialState, MeshHarmonic, OperatingPoint, Release, TorqueRipple,
};
use gearatlas::numerics::random::Stream;
use gearatlas::structure::ModalStructure;
use std::fmt::Write;

/// The drawing for the changes of friction, as in a manifest with a modal file.
const GEAR: &str = "[gear]\nteeth = [20, 30]\nmodule = \"4 mm\"\npressure_angle = \"20 deg\"\nface_width = \"20 mm\"\n\
                    body_length = [\"20 mm\", \"20 mm\"]\nrated_torque = \"50 N*m\"\n";

/// The sliding of the pairs of teeth of [`GEAR`].
fn pairs() -> EvenSharing {
    let pair = GearPair {
        teeth: [20, 30],
        module: 4e-3,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm::default(),
    };
    EvenSharing::new(&pair).unwrap()
}

/// A drive at an operating point, with its initial state.
#[derive(Debug, Clone)]
pub struct Drawn {
    pub structure: ModalStructure,
    pub drive: Drive,
    pub point: OperatingPoint,
    pub start: InitialState,
    /// Ends and stiffness of the mesh divisions, as a manifest has them.
    mesh: String,
}

impl Drawn {
    /// The drive with a number under a seed.
    pub fn new(seed: u64, number: u64) -> Self {
        let mut dice = Dice(Stream::new(seed, number, 0));
        let n = 1 + dice.below(8);
        let rigid = match n {
            1 => usize::from(dice.chance(0.7)),
            _ => dice.pick(&[0, 1, 1, 1, 1, 2]),
        };
        let mut frequency = vec![0.0; rigid];
        let mut damping = vec![0.0; rigid];
        while frequency.len() < n {
            let last = frequency.last().copied().unwrap_or(0.0);
            if last > 0.0 && dice.chance(0.3) {
                // A repeated mode, or a nearly repeated one.
                let exponent = -dice.between(3.0, 16.0);
                let apart = dice.pick(&[0.0, 10f64.powf(exponent)]);
                frequency.push(last * (1.0 + apart));
                damping.push(damping[damping.len() - 1]);
                continue;
            }
            frequency.push(dice.decades(2.3, 4.6));
            let share = dice.decades(-4.0, -0.3);
            let short = dice.decades(-10.0, -1.0);
            damping.push(match dice.below(10) {
                0 => 0.0,
                1 => 1.0 - short,
                2..5 => share,
                _ => 0.01,
            });
        }
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| frequency[a].total_cmp(&frequency[b]));
        let frequency: Vec<f64> = order.iter().map(|&i| frequency[i]).collect();
        let damping = order.iter().map(|&i| damping[i]).collect();
        let participation = |dice: &mut Dice| -> Vec<f64> {
            (0..n)
                .map(|_| match dice.below(10) {
                    0 => 0.0,
                    1 => dice.decades(-9.0, -2.0),
                    2 => 4.0 * dice.0.normal(),
                    _ => 0.6 * dice.0.normal(),
                })
                .collect()
        };
        let mut mesh = participation(&mut dice);
        mesh[0] = dice.between(0.3, 1.5);
        let mut torque = if dice.chance(0.5) { mesh.clone() } else { participation(&mut dice) };
        // Only the mesh can balance a load on a rigid mode, so the load acts there like the mesh force.
        torque[..rigid].copy_from_slice(&mesh[..rigid]);
        let rubs = dice.chance(0.25);
        let friction = if rubs {
            (0..n)
                .map(|i| if i < rigid { 0.0 } else { 0.5 * dice.0.normal() })
                .collect()
        } else {
            vec![0.0; n]
        };
        let rippled = dice.chance(0.3);
        let pinion_torque = rippled.then(|| mesh.iter().map(|w| 20.0 * w).collect::<Vec<_>>());
        let stiffness = dice.decades(7.3, 9.2);
        let (divisions, text) = Self::mesh(&mut dice, stiffness);
        let divisions = if rubs { pairs().cut(&divisions) } else { divisions };
        let inertia: f64 = mesh.iter().map(|w| w * w).sum();
        let critical = 2.0 * (stiffness / inertia).sqrt();
        let ratio = match dice.below(10) {
            0 => 0.0,
            1 => 1.0 + dice.decades(-12.0, -0.5) * dice.pick(&[-1.0, 1.0]),
            2 => dice.between(1.0, 5.0),
            3..6 => dice.decades(-3.0, -0.3),
            _ => 0.05,
        };
        let half_gap = dice.decades(-6.0, -4.0);
        let errors = dice.below(4);
        let transmission_error = (1..=errors)
            .map(|harmonic| {
                let amplitude = half_gap * dice.decades(-2.0, 0.3) / harmonic as f64;
                MeshHarmonic::new(harmonic as u32, amplitude, dice.between(-3.0, 3.0))
            })
            .collect();
        let torque_ripple = if rippled {
            vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order: dice.pick(&[1.0, 2.0, 20.0, 1.5]),
                amplitude: dice.decades(-1.0, 1.0),
                phase: dice.between(-3.0, 3.0),
            }]
        } else {
            Vec::new()
        };
        // Mesh frequencies within two decades of that of the closed mesh.
        let closed = (stiffness * inertia).sqrt();
        let speed = closed * dice.decades(-1.3, 0.7) / 20.0;
        let point = OperatingPoint {
            load: match dice.below(12) {
                0 => 0.0,
                1 => dice.decades(-8.0, -3.0),
                _ => dice.decades(-2.0, 0.3),
            },
            speed,
        };
        let start = if dice.chance(0.6) {
            InitialState::Static
        } else {
            InitialState::Modal {
                displacement: (0..n)
                    .map(|_| half_gap * dice.0.normal() / inertia.sqrt())
                    .collect(),
                velocity: (0..n)
                    .map(|_| closed * half_gap * dice.0.normal() / inertia.sqrt())
                    .collect(),
            }
        };
        Self {
            structure: ModalStructure {
                contacts: Vec::new(),
                coast: None,
                teeth: 20,
                wheel_teeth: None,
                frame: Default::default(),
                rated_force: 1330.0,
                mesh_mass: None,
                frequency,
                damping,
                mesh_tilt: vec![0.0; n],
                mesh,
                torque,
                pinion_torque,
                wheel_torque: None,
                friction,
                friction_lever: vec![0.0; n],
                residual_flexibility: 0.0,
                tilt_residuals: Vec::new(),
                bearings: Vec::new(),
                torques: Vec::new(),
                motions: Vec::new(),
                coupling: None,
                constant_load: Vec::new(),
                load_by_speed: Vec::new(),
                harmonic_loads: Vec::new(),
                meshes: Vec::new(),
                shafts: Vec::new(),
                shapes: None,
            },
            drive: Drive {
                coast: None,
                half_gap,
                mesh: divisions,
                damping: ratio * critical,
                friction: if rubs { dice.between(0.0, 0.1) } else { 0.0 },
                release: Release::Deflection,
                transmission_error,
                torque_ripple,
                further: Vec::new(),
                imposed_motion: Vec::new(),
                tooth_cycles: Default::default(),
                film: None,
            },
            point,
            start,
            mesh: text,
        }
    }

    /// A mesh with one level of stiffness, with two, or with a list of levels.
    fn mesh(dice: &mut Dice, stiffness: f64) -> (Vec<Division>, String) {
        let levels: Vec<f64> = match dice.below(4) {
            0 => {
                return (
                    Division::levels(&[stiffness], &[]),
                    format!("stiffness = \"constant\"\nmean_stiffness = {stiffness:e}\n"),
                );
            }
            1 => (0..5).map(|_| stiffness * dice.between(0.6, 1.4)).collect(),
            _ => {
                let low = stiffness * dice.between(0.5, 0.95);
                [[stiffness; 3].as_slice(), &[low; 2]].concat()
            }
        };
        let list: Vec<String> = levels.iter().map(|k| format!("{k:e}")).collect();
        let text = format!(
            "stiffness = \"piecewise\"\nvalues = [{}]\n",
            list.join(", ")
        );
        (Division::levels(&levels, &[]), text)
    }

    /// The manifest of the drive, and the modal file that the manifest names.
    pub fn manifest(&self, name: &str, kernel: &str) -> [String; 2] {
        let list = |values: &[f64]| {
            let all: Vec<String> = values.iter().map(|v| format!("{v:e}")).collect();
            format!("[{}]", all.join(", "))
        };
        let Self {
            structure: s,
            drive: d,
            point,
            ..
        } = self;
        let mut modal = format!("teeth = {}\nrated_force = {:e}\n", s.teeth, s.rated_force);
        let columns = [
            ("frequency", Some(&s.frequency)),
            ("damping", Some(&s.damping)),
            ("mesh", Some(&s.mesh)),
            ("torque", Some(&s.torque)),
            ("friction", Some(&s.friction)),
            ("pinion_torque", s.pinion_torque.as_ref()),
        ];
        for (key, column) in columns {
            if let Some(column) = column {
                let _ = writeln!(modal, "{key} = {}", list(column));
            }
        }
        let errors: Vec<String> = (d.transmission_error.iter())
            .map(|h| {
                format!(
                    "{{ harmonic = {}, amplitude = {:e}, phase = {:e} }}",
                    h.harmonic, h.amplitude, h.phase
                )
            })
            .collect();
        let ripples: Vec<String> = (d.torque_ripple.iter())
            .map(|r| {
                format!(
                    "{{ shaft = \"pinion\", order = {}, amplitude = {:e}, phase = {:e} }}",
                    r.order, r.amplitude, r.phase
                )
            })
            .collect();
        let start = match &self.start {
            InitialState::Modal {
                displacement,
                velocity,
            } => format!(
                "{{ displacement = {}, velocity = {} }}",
                list(displacement),
                list(velocity)
            ),
            InitialState::Static | InitialState::Rest => "\"static\"".to_owned(),
        };
        let manifest = format!(
            "[job]\nname = \"{name}\"\n[model]\nkind = \"modal\"\nfile = \"{name}.modal.toml\"\n{}\
             [mesh]\nhalf_gap = {:e}\nfriction = {:e}\ncontact_damping = \"{:e} N*s/m\"\n{}\
             [excitation]\ntransmission_error = [{}]\ntorque_ripple = [{}]\n\
             [grid]\nload = {:e}\nspeed = {:e}\n\
             [run]\ntransient = {}\ncycles = {}\nkernel = \"{kernel}\"\ninitial = {start}\n\
             [analyses]\nlyapunov = {{}}\nnvh = {{}}\n",
            if d.friction > 0.0 { GEAR } else { "" },
            d.half_gap,
            d.friction,
            d.damping,
            self.mesh,
            errors.join(", "),
            ripples.join(", "),
            point.load,
            point.speed,
            crate::random_drives::TRANSIENT,
            crate::random_drives::CYCLES,
        );
        [manifest, modal]
    }
}
