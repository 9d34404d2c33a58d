//! The content hash of a job: BLAKE3 over the resolved values, so that comments, layout,
//! key order, equal units and the job's name do not matter and everything that can change
//! a result does. Every structure is taken apart field by field: a new field that is
//! forgotten here does not compile.

mod gear;
mod mesh;
mod text;

use super::points::Variant;
use super::spec::{
    AnalysesSpec, Axis, Carried, ExcitationSpec, HorizonSpec, InitialSpec, KernelSpec, Ladder,
    LyapunovSpec, ModelSpec, MultistabilitySpec, NvhSpec, OrbitsSpec, PoincareSpec, RunSpec,
    SectionSpec, ShaftName, SliceSpec, StructureSource, TorqueRipple, TransmissionErrorHarmonic,
};
use crate::gear::GearPair;
use crate::shaft::{
    Bearing, BearingGain, FlexibleDrive, ModalStructure, Pedestal, RigidDrive, Shaft,
};

/// Changes whenever the meaning of the hashed bytes does.
const FORMAT: &str = "atlas job 1";

/// The hash of a job in the making.
#[derive(Debug)]
pub(super) struct JobHash(blake3::Hasher);

impl JobHash {
    /// Begins with what is common to all points.
    pub fn new(seed: u64, axes: &[&Axis], carried: Option<&Carried>) -> Self {
        let mut hash = Self(blake3::Hasher::new());
        hash.text(FORMAT);
        hash.integer(seed);
        hash.integer(axes.len() as u64);
        for Axis { name, unit, values } in axes {
            hash.text(name);
            hash.text(unit);
            hash.integer(values.len() as u64);
            for value in values.iter() {
                hash.number(value);
            }
        }
        // Named rather than flagged: jobs of independent points keep the hash they had.
        if let Some(Carried {
            axis,
            length: _,
            directions,
        }) = carried
        {
            hash.text("carried");
            hash.integer(*axis as u64);
            hash.integer(directions.len() as u64);
            for direction in directions {
                hash.text(direction.name());
            }
        }
        hash
    }

    /// Lower-case hexadecimal.
    pub fn finish(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }

    /// Everything about the points of one combination of model keys.
    pub fn resolved(&mut self, resolved: &Variant) {
        let Variant {
            model,
            mesh,
            excitation,
            run,
            analyses,
        } = resolved;
        self.model(model);
        self.mesh(mesh);
        self.excitation(excitation);
        self.run(run);
        self.analyses(analyses);
    }

    fn integer(&mut self, value: u64) {
        self.0.update(&value.to_le_bytes());
    }

    fn number(&mut self, value: f64) {
        // −0 and 0 are the same quantity.
        self.integer((value + 0.0).to_bits());
    }

    fn numbers(&mut self, values: &[f64]) {
        self.integer(values.len() as u64);
        for &value in values {
            self.number(value);
        }
    }

    fn text(&mut self, text: &str) {
        self.integer(text.len() as u64);
        self.0.update(text.as_bytes());
    }

    fn flag(&mut self, flag: bool) {
        self.integer(u64::from(flag));
    }

    fn optional<T>(&mut self, value: Option<&T>, write: impl FnOnce(&mut Self, &T)) {
        self.flag(value.is_some());
        if let Some(value) = value {
            write(self, value);
        }
    }

    fn model(&mut self, model: &ModelSpec) {
        let ModelSpec {
            source,
            modes,
            retained,
            mta,
        } = model;
        self.text(source.kind());
        match source {
            StructureSource::Rigid(drive) => self.rigid(drive),
            StructureSource::Flexible(drive) => self.drive(drive),
            StructureSource::Modal(structure) => self.structure(structure),
        }
        self.integer(*modes as u64);
        self.integer(*retained as u64);
        self.flag(*mta);
    }

    fn drive(&mut self, drive: &FlexibleDrive) {
        let FlexibleDrive {
            gears,
            shafts,
            young_modulus,
            shear_modulus,
            density,
            shear_coefficient,
            elements,
            damping,
            damping_overrides,
        } = drive;
        self.machine(gears, shafts);
        for value in [
            young_modulus,
            shear_modulus,
            density,
            shear_coefficient,
            damping,
        ] {
            self.number(*value);
        }
        for &count in elements {
            self.integer(count as u64);
        }
        self.overrides(damping_overrides);
    }

    fn rigid(&mut self, drive: &RigidDrive) {
        let RigidDrive {
            // The kind is its name.
            tier: _,
            gears,
            shafts,
            pedestals,
            density,
            damping,
            damping_overrides,
        } = drive;
        self.machine(gears, shafts);
        self.number(*density);
        self.number(*damping);
        self.overrides(damping_overrides);
        self.optional(pedestals.as_ref(), |hash, pedestals| {
            for pedestal in pedestals.iter().flatten() {
                let Pedestal {
                    line_of_centres,
                    across,
                    mass,
                } = *pedestal;
                hash.numbers(&[line_of_centres, across, mass]);
            }
        });
    }

    fn overrides(&mut self, overrides: &[(usize, f64)]) {
        self.integer(overrides.len() as u64);
        for &(mode, ratio) in overrides {
            self.integer(mode as u64);
            self.number(ratio);
        }
    }

    /// What all drives have.
    fn machine(&mut self, gears: &GearPair, shafts: &[Shaft; 2]) {
        self.gears(gears);
        for shaft in shafts {
            let Shaft {
                diameter,
                span,
                overhang,
                gear_position,
                end_inertia,
                bearings,
            } = shaft;
            for value in [diameter, span, overhang, gear_position, end_inertia] {
                self.number(*value);
            }
            for bearing in bearings {
                let Bearing {
                    line_of_centres,
                    across,
                    axial,
                    tilt,
                } = bearing;
                for value in [line_of_centres, across, axial, tilt] {
                    self.number(*value);
                }
            }
        }
    }

    fn structure(&mut self, structure: &ModalStructure) {
        let ModalStructure {
            teeth,
            wheel_teeth,
            rated_force,
            frequency,
            damping,
            mesh,
            mesh_tilt,
            torque,
            pinion_torque,
            wheel_torque,
            friction,
            friction_lever,
            residual_flexibility,
            bearings,
        } = structure;
        self.integer(u64::from(*teeth));
        self.optional(wheel_teeth.as_ref(), |hash, &teeth| {
            hash.integer(u64::from(teeth))
        });
        self.number(*rated_force);
        for column in [
            frequency,
            damping,
            mesh,
            mesh_tilt,
            torque,
            friction,
            friction_lever,
        ] {
            self.numbers(column);
        }
        for column in [pinion_torque, wheel_torque] {
            self.optional(column.as_ref(), |hash, column| hash.numbers(column));
        }
        self.number(*residual_flexibility);
        // Named rather than counted: files without any keep the hash they had before.
        for BearingGain { name, gain } in bearings {
            self.text(name);
            self.numbers(gain);
        }
    }

    fn excitation(&mut self, excitation: &ExcitationSpec) {
        let ExcitationSpec {
            transmission_error,
            table_harmonics,
            torque_ripple,
        } = excitation;
        // Named rather than flagged: jobs without them keep the hash they had.
        if let Some(count) = table_harmonics {
            self.text("table harmonics");
            self.integer(u64::from(*count));
        }
        self.integer(transmission_error.len() as u64);
        for term in transmission_error {
            let TransmissionErrorHarmonic {
                harmonic,
                amplitude,
                phase,
            } = *term;
            self.integer(u64::from(harmonic));
            self.number(amplitude);
            self.number(phase);
        }
        self.integer(torque_ripple.len() as u64);
        for term in torque_ripple {
            let TorqueRipple {
                shaft,
                order,
                amplitude,
                phase,
            } = *term;
            self.flag(shaft == ShaftName::Wheel);
            self.number(order);
            self.number(amplitude);
            self.number(phase);
        }
    }

    fn run(&mut self, run: &RunSpec) {
        let RunSpec {
            transient,
            cycles,
            kernel,
            initial,
            settle,
            audit_cycles,
            event_limit,
            portable,
        } = run;
        self.integer(*transient);
        self.integer(*cycles);
        match kernel {
            KernelSpec::Volterra { tolerance } => {
                self.text("volterra");
                self.number(*tolerance);
            }
            KernelSpec::Stepping { steps } => {
                self.text("stepping");
                self.integer(u64::from(*steps));
            }
            KernelSpec::Tables { ladder, cells } => {
                self.text(ladder.name());
                self.integer(u64::from(*cells));
                if let Ladder::Spectral {
                    event_grid: Some(parts),
                } = ladder
                {
                    self.integer(u64::from(*parts));
                }
            }
        }
        match initial {
            InitialSpec::Static => self.text("static"),
            InitialSpec::Rest => self.text("rest"),
            InitialSpec::Modal {
                displacement,
                velocity,
            } => {
                self.text("modal");
                self.numbers(displacement);
                self.numbers(velocity);
            }
        }
        self.flag(*settle);
        self.integer(*audit_cycles);
        self.integer(u64::from(*event_limit));
        // Named rather than flagged: jobs that take what the processor has keep their hash.
        if *portable {
            self.text("portable");
        }
    }

    fn analyses(&mut self, analyses: &AnalysesSpec) {
        let AnalysesSpec {
            lyapunov,
            poincare,
            nvh,
            multistability,
            orbits,
            horizon,
        } = analyses;
        self.optional(lyapunov.as_ref(), |hash, lyapunov| {
            let LyapunovSpec {
                exponents,
                stop_at_stderr,
                align,
                twin,
                raw_norm,
            } = *lyapunov;
            hash.integer(exponents as u64);
            hash.optional(stop_at_stderr.as_ref(), |hash, &bound| hash.number(bound));
            hash.integer(align);
            hash.flag(twin);
            hash.flag(raw_norm);
        });
        self.optional(poincare.as_ref(), |hash, poincare| {
            let PoincareSpec {
                samples,
                section,
                refine,
            } = *poincare;
            hash.integer(samples as u64);
            // Jobs that take the defaults keep the hash they had before there were others.
            match section {
                SectionSpec::Strobe { phase: 0.0 } => {}
                SectionSpec::Strobe { phase } => {
                    hash.text("strobe");
                    hash.number(phase);
                }
                SectionSpec::Entry => hash.text("entry"),
                SectionSpec::Turning => hash.text("turning"),
            }
            if refine > 0 {
                hash.text("refine");
                hash.integer(u64::from(refine));
            }
        });
        self.optional(nvh.as_ref(), |hash, nvh| {
            let NvhSpec {
                harmonics,
                spectrum,
                bearings,
            } = *nvh;
            hash.integer(harmonics as u64);
            hash.flag(spectrum);
            if bearings {
                hash.text("bearings");
            }
        });
        // Named rather than flagged: jobs that do not ask keep the hash they had before.
        if let Some(multistability) = multistability {
            let MultistabilitySpec {
                initial_conditions,
                decades,
                transient,
                cycles,
                slice,
            } = *multistability;
            self.text("multistability");
            self.integer(u64::from(initial_conditions));
            self.number(decades);
            self.integer(transient);
            self.integer(cycles);
            if let Some(slice) = slice {
                let SliceSpec {
                    modes,
                    velocity,
                    extent,
                    count,
                } = slice;
                self.text("slice");
                for mode in modes {
                    self.integer(mode as u64);
                }
                self.flag(velocity);
                self.number(extent);
                self.integer(u64::from(count));
            }
        }
        if let Some(orbits) = orbits {
            let OrbitsSpec {
                periods,
                guesses,
                cycles,
                floquet,
            } = orbits;
            self.text("orbits");
            self.integer(periods.len() as u64);
            periods.iter().for_each(|p| self.integer(u64::from(*p)));
            self.integer(u64::from(*guesses));
            self.integer(u64::from(*cycles));
            self.flag(*floquet);
        }
        if let Some(horizon) = horizon {
            let HorizonSpec {
                twins,
                separation,
                cycles,
                averages,
            } = *horizon;
            self.text("horizon");
            self.integer(u64::from(twins));
            self.number(separation);
            self.integer(cycles);
            self.integer(averages);
        }
    }
}
