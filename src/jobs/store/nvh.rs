//! The NVH columns of `points.parquet`: every statistic and its standard error.

use super::PointRow;
use super::table::{Column, columns};
use crate::analysis::NvhOutcome;
use crate::model::Quantity;

/// Description of extremes, which have no standard error.
const SEEN: &str = "an extreme over nvh_cycles mesh cycles; if the motion does not repeat, it grows with their number";

/// Description of quantiles of peaks.
const PEAKS: &str = ", quantiles at 99 and 99.9 % of the mesh cycles; if the motion repeats, of the cycles of its period";

/// The order of bearing forces.
const ORDER: &str = "ordered by shaft (pinion, wheel), bearing (first, second) and direction (x, y, axial) \
                     with a spring or a damper, or as in the modal file";

/// The order of contacts.
const CONTACTS: &str = "ordered by mesh (the first mesh, then the meshes of [train]) with its drive and its coast \
                        flank, then stages and dry hysteresis of couplings, then stops, or the further \
                        contacts of a modal file";

/// The order of torques.
const TORQUES: &str = "in the shaft of the pinion and of the wheel, next to the free end; in a train, in every part \
                       of flexible shafts between gears, couplings, motor and load, then in couplings";

impl PointRow {
    fn nvh(&self) -> Option<&NvhOutcome> {
        self.outcome.nvh.as_ref()
    }
}

/// Columns as [`columns`] makes them, each with a column for the standard error, which is null if the motion repeats or
/// there are too few samples. Columns with `@alone` have no standard error. An empty list means that the statistic does
/// not exist, and becomes null.
macro_rules! statistics {
    ($found:ident; $($(@$alone:ident)? $type:ident $name:expr, $unit:expr, $value:expr, $text:expr;)*) => {{
        let mut columns = Vec::new();
        $(columns.extend(statistics!($(@$alone)? $found $type $name, $unit, $value, $text));)*
        columns
    }};
    (@alone $found:ident $type:ident $name:expr, $unit:expr, $value:expr, $text:expr) => {
        columns![row: PointRow; $type $name, $unit, { let $found = row.nvh()?; $value }, $text;]
    };
    (@value list $list:expr) => { Some($list.as_slice()).filter(|list| !list.is_empty()) };
    (@value $type:ident $value:expr) => { $value };
    (@error list $list:expr) => {
        statistics!(@value list $list).filter(|list| !list.iter().any(|error| error.is_infinite()))
    };
    (@error $type:ident $error:expr) => {
        Option::<$type>::from($error).filter(|error| !error.is_infinite())
    };
    ($found:ident $type:ident $name:expr, $unit:expr, $value:expr, $text:expr) => {
        columns![row: PointRow;
            $type $name, $unit, { let $found = &row.nvh()?.values; statistics!(@value $type $value) }, $text;
            $type &format!("{}_stderr", $name), $unit,
            { let $found = row.nvh()?.stderr.as_ref()?; statistics!(@error $type $value) },
            &format!("Standard error of {}; null if the motion repeats and the value is exact", $name);
        ]
    };
}

/// The objects for which a list has one element each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListElement {
    /// The outputs of the structure with this quantity.
    Output(Quantity),
    /// The contacts.
    Contacts,
}

/// The objects for which the lists of a column have one element each; `None` if they have no names. A column
/// of standard errors has the objects of its statistic.
pub(super) fn listed(column: &str) -> Option<ListElement> {
    Some(match column.trim_end_matches("_stderr") {
        "bearing_mean" | "bearing_rms" => ListElement::Output(Quantity::BearingForce),
        "torque_mean" | "torque_rms" => ListElement::Output(Quantity::Torque),
        "acceleration_rms" => ListElement::Output(Quantity::Acceleration),
        "mesh_deflection_rms" => ListElement::Output(Quantity::MeshDeflection),
        "mesh_force_rms" => ListElement::Output(Quantity::MeshForce),
        "angular_acceleration_rms" => ListElement::Output(Quantity::AngularAcceleration),
        name if CONTACT_LISTS.contains(&name) => ListElement::Contacts,
        _ => return None,
    })
}

/// The columns with one element per contact.
const CONTACT_LISTS: [&str; 5] = [
    "contact_force",
    "contact_fraction",
    "contact_impact_rate",
    "contact_rattle_index",
    "contact_loss",
];

/// The columns, in file order.
pub(super) fn nvh_columns() -> Vec<Column<PointRow>> {
    statistics![found;
        f64 "fraction_drive", "1", found.fractions[0], "Fraction of time in contact on the drive flank alone";
        f64 "fraction_free", "1", found.fractions[1], "Fraction of time out of contact";
        f64 "fraction_coast", "1", found.fractions[2], "Fraction of time in contact on the coast flank alone";
        f64 "fraction_both", "1", found.fractions[3], "Fraction of time in contact on both flanks, in a tight mesh";
        f64 "deflection_mean", "m", found.deflection_mean, "Mean mesh deflection";
        f64 "deflection_rms", "m", found.deflection_rms, "Root mean square of the deflection about its mean";
        @alone f64 "deflection_pp", "m", found.deflection_pp, &format!("Largest minus smallest deflection; {SEEN}");
        @alone f64 "deflection_peak", "m", found.deflection_peak, &format!("Largest |deflection - mean|; {SEEN}");
        list "deflection_peak_quantiles", "m", found.deflection_peak_quantiles,
            &format!("Largest |deflection - mean| within a mesh cycle{PEAKS}");
        @alone f64 "deflection_crest", "1", found.deflection_crest,
            &format!("Largest |deflection - mean| divided by deflection_rms; {SEEN}");
        f64 "deflection_kurtosis", "1", found.deflection_kurtosis,
            "Fourth central moment divided by the squared variance";
        list "harmonics", "m", found.harmonics, "Amplitude of the deflection at mesh orders 1, 2, ...";
        list "suborders", "m", found.suborders,
            "Amplitude of the deflection at mesh orders 1/4, 1/3, 1/2, 2/3, 3/4: exact if the motion \
             repeats; otherwise the root mean square over windows of 24 mesh cycles, which includes noise \
             within 1/24 order";
        f64 "force_mean", "N", found.force_mean, "Mean mesh force";
        f64 "force_std", "N", found.force_std, "Standard deviation of the mesh force";
        @alone f64 "force_peak", "N", found.force_peak, &format!("Largest |mesh force|; {SEEN}");
        list "force_peak_quantiles", "N", found.force_peak_quantiles,
            &format!("Largest |mesh force| within a mesh cycle{PEAKS}");
        list "contact_force", "N", found.contact_force,
            &format!("Mean force that presses each contact together, {CONTACTS}. In N m for stages and hysteresis elements of couplings. The \
                      mean torque on a gear is the difference of the forces on its two flanks, multiplied by the base radius");
        list "contact_fraction", "1", found.contact_fraction,
            &format!("Fraction of time while each contact is closed, {CONTACTS}");
        list "contact_impact_rate", "1/s", found.contact_impact_rate,
            &format!("Number of entries into each contact per second, {CONTACTS}");
        list "contact_rattle_index", "m/s^2", found.contact_rattle_index,
            &format!("rattle_index of each contact, {CONTACTS}; in rad/s^2 for stages and hysteresis elements of couplings");
        list "contact_loss", "W", found.contact_loss,
            &format!("Mean power lost in friction on each contact at the speeds of the mean rotation, {CONTACTS}; 0 for \
                      contacts without friction or without gears, null where power_loss is");
        f64 "power_loss", "W", found.power_loss,
            "Mean power lost in friction on the flanks of the first mesh. It is the friction coefficient times |force| \
             times the sliding speed of the mean rotation; null for modal files and bevel gears";
        f64 "power_transmitted", "W", found.power_transmitted,
            "Mean power through the mesh from the pinion to the wheel: force times speed of the base \
             circles; null without a drawing of the gears";
        f64 "efficiency", "1", found.efficiency,
            "1 - power_loss/|power_transmitted|. It includes only friction of the mean rotation on the flanks of the \
             mesh. It excludes vibration (power_out_contact, power_out_structure, power_out_friction), bearings and \
             drag. Negative if more power is lost than transmitted; null without power_loss";
        @alone f64 "friction_coefficient", "1", found.friction_coefficient,
            "Friction coefficient of the flanks, as given or from the law of load and speed; null without a drawing of the gears";
        f64 "power_in_loads", "W", found.power?.loads,
            "Mean power into the vibration from mean torques, torque ripple and other loads, at the speeds \
             relative to the mean rotation. This and the next six columns are null without \
             analyses.nvh.power";
        f64 "power_in_error", "W", found.power?.error,
            "Mean power into the vibration from imposed displacement of contacts: transmission error, \
             errors of loaded flanks, steps of the load centroid";
        f64 "power_in_stiffness", "W", found.power?.stiffness,
            "Mean power into the vibration from varying stiffness of contacts";
        f64 "power_out_contact", "W", found.power?.contact,
            "Mean power out of the vibration by the dampers of all contacts, by dry sliders, by springs that open while compressed, and by impacts on rigid stops";
        f64 "power_out_structure", "W", found.power?.structure,
            "Mean power out of the vibration by damping of the structure: modal damping, dampers and drag, \
             minus the power that cross-coupled springs feed in";
        f64 "power_out_friction", "W", found.power?.friction,
            "Mean power out of the vibration by friction of all contacts, at the speeds relative to the mean \
             rotation; power_loss is the loss of the mean rotation";
        f64 "power_stored", "W", found.power?.stored,
            "Mean growth rate of stored energy over nvh_cycles: the sum of power_in columns minus the sum of power_out columns";
        f64 "impact_rate", "1/s", found.impact_rate, "Number of entries into contact per second";
        @alone u64 "impacts_drive", "1", found.impacts[0],
            "Number of entries into contact on the drive flank over nvh_cycles";
        @alone u64 "impacts_coast", "1", found.impacts[1],
            "Number of entries into contact on the coast flank over nvh_cycles";
        f64 "impact_velocity", "m/s", found.impact_velocity,
            "Mean |deflection rate| on entry into contact; 0 without impacts";
        f64 "impact_power", "W", found.impact_power,
            "Kinetic energy of impacts per second: half the effective mass of the mesh times the sum of \
             squared |deflection rate| on entry into contact, divided by time; 0 without impacts";
        f64 "rattle_index", "m/s^2", found.rattle_index,
            "Sum of |deflection rate| on entry into contact, divided by time (impact_rate times \
             impact_velocity). Multiplied by the effective mass, it is the mean force of ideally plastic \
             impacts; 0 without impacts";
        list "impact_velocity_quantiles", "m/s", found.impact_velocity_quantiles,
            "50, 90 and 99 % quantiles of |deflection rate| on entry into contact; null without impacts";
        @alone f64 "impact_velocity_max", "m/s", found.impact_velocity_max,
            &format!("Largest |deflection rate| on entry into contact; {SEEN}");
        @alone u64 "flights", "1", found.flights, "Number of flights that began and ended within nvh_cycles";
        f64 "flight_mean", "s", found.flight_mean, "Mean length of a flight between two contacts";
        f64 "flight_median", "s", found.flight_median, "Median length of a flight between two contacts";
        @alone u64 "contacts", "1", found.contacts, "Number of contacts that began and ended within nvh_cycles";
        f64 "contact_mean", "s", found.contact_mean, "Mean length of a contact between two flights";
        f64 "contact_median", "s", found.contact_median, "Median length of a contact between two flights";
        list "bearing_mean", "N", found.bearing_mean, &format!("Mean force of the shaft on each bearing, {ORDER}");
        list "bearing_rms", "N", found.bearing_rms,
            &format!("Root mean square of each bearing force about its mean, {ORDER}");
        list "torque_mean", "N m", found.torque_mean, &format!("Mean torque, {TORQUES}");
        list "torque_rms", "N m", found.torque_rms,
            &format!("Root mean square of each torque about its mean, {TORQUES}");
        list "acceleration_rms", "m/s^2", found.acceleration_rms,
            "Root mean square of the acceleration of shafts at their bearings, and of the bearing supports \
             (base), ordered by shaft, bearing and free direction (x, y, axial)";
        list "angular_acceleration_rms", "rad/s^2", found.angular_acceleration_rms,
            "Root mean square of the angular acceleration of pinion and wheel, or of every shaft and loose gear of a train";
        list "mesh_deflection_rms", "m", found.mesh_deflection_rms,
            "Root mean square of the deflection of each mesh about its mean, in the order of the meshes";
        list "mesh_force_rms", "N", found.mesh_force_rms,
            "Root mean square of the force of each mesh about its mean, in the order of the meshes";
    ]
}
