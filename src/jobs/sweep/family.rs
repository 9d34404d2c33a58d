//! The drives of a job as functions of parameters: models between the points of a grid, and their derivatives.

use super::parts::Prepared;
use crate::analysis::continuation::drive::ParametricDrive;
use crate::analysis::continuation::map::MapParameters;
use crate::manifest::{Parameter, PointResolver, PointSpec};
use crate::model::{Basis, Model, ModelDerivative, ShapeChange};

/// Steps of difference quotients of models, relative to the parameter's size, in the order of attempts. A smaller step
/// is tried if the model's shape changes within a larger one.
const RELATIVE_STEPS: [f64; 3] = [1e-3, 1e-4, 1e-5];

/// Central differences of the sixth order: weights at 1, 2 and 3 steps, in 60ths.
const CENTRAL: [f64; 3] = [45.0, -9.0, 1.0];

/// One-sided differences of the sixth order, in 60ths, for a parameter that may change in one direction only.
const ONE_SIDED: [f64; 7] = [-147.0, 360.0, -450.0, 400.0, -225.0, 72.0, -10.0];

/// Assumed size of a parameter with the value zero, divided by its natural scale: the half gap for lengths,
/// otherwise one SI unit.
const SIZE_OF_ZERO: f64 = 1e-2;

/// The drives of a point for varied parameters.
#[derive(Debug)]
pub struct PointFamily<'a> {
    /// The point.
    pub point: PointSpec,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Keys whose values at the point differ from the manifest, with these values.
    held: Vec<(Parameter, f64)>,
    resolver: &'a PointResolver,
    parts: &'a Prepared,
}

impl<'a> PointFamily<'a> {
    /// The family of a point.
    pub fn new(
        point: PointSpec,
        parameters: Vec<Parameter>,
        resolver: &'a PointResolver,
        parts: &'a Prepared,
    ) -> Self {
        Self {
            point,
            parameters,
            held: Vec::new(),
            resolver,
            parts,
        }
    }

    /// This family, for a point whose keys `held` have other values than in the manifest.
    pub fn holding(mut self, held: &[(Parameter, f64)]) -> Self {
        self.held = held.to_vec();
        self
    }

    /// The value of a parameter at the point.
    fn value_at_point(&self, parameter: &Parameter) -> Option<f64> {
        let held = self
            .held
            .iter()
            .find(|(held_parameter, _)| held_parameter == parameter);
        match held {
            Some((_, value)) => Some(*value),
            None => self.resolver.value(&self.point, parameter),
        }
    }

    /// The values of the parameters at the point; 0 for a missing second one.
    pub fn values(&self) -> MapParameters {
        let value = |i: usize| self.parameters.get(i).and_then(|p| self.value_at_point(p));
        [0, 1].map(|i| value(i).unwrap_or(0.0))
    }

    /// The point with these values of the parameters.
    ///
    /// # Errors
    /// A sentence if the values do not describe a drive.
    pub fn at(&self, at: MapParameters) -> Result<PointSpec, String> {
        let held = self
            .held
            .iter()
            .map(|(parameter, value)| (parameter, *value));
        let held = held.filter(|(parameter, _)| !self.parameters.contains(parameter));
        let values: Vec<(&Parameter, f64)> = held.chain(self.parameters.iter().zip(at)).collect();
        let mut changed = self.resolver.changed(&self.point, &values)?;
        // Orbits at all values of the parameters use one length scale.
        if let Some(length) = self.point.mesh.length {
            changed.mesh = changed.mesh.measured_by(length);
        }
        Ok(changed)
    }

    /// The size of a parameter in SI, to which small changes are related.
    pub(super) fn size(&self, at: MapParameters, axis: usize) -> f64 {
        let natural = match self.parameters[axis].unit() {
            "m" => self.point.mesh.scale(),
            _ => 1.0,
        };
        match at[axis] {
            0.0 => SIZE_OF_ZERO * natural,
            value => value.abs(),
        }
    }

    /// The weighted sum of models. `offsets` has the steps from `at` to each model, and its weight. If a model cannot
    /// be built, the outer error says why. The inner error is a model of another shape than `model`, the model at `at`.
    /// At a change of shape, all models around `at` may have one shape, but no derivative exists.
    fn difference(
        &self,
        model: &Model,
        (at, axis): (MapParameters, usize),
        step: f64,
        offsets: &[(f64, f64)],
        through: &Basis,
    ) -> Result<Result<ModelDerivative, ShapeChange>, String> {
        let models: Vec<(f64, Model)> = (offsets.iter())
            .map(|&(steps, weight)| {
                let mut there = at;
                there[axis] += steps * step;
                Ok((weight / (60.0 * step), self.model(there)?))
            })
            .collect::<Result<_, String>>()?;
        let models = models.iter().map(|(weight, model)| (*weight, model));
        let models: Vec<(f64, &Model)> = std::iter::once((0.0, model)).chain(models).collect();
        Ok(Model::combined(&models, through))
    }
}

impl ParametricDrive for PointFamily<'_> {
    fn model(&self, at: MapParameters) -> Result<Model, String> {
        let point = self.at(at)?;
        self.parts.model(&point).map_err(|error| error.to_string())
    }

    /// Difference quotients of models, of the sixth order: every segment of a model depends smoothly on its
    /// parameters. If a parameter may change in one direction only, the quotient is one-sided.
    fn derivative(
        &self,
        at: MapParameters,
        axis: usize,
        through: &Basis,
    ) -> Result<ModelDerivative, String> {
        let central: Vec<(f64, f64)> = (1..)
            .zip(CENTRAL)
            .flat_map(|(i, w)| [(f64::from(i), w), (-f64::from(i), -w)])
            .collect();
        let sided = |side: f64| {
            (0..)
                .zip(ONE_SIDED)
                .map(move |(i, w)| (side * f64::from(i), side * w))
                .collect::<Vec<_>>()
        };
        let name = self.parameters[axis].name();
        let model = self.model(at)?;
        let excluded = [
            (!model.stops.is_empty(), "rigid stops"),
            (!model.sliders.is_empty(), "dry sliders"),
            (!model.frictions.is_empty(), "dry friction"),
        ];
        if let Some((_, what)) = excluded.iter().find(|(present, _)| *present) {
            return Err(format!(
                "no derivative by `{name}`: exact derivatives exclude {what}"
            ));
        }
        let mut fault = None;
        for offsets in [central, sided(1.0), sided(-1.0)] {
            for step in RELATIVE_STEPS {
                let step = step * self.size(at, axis);
                match self.difference(&model, (at, axis), step, &offsets, through) {
                    Ok(Ok(found)) => return Ok(found),
                    Ok(Err(change)) => {
                        fault.get_or_insert(change.to_string());
                    }
                    Err(reason) => {
                        fault.get_or_insert(reason);
                        break;
                    }
                }
            }
        }
        Err(format!(
            "no derivative by `{name}`: {}",
            fault.unwrap_or_default()
        ))
    }

    fn event_limit(&self) -> u32 {
        self.point.run.event_limit
    }
}
