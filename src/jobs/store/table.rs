//! A column: name, unit, description and the function that reads its value from a row. One list of columns gives both
//! the schema and the record batches, so that they always agree.

use std::collections::BTreeMap;
use std::sync::Arc;

use arrow_array::builder::{
    BooleanBuilder, Float64Builder, ListBuilder, StringBuilder, UInt32Builder, UInt64Builder,
};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Metadata, Schema, SchemaRef};

type Get<R, T> = Box<dyn Fn(&R) -> Option<T> + Send + Sync>;
type GetRef<R, T> = Box<dyn for<'a> Fn(&'a R) -> Option<&'a T> + Send + Sync>;

/// Metadata key of the names of a list's elements.
pub(super) const ELEMENTS: &str = "elements";

/// How to read a column's value from a row; `None` becomes a Parquet null.
pub(super) enum Value<R> {
    U64(Get<R, u64>),
    U32(Get<R, u32>),
    F64(Get<R, f64>),
    Bool(Get<R, bool>),
    Text(GetRef<R, str>),
    List(GetRef<R, [f64]>),
}

/// One column of a result table.
pub struct Column<R> {
    /// Name in the file.
    pub name: String,
    /// SI unit; `1` if dimensionless, empty for text and truth values.
    pub unit: String,
    /// One sentence.
    pub description: String,
    /// Names of the elements of its lists; empty if they are only numbered.
    pub elements: Vec<String>,
    pub(super) value: Value<R>,
}

impl<R> Column<R> {
    pub(super) fn new(name: &str, unit: &str, description: &str, value: Value<R>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            description: description.into(),
            elements: Vec::new(),
            value,
        }
    }

    /// The Arrow field. Every column is nullable, so that all files of a table have one schema.
    fn field(&self) -> Field {
        let data_type = match &self.value {
            Value::U64(_) => DataType::UInt64,
            Value::U32(_) => DataType::UInt32,
            Value::F64(_) => DataType::Float64,
            Value::Bool(_) => DataType::Boolean,
            Value::Text(_) => DataType::Utf8,
            Value::List(_) => DataType::new_list(DataType::Float64, true),
        };
        let mut metadata = Metadata::from([
            ("unit".to_owned(), self.unit.clone()),
            ("description".to_owned(), self.description.clone()),
        ]);
        if !self.elements.is_empty() {
            let names = serde_json::json!(self.elements);
            metadata.insert(ELEMENTS.to_owned(), names.to_string());
        }
        Field::new(&self.name, data_type, true).with_metadata(metadata)
    }

    /// The column's values over some rows. A number that is not finite becomes a null; the reason of the
    /// [`super::PointRow`] then names the column.
    fn array(&self, rows: &[R]) -> ArrayRef {
        let finite = |value: f64| value.is_finite().then_some(value);
        match &self.value {
            Value::U64(get) => {
                let mut builder = UInt64Builder::with_capacity(rows.len());
                rows.iter().for_each(|row| builder.append_option(get(row)));
                Arc::new(builder.finish())
            }
            Value::U32(get) => {
                let mut builder = UInt32Builder::with_capacity(rows.len());
                rows.iter().for_each(|row| builder.append_option(get(row)));
                Arc::new(builder.finish())
            }
            Value::F64(get) => {
                let mut builder = Float64Builder::with_capacity(rows.len());
                rows.iter()
                    .for_each(|row| builder.append_option(get(row).and_then(finite)));
                Arc::new(builder.finish())
            }
            Value::Bool(get) => {
                let mut builder = BooleanBuilder::with_capacity(rows.len());
                rows.iter().for_each(|row| builder.append_option(get(row)));
                Arc::new(builder.finish())
            }
            Value::Text(get) => {
                let mut builder = StringBuilder::new();
                rows.iter().for_each(|row| builder.append_option(get(row)));
                Arc::new(builder.finish())
            }
            Value::List(get) => {
                let mut builder = ListBuilder::new(Float64Builder::new());
                for row in rows {
                    let list = get(row);
                    for &value in list.unwrap_or_default() {
                        builder.values().append_option(finite(value));
                    }
                    builder.append(list.is_some());
                }
                Arc::new(builder.finish())
            }
        }
    }

    /// Whether the row's value is a number that is not finite.
    pub(super) fn is_not_finite(&self, row: &R) -> bool {
        match &self.value {
            Value::F64(get) => get(row).is_some_and(|value| !value.is_finite()),
            Value::List(get) => {
                get(row).is_some_and(|list| list.iter().any(|value| !value.is_finite()))
            }
            _ => false,
        }
    }
}

/// Columns in file order. Each has a type, name, unit, an expression for the value in terms of `row` (an option if it
/// may be null) and a description:
/// `f64 "velocity", "m/s", row.velocity, "Rate of the mesh deflection";`.
macro_rules! columns {
    ($row:ident: $Row:ty; $($type:ident $name:expr, $unit:expr, $value:expr, $text:expr;)*) => {
        vec![$($crate::store::table::Column::new(
            $name,
            $unit,
            $text,
            columns!(@$type Box::new(move |$row: &$Row| $value.into())),
        )),*]
    };
    (@u64 $get:expr) => { $crate::store::table::Value::U64($get) };
    (@u32 $get:expr) => { $crate::store::table::Value::U32($get) };
    (@f64 $get:expr) => { $crate::store::table::Value::F64($get) };
    (@bool $get:expr) => { $crate::store::table::Value::Bool($get) };
    (@text $get:expr) => { $crate::store::table::Value::Text($get) };
    (@list $get:expr) => { $crate::store::table::Value::List($get) };
}
pub(super) use columns;

/// A result table: its columns in file order.
pub struct Table<R> {
    columns: Vec<Column<R>>,
    schema: SchemaRef,
}

impl<R> Table<R> {
    pub(super) fn new(columns: Vec<Column<R>>) -> Self {
        let fields: Vec<Field> = columns.iter().map(Column::field).collect();
        Self {
            columns,
            schema: Arc::new(Schema::new(fields)),
        }
    }

    /// The columns, in file order.
    pub fn columns(&self) -> &[Column<R>] {
        &self.columns
    }

    /// The Arrow schema; each field carries `unit` and `description`.
    pub fn schema(&self) -> SchemaRef {
        Arc::clone(&self.schema)
    }

    /// Unit of every column, by name, for readers that drop field metadata.
    pub fn units(&self) -> BTreeMap<&str, &str> {
        self.columns
            .iter()
            .map(|column| (&*column.name, &*column.unit))
            .collect()
    }

    /// Description of every column, by name.
    pub fn descriptions(&self) -> BTreeMap<&str, &str> {
        self.columns
            .iter()
            .map(|column| (&*column.name, &*column.description))
            .collect()
    }

    /// Bytes of a row's numbers, texts and lists.
    pub(super) fn row_bytes(&self, row: &R) -> usize {
        let bytes = |column: &Column<R>| match &column.value {
            Value::Text(get) => get(row).map_or(0, str::len),
            Value::List(get) => get(row).map_or(0, size_of_val),
            _ => size_of::<f64>(),
        };
        self.columns.iter().map(bytes).sum()
    }

    /// The rows as columns.
    pub(super) fn batch(&self, rows: &[R]) -> Result<RecordBatch, ArrowError> {
        let arrays = self
            .columns
            .iter()
            .map(|column| column.array(rows))
            .collect();
        RecordBatch::try_new(self.schema(), arrays)
    }
}

#[cfg(test)]
impl<R> Table<R> {
    /// One line per column: name, type, unit and description.
    pub(super) fn listing(&self) -> String {
        let lines = self.schema.fields().iter().map(|field| {
            let (metadata, kind) = (field.metadata(), field.data_type());
            format!(
                "{}: {kind} [{}] {}",
                field.name(),
                &metadata["unit"],
                &metadata["description"]
            )
        });
        lines.collect::<Vec<_>>().join("\n")
    }
}
