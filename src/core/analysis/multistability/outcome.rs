//! What is known about the attractors of an operating point? The result files hold these numbers.

use crate::analysis::outcome::{Class, Status};
use crate::numerics::proportion::wilson_interval;
use serde::{Deserialize, Serialize};

/// Fraction of the probes of a point that end on one attractor, with its 95 % interval.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BasinShare {
    /// The fraction \[1\].
    pub share: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
}

impl BasinShare {
    /// The share of `count` probes among `all`, with Wilson's interval.
    pub fn of(count: usize, all: usize) -> Self {
        let [low, high] = wilson_interval(count, all);
        Self {
            share: count as f64 / all.max(1) as f64,
            low,
            high,
        }
    }
}

/// Result of one initial condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeOutcome {
    /// Number from 0; probe 0 is the initial state of the point.
    pub probe_id: u32,
    /// Distance from the initial state of the point in the energy norm, in units of the half gap; the energy
    /// is its square.
    pub amplitude: f64,
    /// The number of the attractor, in the order of discovery; `None` if the probe settled on none.
    pub attractor: Option<u32>,
    /// How the work ended.
    pub status: Status,
    /// Reason for this status and this class.
    pub reason: String,
    /// Kind of motion.
    pub class: Option<Class>,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Standard error of the exponent \[1/cycle\].
    pub lambda_stderr: Option<f64>,
    /// Root mean square of the deflection about its mean \[m\].
    pub deflection_rms: Option<f64>,
    /// Largest |mesh force| \[N\].
    pub force_peak: Option<f64>,
    /// Contact-state changes per measured cycle.
    pub events_per_cycle: Option<f64>,
    /// Mesh cycles integrated, transient included.
    pub cycles: u64,
    /// Share of the probes that end on this attractor, or with this status if they settle on none.
    pub basin: BasinShare,
}

/// Result of one cell of a slice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellOutcome {
    /// Column, from 0 at the smallest `place[0]`.
    pub column: u32,
    /// Row, from 0 at the smallest `place[1]`.
    pub row: u32,
    /// The cell's centre relative to the initial state of the point \[m; m/s for the second of a phase
    /// plane\].
    pub place: [f64; 2],
    /// The attractor; `None` if the cell settled on none.
    pub attractor: Option<u32>,
    /// How the work ended.
    pub status: Status,
    /// Kind of motion.
    pub class: Option<Class>,
    /// Whether the motion was investigated like a probe, because it came near no known orbit.
    pub in_full: bool,
    /// Mesh cycles integrated.
    pub cycles: u64,
}

/// One attractor. Its statistics are those of the first probe or cell on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AttractorOutcome {
    /// Kind of motion.
    pub class: Class,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Standard error of the exponent \[1/cycle\].
    pub lambda_stderr: Option<f64>,
    /// Lower end of the 95 % interval of the mean life of chaos \[cycles\], from all probes of the point
    /// together; `None` for other motions, or if no probe was chaotic.
    pub chaos_lifetime_low: Option<f64>,
    /// Root mean square of the deflection about its mean \[m\].
    pub deflection_rms: Option<f64>,
    /// Largest |mesh force| \[N\].
    pub force_peak: Option<f64>,
    /// Contact-state changes per measured cycle.
    pub events_per_cycle: Option<f64>,
    /// Number of probes that settled on the attractor.
    pub probes: u32,
    /// Share of these probes among all.
    pub basin: BasinShare,
    /// Number of cells of the slice that settled on the attractor; `None` without a slice.
    pub cells: Option<u32>,
    /// Strobe states of a periodic motion, projected on the slice \[m; m/s for the second of a phase plane\].
    /// Empty for other motions and without a slice.
    pub strobe: Vec<[f64; 2]>,
}

/// Results of the probes of a point and the cells of its slice.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultistabilityOutcome {
    /// The attractors, by number.
    pub attractors: Vec<AttractorOutcome>,
    /// The probes, in order.
    pub probes: Vec<ProbeOutcome>,
    /// The cells of the slice, row by row; empty without a slice.
    pub cells: Vec<CellOutcome>,
}

impl MultistabilityOutcome {
    /// Mesh cycles integrated by all probes and cells.
    pub fn cycles(&self) -> u64 {
        let probes: u64 = self.probes.iter().map(|probe| probe.cycles).sum();
        let cells: u64 = self.cells.iter().map(|cell| cell.cycles).sum();
        probes + cells
    }

    /// Sets the basin shares. Every attractor gets its share; every probe gets that of its attractor or
    /// status.
    pub(super) fn share_out(&mut self) {
        let all = self.probes.len();
        for (id, attractor) in (0..).zip(&mut self.attractors) {
            let on = |found: Option<u32>| found == Some(id);
            let probes = self.probes.iter().filter(|probe| on(probe.attractor));
            attractor.probes = probes.count() as u32;
            attractor.basin = BasinShare::of(attractor.probes as usize, all);
            if !self.cells.is_empty() {
                let cells = self.cells.iter().filter(|cell| on(cell.attractor));
                attractor.cells = Some(cells.count() as u32);
            }
        }
        let lost: Vec<Status> = self
            .probes
            .iter()
            .filter(|probe| probe.attractor.is_none())
            .map(|probe| probe.status.clone())
            .collect();
        for probe in &mut self.probes {
            // Probes on one attractor may differ in status, so the share is that of the attractor.
            let settled = probe.attractor.map(|id| &self.attractors[id as usize]);
            probe.basin = match settled {
                Some(attractor) => attractor.basin,
                None => {
                    let same_status = lost.iter().filter(|status| **status == probe.status);
                    BasinShare::of(same_status.count(), all)
                }
            };
        }
    }
}
