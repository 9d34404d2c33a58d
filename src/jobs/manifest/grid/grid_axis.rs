//! An axis of the grid in the text, and the insertion of its values into the tree.

use super::values::Spans;
use crate::manifest::axis::{AxisKey, AxisValues};
use crate::manifest::diagnostic::Span;
use crate::manifest::spec::Axis;
use crate::manifest::tree::{Node, Value};
use crate::units::Dimension;

/// An axis and the places of its values.
#[derive(Debug)]
pub(in crate::manifest) struct GridAxis {
    pub axis: Axis,
    /// Place of its name.
    pub key_span: Span,
    pub(super) dimension: Dimension,
    pub(super) spans: Spans,
}

impl GridAxis {
    pub(super) fn new(
        key: AxisKey,
        key_span: Span,
        dimension: Dimension,
        (values, spans): (AxisValues, Spans),
    ) -> Self {
        let unit = dimension.unit().to_owned();
        Self {
            axis: Axis { key, unit, values },
            key_span,
            dimension,
            spans,
        }
    }

    /// An axis with one ratio for all points. The text does not give this ratio; messages point to `span`.
    pub(super) fn single(key: AxisKey, value: f64, span: Span) -> Self {
        let values = (AxisValues::each(vec![value]), Spans::Whole(span));
        Self::new(key, span, Dimension::Ratio, values)
    }

    /// Dimension of its values.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// Whether the axis varies a model key; otherwise it is load, torque or speed.
    pub fn is_model_key(&self) -> bool {
        self.axis.key.is_model_key()
    }

    /// A value as a node for the tree.
    pub fn sample(&self, value: f64) -> Node {
        Node {
            span: self.key_span,
            value: Value::Sample(value, self.dimension),
        }
    }

    /// The i-th value as a node for the tree.
    pub fn node(&self, i: usize) -> Node {
        Node {
            span: match &self.spans {
                Spans::Each(spans) => spans[i],
                Spans::Whole(span) => *span,
            },
            value: Value::Sample(self.axis.values.get(i), self.dimension),
        }
    }
}
