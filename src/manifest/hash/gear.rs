//! The drawing of a gear pair in the content hash.

use super::JobHash;
use crate::gear::{BasicRack, GearPair, Material, Relief, ToothForm};

impl JobHash {
    pub(super) fn gears(&mut self, gears: &GearPair) {
        let GearPair {
            teeth,
            module,
            pressure_angle,
            face_width,
            body_length,
            rated_torque,
            form,
        } = gears;
        for &count in teeth {
            self.integer(u64::from(count));
        }
        for value in [module, pressure_angle, face_width, rated_torque] {
            self.number(*value);
        }
        self.numbers(body_length);
        // Named rather than flagged: drawings that say no more keep the hash they had.
        if *form != ToothForm::default() {
            self.text("form");
            self.tooth_form(form);
        }
    }

    fn tooth_form(&mut self, form: &ToothForm) {
        let ToothForm {
            profile_shift,
            rack,
            thinning,
            centre_distance,
            tip_diameter,
            tip_relief,
            root_relief,
            bore,
            material,
        } = form;
        let BasicRack {
            addendum,
            dedendum,
            tip_radius,
        } = rack;
        self.numbers(profile_shift);
        self.numbers(&[*addendum, *dedendum, *tip_radius]);
        self.numbers(thinning);
        for value in [centre_distance]
            .into_iter()
            .chain(tip_diameter)
            .chain(bore)
        {
            self.optional(value.as_ref(), |hash, value| hash.number(*value));
        }
        for Relief { amount, length } in tip_relief.iter().chain(root_relief) {
            self.numbers(&[*amount, *length]);
        }
        for Material {
            young_modulus,
            poisson_ratio,
        } in material
        {
            self.numbers(&[*young_modulus, *poisson_ratio]);
        }
    }
}
