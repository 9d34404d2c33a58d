//! The kernel that integrates the first point of a manifest, and the reason for it, for `atlas check`.

use crate::manifest::{Job, PointSpec};
use crate::propagate::{ClosedModes, KernelChoice, KernelSetting, Why};
use crate::sweep::{PointKernel, Prepared};

/// The kernel of a grid's first point.
pub struct FirstKernel {
    /// Name of the chosen kernel; `None` if the model cannot be built.
    pub taken: Option<&'static str>,
    /// The reason for the kernel if it depends on the drive, or the error of the model.
    pub why: Option<String>,
    setting: KernelSetting,
    /// Whether all points share one model, so that all points get the same kernel.
    alone: bool,
}

impl FirstKernel {
    /// The kernel of a job's first point.
    pub fn of(job: &Job, first: &PointSpec, parts: &Prepared) -> Self {
        let setting = first.run.kernel;
        let found = match setting {
            KernelSetting::Auto => parts.model(first).and_then(|model| {
                let point_kernel = PointKernel::of(first, &model, parts)?;
                Ok((
                    point_kernel.choice.name(),
                    point_kernel.why.map(|why| why.to_string()),
                ))
            }),
            KernelSetting::Named(kernel @ KernelChoice::ClosedModes) => {
                parts.model(first).map(|model| {
                    let modes = model.modes();
                    let why = match ClosedModes::suits(&model) {
                        Ok(size) => Why::of_tables(modes, size).to_string(),
                        Err(error) => format!("it does not accept this drive: {error}"),
                    };
                    (kernel.name(), Some(why))
                })
            }
            KernelSetting::Named(kernel) => Ok((kernel.name(), None)),
        };
        let (taken, why) = match found {
            Ok((taken, why)) => (Some(taken), why),
            Err(error) => (None, Some(error.to_string())),
        };
        Self {
            taken,
            why,
            setting,
            alone: job.points.variants().len() == 1,
        }
    }

    /// `closed_modes (auto: 12 modes, …)`; `None` if the choice does not depend on the drive.
    pub fn line(&self) -> Option<String> {
        let why = self.why.as_ref()?;
        let auto = match self.setting {
            KernelSetting::Auto => "auto: ",
            KernelSetting::Named(_) => "",
        };
        let which = if self.alone { "" } else { "; the first point" };
        Some(format!(
            "{} ({auto}{why}{which})",
            self.taken.unwrap_or("none")
        ))
    }
}

/// The setting of the kernel in `[run]`, in words.
pub fn setting(setting: &KernelSetting) -> String {
    let name = setting.name();
    match setting {
        KernelSetting::Auto => format!("kernel {name}"),
        KernelSetting::Named(KernelChoice::Volterra | KernelChoice::ClosedModes) => {
            format!("kernel {name} to round-off")
        }
        KernelSetting::Named(KernelChoice::Stepping { steps }) => {
            format!("kernel {name}, {steps} steps per cycle")
        }
    }
}
