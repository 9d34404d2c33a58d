//! Why can a model not be built?

use crate::numerics::decoupling::DecouplingError;

/// Models at neighbouring values of a parameter differ in more than their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the {what} of the model change with it")]
pub struct ShapeChange {
    /// The part that differs.
    pub what: &'static str,
}

/// Why a model cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The coupled modes cannot be decoupled.
    #[error("{0}")]
    Coupling(#[from] DecouplingError),
    /// A torque ripple or an imposed motion on a shaft whose participation or number of teeth is unknown.
    #[error(
        "a torque or a motion acts on the {shaft} shaft, but the structure has no torque participation for it; add `torque_{shaft}` to the modal file"
    )]
    UnknownShaft {
        /// `pinion` or `wheel`.
        shaft: &'static str,
    },
    /// A motion is imposed on a shaft, but the drive cannot rotate freely.
    #[error(
        "a motion is imposed on the {shaft} shaft, but no rotation of the drive leaves all contacts alone; free the drive \
         from what holds it, or remove excitation.imposed_motion"
    )]
    DoesNotTurn {
        /// `pinion` or `wheel`.
        shaft: &'static str,
    },
    /// Several springs of a flank would share a residual flexibility, but they are not on one line, or their
    /// order of contact changes.
    #[error(
        "springs of pairs of teeth on slices of the face cannot share the residual flexibility of the \
         omitted modes ({flexibility:.2e} m/N), because each slice has a different line of action; set \
         mesh.slices = 1, model.mta = false, or retain all modes"
    )]
    SpringsApart {
        /// Residual flexibility \[m/N\].
        flexibility: f64,
    },
    /// A contact should copy the law of a flank of the first mesh. This law has several springs, or errors of
    /// single gears, which only the first mesh can have.
    #[error(
        "`{contact}` cannot have the law of the first mesh: pairs of teeth as springs and errors of single gears are \
         only possible in the first mesh; give the stiffness of the mesh (mesh.stiffness = \"piecewise\"), without excitation.gear_error"
    )]
    NoCopy {
        /// Name of the contact.
        contact: String,
    },
    /// Two contacts that face each other on one line overlap: flanks that are thicker than the backlash, or
    /// stops.
    #[error(
        "contacts that face each other (the flanks of a tooth, or stops) overlap by up to {lack:.3e} m, so \
         both would touch at once; remove more material from the flanks, or raise mesh.half_gap or the gap \
         of the stop"
    )]
    Jammed {
        /// Size of the overlap \[m\]; \[rad\] for stops against rotation.
        lack: f64,
    },
    /// The structure has both dry friction and rigid stops.
    #[error(
        "dry friction and rigid stops exclude each other: give the stops a stiffness in place of a restitution, or \
         replace the dry friction by a slider"
    )]
    FrictionWithStops,
    /// The lines of elements of dry friction are linearly dependent.
    #[error(
        "the motion along element {element} of dry friction (counted from 1) follows from the motions along those \
         before it: combine elements along one line, and give at most one element per mode"
    )]
    FrictionsAlike {
        /// Number of the first element that depends on those before it, from 1.
        element: usize,
    },
    /// No static equilibrium under the mean load.
    #[error(transparent)]
    NoEquilibrium(#[from] NoStaticState),
    /// A quantity outside its physical range.
    #[error("{name} is {value}, but must be {accepted}")]
    OutOfRange {
        /// Name of the quantity.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// Accepted values.
        accepted: &'static str,
    },
}

/// The search found no static equilibrium.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "no static equilibrium: with {:.3} % of the friction and of the unsymmetric springs, contacts {} \
     (counted from 1, drive and coast flank first) pull or overlap by up to {excess:.1e} m; friction \
     locks them or the structure is unstable: lower the friction of the mesh and of the contacts, or \
     the cross-coupled stiffness{}",
    100.0 * friction,
    numbered(contacts),
    of_untried(*untried)
)]
pub struct NoStaticState {
    /// Indices of the contacts that pull or overlap.
    pub contacts: Vec<usize>,
    /// Largest overlap, or pull divided by stiffness \[m\].
    pub excess: f64,
    /// Fraction of the friction and of the unsymmetric springs at which there is no equilibrium. The search raises
    /// this fraction from 0 to 1.
    pub friction: f64,
    /// Number of contacts and the largest number for which all combinations are tried, if there are too many
    /// contacts to try them; otherwise `None`.
    pub untried: Option<[usize; 2]>,
}

/// The note that not all combinations of closed contacts were tried; empty for `None`.
fn of_untried(contacts: Option<[usize; 2]>) -> String {
    contacts.map_or_else(String::new, |[count, most]| {
        format!(
            "; another equilibrium may exist, because only models of at most {most} contacts (here {count}) try \
             every combination of closed contacts"
        )
    })
}

/// Numbers of contacts, from 1.
fn numbered(contacts: &[usize]) -> String {
    let numbers: Vec<String> = contacts.iter().map(|i| (i + 1).to_string()).collect();
    numbers.join(", ")
}

/// Checks that a value is finite, and that `ok` is true: the value is within its range.
pub(super) fn check_in_range(
    name: &'static str,
    value: f64,
    ok: bool,
    accepted: &'static str,
) -> Result<(), ModelError> {
    if ok && value.is_finite() {
        Ok(())
    } else {
        Err(ModelError::OutOfRange {
            name,
            value,
            accepted,
        })
    }
}
