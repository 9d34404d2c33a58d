//! The precision of NVH statistics, by which a stop rule ends the measurement.
//!
//! The standard error of a time average, or of a line of a spectrum or order, is divided by a scale, so that
//! precision is comparable at any load:
//!
//! * root mean squares, rates, powers and mean durations: the value itself;
//! * the mean of a signal, which may be zero: its root mean square, including the mean;
//! * powers in the balance of the vibration, some of which may be zero: the largest of them;
//! * the amplitude at an order or of a spectral line: the amplitude of a sine with the signal's root mean
//!   square about the mean, `√2` times as large;
//! * fractions of time: 1.
//!
//! Power through the mesh and efficiency are omitted because they follow from the mean force and the loss.
//! Extremes, quantiles and medians are omitted because they are not averages.

use super::outcome::{NvhOutcome, NvhStatistics, SignalOrders, Spectrum};
use std::f64::consts::SQRT_2;
use std::fmt;

/// Variation of a signal, relative to its mean, below which the variation is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Mean of a signal and root mean square about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalSize {
    /// Mean.
    pub mean: f64,
    /// Root mean square about it.
    pub rms: f64,
}

impl SignalSize {
    /// Scale of the error of the mean.
    fn whole(self) -> f64 {
        self.mean.hypot(self.rms)
    }

    /// Scale of the error of the root mean square.
    fn motion(self) -> f64 {
        self.rms.max(ROUND_OFF * self.mean.abs())
    }

    /// Scale of the error of a line.
    fn sine(self) -> f64 {
        SQRT_2 * self.motion()
    }
}

/// The least precise statistic.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastPrecise {
    /// Name of the column, or of the table and its signal.
    pub name: String,
    /// Relative standard error of the statistic; infinite if the record is too short.
    pub error: f64,
}

impl fmt::Display for LeastPrecise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.error.is_finite() {
            write!(
                f,
                "{} has a relative standard error of {:.2e}",
                self.name, self.error
            )
        } else {
            write!(f, "{} has no standard error yet", self.name)
        }
    }
}

/// An average, or its standard error.
type Average = fn(&NvhStatistics) -> Option<f64>;

/// Statistics with one element per output of the structure, or their standard errors.
type Lists<const N: usize> = fn(&NvhStatistics) -> [&Vec<f64>; N];

/// A search for the statistic with the largest relative error.
struct ErrorSearch(LeastPrecise);

impl ErrorSearch {
    /// Compares an error, relative to its scale, with the largest one so far. A relative error of NaN counts
    /// as infinite.
    fn take(&mut self, name: &str, error: f64, scale: f64) {
        let relative = match error {
            0.0 => 0.0,
            _ => error / scale,
        };
        let relative = if relative.is_nan() { f64::INFINITY } else { relative };
        if relative > self.0.error {
            self.0 = LeastPrecise {
                name: name.to_owned(),
                error: relative,
            };
        }
    }

    fn take_each(&mut self, name: &str, errors: &[f64], scale: impl Fn(usize) -> f64) {
        for (index, error) in errors.iter().enumerate() {
            self.take(name, *error, scale(index));
        }
    }

    /// Statistics of the deflection, the mesh force and contact.
    fn take_mesh(&mut self, values: &NvhStatistics, errors: &NvhStatistics) {
        let [deflection, force] = mesh_sizes(values);
        self.take(
            "deflection_mean",
            errors.deflection_mean,
            deflection.whole(),
        );
        self.take("deflection_rms", errors.deflection_rms, deflection.motion());
        self.take("force_mean", errors.force_mean, force.whole());
        self.take("force_std", errors.force_std, force.motion());
        self.take_each("harmonics", &errors.harmonics, |_| deflection.sine());
        self.take_each("suborders", &errors.suborders, |_| deflection.sine());
        let averages: [(&str, Average); 8] = [
            ("deflection_kurtosis", |of| Some(of.deflection_kurtosis)),
            ("power_loss", |of| of.power_loss),
            ("impact_rate", |of| Some(of.impact_rate)),
            ("impact_velocity", |of| Some(of.impact_velocity)),
            ("impact_power", |of| Some(of.impact_power)),
            ("rattle_index", |of| Some(of.rattle_index)),
            ("flight_mean", |of| of.flight_mean),
            ("contact_mean", |of| of.contact_mean),
        ];
        for (name, of) in averages {
            // A value of zero has no error, for example an impact speed without impacts.
            if let Some(value) = of(values).filter(|value| *value != 0.0) {
                self.take(name, of(errors).unwrap_or(f64::INFINITY), value.abs());
            }
        }
        let names = [
            "fraction_drive",
            "fraction_free",
            "fraction_coast",
            "fraction_both",
        ];
        for (name, error) in names.iter().zip(errors.fractions) {
            self.take(name, error, 1.0);
        }
    }

    /// Powers of the vibration.
    fn take_power(&mut self, values: &NvhStatistics, errors: &NvhStatistics) {
        let (Some(values), Some(errors)) = (&values.power, &errors.power) else {
            return;
        };
        for (name, error) in [
            ("power_in_loads", errors.loads),
            ("power_in_error", errors.error),
            ("power_in_stiffness", errors.stiffness),
            ("power_out_contact", errors.contact),
            ("power_out_structure", errors.structure),
            ("power_out_friction", errors.friction),
            ("power_stored", errors.stored),
        ] {
            self.take(name, error, values.largest());
        }
    }

    /// Statistics of the structure's outputs.
    fn take_outputs(&mut self, values: &NvhStatistics, errors: &NvhStatistics) {
        let signals: [([&str; 2], Lists<2>); 2] = [
            (["bearing_mean", "bearing_rms"], |of| {
                [&of.bearing_mean, &of.bearing_rms]
            }),
            (["torque_mean", "torque_rms"], |of| {
                [&of.torque_mean, &of.torque_rms]
            }),
        ];
        for ([mean, rms], of) in signals {
            let [means, all_rms] = of(values);
            let size = |index: usize| SignalSize {
                mean: means[index],
                rms: all_rms[index],
            };
            let [mean_errors, rms_errors] = of(errors);
            self.take_each(mean, mean_errors, |index| size(index).whole());
            self.take_each(rms, rms_errors, |index| size(index).motion());
        }
        let rates: [(&str, Lists<1>); 4] = [
            ("acceleration_rms", |of| [&of.acceleration_rms]),
            ("angular_acceleration_rms", |of| {
                [&of.angular_acceleration_rms]
            }),
            ("mesh_deflection_rms", |of| [&of.mesh_deflection_rms]),
            ("mesh_force_rms", |of| [&of.mesh_force_rms]),
        ];
        for (name, of) in rates {
            let ([values], [errors]) = (of(values), of(errors));
            self.take_each(name, errors, |index| values[index]);
        }
    }
}

fn mesh_sizes(values: &NvhStatistics) -> [SignalSize; 2] {
    [
        SignalSize {
            mean: values.deflection_mean,
            rms: values.deflection_rms,
        },
        SignalSize {
            mean: values.force_mean,
            rms: values.force_std,
        },
    ]
}

/// The statistic with the largest relative standard error, for a motion that does not repeat. `outputs` are
/// the sizes of the structure's outputs, by the names of their signals.
pub fn loosest(
    outcome: &NvhOutcome,
    spectra: &[Spectrum],
    orders: &[SignalOrders],
    outputs: &[(&str, SignalSize)],
) -> LeastPrecise {
    let mut search = ErrorSearch(LeastPrecise {
        name: "deflection_rms".to_owned(),
        error: 0.0,
    });
    let Some(errors) = &outcome.stderr else {
        search.0.error = f64::INFINITY;
        return search.0;
    };
    let values = &outcome.values;
    search.take_mesh(values, errors);
    search.take_power(values, errors);
    search.take_outputs(values, errors);
    let [deflection, force] = mesh_sizes(values);
    let sine = |signal: &str| match signal {
        "deflection" => deflection.sine(),
        "force" => force.sine(),
        _ => {
            (outputs.iter().find(|(name, _)| *name == signal)).map_or(0.0, |(_, size)| size.sine())
        }
    };
    for spectrum in spectra {
        let scale = sine(&spectrum.signal);
        let errors = spectrum.lines.iter();
        let errors = errors.map(|line| line.stderr.unwrap_or(f64::INFINITY));
        let name = format!("the spectrum of {}", spectrum.signal);
        search.take(&name, errors.fold(0.0, f64::max), scale);
    }
    for signal_orders in orders {
        let scale = sine(&signal_orders.signal);
        let name = format!("an order of {}", signal_orders.signal);
        for line in signal_orders
            .lines
            .iter()
            .filter(|line| line.amplitude > 0.0)
        {
            let across = line
                .phase_stderr
                .map_or(f64::INFINITY, |e| e * line.amplitude);
            let along = line.stderr.unwrap_or(f64::INFINITY);
            search.take(&name, along.max(across), scale);
        }
    }
    search.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::PowerOutcome;
    use crate::analysis::outcome::{OrderLine, SpectrumLine, SpectrumMethod};

    /// Statistics with an error of 1 % each, on its scale.
    fn even() -> NvhOutcome {
        NvhOutcome {
            values: NvhStatistics {
                deflection_mean: 3e-6,
                deflection_rms: 4e-6,
                deflection_kurtosis: 2.0,
                harmonics: vec![1e-6, 1e-9],
                force_mean: 0.0,
                force_std: 100.0,
                power_loss: Some(-7.0),
                power: Some(PowerOutcome {
                    error: 30.0,
                    stiffness: -10.0,
                    contact: 12.0,
                    structure: 8.0,
                    ..PowerOutcome::default()
                }),
                impact_rate: 5.0,
                impact_velocity: 6.0,
                impact_power: 7.0,
                rattle_index: 8.0,
                flight_mean: Some(2e-5),
                contact_mean: Some(3e-5),
                bearing_mean: vec![-300.0],
                bearing_rms: vec![400.0],
                torque_mean: vec![50.0],
                torque_rms: vec![0.0],
                acceleration_rms: vec![10.0],
                angular_acceleration_rms: vec![20.0],
                fractions: [0.001, 0.9, 0.099, 0.0],
                ..NvhStatistics::default()
            },
            stderr: Some(NvhStatistics {
                deflection_mean: 5e-8,
                deflection_rms: 4e-8,
                deflection_kurtosis: 0.02,
                harmonics: vec![4e-8 * SQRT_2; 2],
                suborders: vec![4e-8 * SQRT_2],
                force_mean: 1.0,
                force_std: 1.0,
                power_loss: Some(0.07),
                power: Some(PowerOutcome {
                    loads: 0.3,
                    error: 0.3,
                    stiffness: 0.3,
                    contact: 0.3,
                    structure: 0.3,
                    friction: 0.3,
                    stored: 0.3,
                }),
                impact_rate: 0.05,
                impact_velocity: 0.06,
                impact_power: 0.07,
                rattle_index: 0.08,
                flight_mean: Some(2e-7),
                contact_mean: Some(3e-7),
                bearing_mean: vec![5.0],
                bearing_rms: vec![4.0],
                torque_mean: vec![0.5],
                torque_rms: vec![0.0],
                acceleration_rms: vec![0.1],
                angular_acceleration_rms: vec![0.2],
                fractions: [0.01, 0.01, 0.01, 0.0],
                impact_velocity_quantiles: vec![1e3],
                deflection_peak_quantiles: vec![1e3],
                force_peak_quantiles: vec![1e9],
                ..NvhStatistics::default()
            }),
            ..NvhOutcome::default()
        }
    }

    fn near(found: &LeastPrecise, name: &str, error: f64) -> bool {
        found.name == name && (found.error / error - 1.0).abs() < 1e-12
    }

    /// Doubles one error after the other. The search finds each of them, with the name of its column.
    #[test]
    fn every_error_counts_on_its_scale() {
        let all = loosest(&even(), &[], &[], &[]).error;
        assert!((all - 0.01).abs() < 1e-15, "{all}");
        type Pick = fn(&mut NvhStatistics) -> &mut f64;
        let errors: [(&str, Pick); 27] = [
            ("deflection_mean", |e| &mut e.deflection_mean),
            ("deflection_rms", |e| &mut e.deflection_rms),
            ("deflection_kurtosis", |e| &mut e.deflection_kurtosis),
            ("harmonics", |e| &mut e.harmonics[1]),
            ("suborders", |e| &mut e.suborders[0]),
            ("force_mean", |e| &mut e.force_mean),
            ("force_std", |e| &mut e.force_std),
            ("power_loss", |e| e.power_loss.as_mut().unwrap()),
            ("power_in_loads", |e| &mut e.power.as_mut().unwrap().loads),
            ("power_in_error", |e| &mut e.power.as_mut().unwrap().error),
            ("power_in_stiffness", |e| {
                &mut e.power.as_mut().unwrap().stiffness
            }),
            ("power_out_contact", |e| {
                &mut e.power.as_mut().unwrap().contact
            }),
            ("power_out_structure", |e| {
                &mut e.power.as_mut().unwrap().structure
            }),
            ("power_out_friction", |e| {
                &mut e.power.as_mut().unwrap().friction
            }),
            ("power_stored", |e| &mut e.power.as_mut().unwrap().stored),
            ("impact_rate", |e| &mut e.impact_rate),
            ("impact_velocity", |e| &mut e.impact_velocity),
            ("impact_power", |e| &mut e.impact_power),
            ("rattle_index", |e| &mut e.rattle_index),
            ("flight_mean", |e| e.flight_mean.as_mut().unwrap()),
            ("contact_mean", |e| e.contact_mean.as_mut().unwrap()),
            ("bearing_mean", |e| &mut e.bearing_mean[0]),
            ("bearing_rms", |e| &mut e.bearing_rms[0]),
            ("torque_mean", |e| &mut e.torque_mean[0]),
            ("acceleration_rms", |e| &mut e.acceleration_rms[0]),
            ("angular_acceleration_rms", |e| {
                &mut e.angular_acceleration_rms[0]
            }),
            ("fraction_coast", |e| &mut e.fractions[2]),
        ];
        for (name, pick) in errors {
            let mut found = even();
            *pick(found.stderr.as_mut().unwrap()) *= 2.0;
            let loosest = loosest(&found, &[], &[], &[]);
            assert!(near(&loosest, name, 0.02), "{name}: {loosest:?}");
        }
    }

    #[test]
    fn what_there_is_none_of_needs_no_error() {
        let mut found = even();
        found.values.impact_velocity = 0.0;
        found.values.flight_mean = None;
        found.values.power_loss = None;
        let errors = found.stderr.as_mut().unwrap();
        errors.impact_velocity = f64::INFINITY;
        errors.flight_mean = Some(f64::INFINITY);
        errors.power_loss = Some(f64::INFINITY);
        assert!(loosest(&found, &[], &[], &[]).error < 0.011);
        // A quantity with a value needs an error; a record that is too short does not give one.
        found.values.power_loss = Some(1.0);
        let unknown = loosest(&found, &[], &[], &[]);
        assert_eq!(unknown.name, "power_loss");
        assert!(unknown.error.is_infinite());
        assert!(unknown.to_string().contains("no standard error yet"));
        found.stderr = None;
        assert!(loosest(&found, &[], &[], &[]).error.is_infinite());
    }

    #[test]
    fn lines_count_against_a_sine_of_their_signal() {
        let line = |amplitude: f64, stderr: Option<f64>| SpectrumLine {
            frequency: 1.0,
            order: 1.0,
            amplitude,
            stderr,
        };
        let spectrum = |signal: &str, lines: Vec<SpectrumLine>| Spectrum {
            signal: signal.to_owned(),
            unit: String::new(),
            method: SpectrumMethod::Welch,
            bandwidth: None,
            lines,
        };
        let found = even();
        let look = |spectra: &[Spectrum]| {
            let bearing = SignalSize {
                mean: 1e3,
                rms: 10.0,
            };
            loosest(&found, spectra, &[], &[("bearing a", bearing)])
        };
        let force = spectrum("force", vec![line(1.0, Some(3.0 * SQRT_2))]);
        assert!(near(&look(&[force]), "the spectrum of force", 0.03));
        let own = spectrum("bearing a", vec![line(1.0, Some(0.5 * SQRT_2))]);
        assert!(near(&look(&[own]), "the spectrum of bearing a", 0.05));
        let unknown = spectrum("deflection", vec![line(1.0, None)]);
        assert!(look(&[unknown]).error.is_infinite());

        let order = |amplitude: f64, stderr: Option<f64>, phase_stderr: Option<f64>| SignalOrders {
            signal: "force".to_owned(),
            unit: "N".to_owned(),
            lines: vec![OrderLine {
                reference: "mesh".to_owned(),
                multiple: 1,
                order: 1.0,
                frequency: 1.0,
                amplitude,
                stderr,
                phase: None,
                phase_stderr,
            }],
        };
        let look = |order: SignalOrders| loosest(&found, &[], &[order], &[]);
        let along = look(order(10.0, Some(2.0 * SQRT_2), Some(0.0)));
        assert!(near(&along, "an order of force", 0.02), "{along:?}");
        let across = look(order(10.0, Some(0.0), Some(0.4 * SQRT_2)));
        assert!(near(&across, "an order of force", 0.04), "{across:?}");
        assert!(look(order(10.0, None, None)).error.is_infinite());
        assert!(look(order(0.0, None, None)).error < 0.011);
    }

    /// The axial force on a spur gear's bearing is round-off: its errors do not prolong the measurement.
    #[test]
    fn round_off_about_a_mean_is_no_motion() {
        let still = SignalSize {
            mean: 1e3,
            rms: 1e-13,
        };
        let mut found = even();
        found.values.bearing_mean = vec![still.mean];
        found.values.bearing_rms = vec![still.rms];
        let errors = found.stderr.as_mut().unwrap();
        errors.bearing_mean = vec![1e-13];
        errors.bearing_rms = vec![1e-13];
        assert!(loosest(&found, &[], &[], &[]).error < 0.011);
    }
}
