//! The gear mesh in the content hash.

use super::JobHash;
use crate::manifest::spec::{
    CourseSpec, DampingSpec, MeshSpec, StiffnessSpec, TableSpec, TwoLevels,
};

impl JobHash {
    pub(super) fn mesh(&mut self, mesh: &MeshSpec) {
        let MeshSpec {
            half_gap,
            stiffness,
            damping,
            friction,
            misalignment,
        } = mesh;
        self.number(*half_gap);
        match stiffness {
            StiffnessSpec::Constant(value) => {
                self.text("constant");
                self.number(*value);
            }
            StiffnessSpec::Piecewise(values) => {
                self.text("piecewise");
                self.numbers(values);
            }
            StiffnessSpec::Continuous(TwoLevels {
                double_pair,
                single_pair,
                transition,
            }) => {
                self.text("continuous");
                self.numbers(&[*double_pair, *single_pair, *transition]);
            }
            StiffnessSpec::Table(table) => {
                let TableSpec {
                    gears,
                    course,
                    shaft_tilt,
                } = &**table;
                self.text("table");
                self.gears(gears);
                match course {
                    CourseSpec::Segments(count) => self.integer(u64::from(*count)),
                    CourseSpec::Continuous => self.text("continuous"),
                }
                self.flag(*shaft_tilt);
                self.number(*misalignment);
            }
        }
        match damping {
            DampingSpec::Ratio(value) => {
                self.text("ratio");
                self.number(*value);
            }
            DampingSpec::Coefficient(value) => {
                self.text("coefficient");
                self.number(*value);
            }
        }
        self.number(*friction);
    }
}
