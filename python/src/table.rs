//! Tables in the interface of Arrow (the PyCapsule interface of its C data interface), without a copy, and their
//! columns as NumPy arrays. A pickled table is a stream of Arrow IPC.

use arrow_array::cast::AsArray;
use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, RecordBatch, RecordBatchIterator, UInt64Array};
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, DataType, Field, FieldRef, Metadata, SchemaRef};
use arrow_select::concat::concat_batches;
use arrow_select::take::take_record_batch;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyTuple};
use std::collections::HashMap;

/// A table: batches of one schema.
#[pyclass(frozen, module = "gearatlas._gearatlas")]
pub struct Table {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl Table {
    pub fn new(schema: SchemaRef, batches: Vec<RecordBatch>) -> Self {
        Self { schema, batches }
    }

    fn field(&self, name: &str) -> PyResult<&FieldRef> {
        let found = self.schema.fields().find(name);
        let (_, field) = found.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        Ok(field)
    }

    /// The parts of a column, batch by batch.
    fn parts(&self, name: &str) -> impl Iterator<Item = &dyn Array> {
        let columns = self.batches.iter();
        columns.filter_map(move |batch| Some(batch.column_by_name(name)?.as_ref()))
    }

    fn rows(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    fn ipc(&self) -> Result<Vec<u8>, ArrowError> {
        let mut writer = StreamWriter::try_new(Vec::new(), &self.schema)?;
        for batch in &self.batches {
            writer.write(batch)?;
        }
        writer.into_inner()
    }
}

fn refused(error: ArrowError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A column's field with its unit and description, as in result files.
pub fn with_unit(name: &str, kind: DataType, unit: &str, description: &str) -> Field {
    let told = Metadata::from([("unit", unit), ("description", description)]);
    Field::new(name, kind, true).with_metadata(told)
}

#[pymethods]
impl Table {
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.schema.as_ref()).map_err(refused)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    /// The rows as a stream of batches. Ignores a requested schema and gives the table's own.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        _ = requested_schema;
        let batches = self.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, self.schema.clone());
        let stream = FFI_ArrowArrayStream::new(Box::new(reader));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }

    fn __len__(&self) -> usize {
        self.rows()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let bytes = self.ipc().map_err(refused)?;
        let made = py.get_type::<Self>().getattr("from_ipc")?;
        (made, (PyBytes::new(py, &bytes),)).into_pyobject(py)
    }

    /// The table in a stream of Arrow IPC.
    #[staticmethod]
    fn from_ipc(bytes: &[u8]) -> PyResult<Self> {
        let reader = StreamReader::try_new(bytes, None).map_err(refused)?;
        let schema = reader.schema();
        let batches = reader.collect::<Result<_, _>>().map_err(refused)?;
        Ok(Self::new(schema, batches))
    }

    /// The rows with these indices, in this order. Each index must be below the number of rows.
    fn taken(&self, rows: PyReadonlyArray1<'_, u64>) -> PyResult<Self> {
        let numbers: UInt64Array = rows.as_array().iter().copied().collect();
        let all = concat_batches(&self.schema, &self.batches).map_err(refused)?;
        let batch = take_record_batch(&all, &numbers).map_err(refused)?;
        Ok(Self::new(self.schema.clone(), vec![batch]))
    }

    /// Some columns, in this order.
    fn selected(&self, names: Vec<String>) -> PyResult<Self> {
        let place = |name: &String| {
            let found = self.schema.fields().find(name);
            found.map_or_else(|| Err(PyKeyError::new_err(name.clone())), |(at, _)| Ok(at))
        };
        let places = names.iter().map(place).collect::<PyResult<Vec<_>>>()?;
        let schema = self.schema.project(&places).map_err(refused)?;
        let batches = self.batches.iter().map(|batch| batch.project(&places));
        let batches = batches.collect::<Result<_, _>>().map_err(refused)?;
        Ok(Self::new(schema.into(), batches))
    }

    #[getter]
    fn columns(&self) -> Vec<&str> {
        let fields = self.schema.fields().iter();
        fields.map(|field| field.name().as_str()).collect()
    }

    /// The metadata of the table's file.
    #[getter]
    fn metadata(&self) -> HashMap<String, String> {
        let pairs = self.schema.metadata().iter();
        pairs
            .map(|(key, text)| (key.clone(), text.clone()))
            .collect()
    }

    /// The metadata of a column: `unit`, `description`, and `elements` of named lists.
    fn told(&self, name: &str) -> PyResult<HashMap<String, String>> {
        let pairs = self.field(name)?.metadata().iter();
        Ok(pairs
            .map(|(key, text)| (key.clone(), text.clone()))
            .collect())
    }

    /// A column as an array. Numbers have NaN for missing values; integers stay integers if none is missing. Lists
    /// become rows of a matrix, padded with NaN. Texts, and booleans with missing values, become a list.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let absent = self.parts(name).any(|part| part.null_count() > 0);
        match self.field(name)?.data_type() {
            DataType::Float64 => Ok(self.numbers(name).into_pyarray(py).into_any()),
            DataType::UInt64 | DataType::UInt32 if absent => {
                let whole = self.whole(name).into_iter();
                let numbers = whole.map(|value| value.map_or(f64::NAN, |value| value as f64));
                Ok(PyArray1::from_iter(py, numbers).into_any())
            }
            DataType::UInt64 | DataType::UInt32 => {
                let whole = self.whole(name).into_iter().flatten();
                Ok(PyArray1::from_iter(py, whole).into_any())
            }
            DataType::Boolean => {
                let truths = self.parts(name).flat_map(|part| part.as_boolean().iter());
                if absent {
                    truths.collect::<Vec<Option<bool>>>().into_pyobject(py)
                } else {
                    Ok(PyArray1::from_iter(py, truths.flatten()).into_any())
                }
            }
            DataType::Utf8 => {
                let texts = self
                    .parts(name)
                    .flat_map(|part| part.as_string::<i32>().iter());
                texts.collect::<Vec<Option<&str>>>().into_pyobject(py)
            }
            DataType::List(_) => self.matrix(py, name),
            other => Err(PyTypeError::new_err(format!(
                "column `{name}` has the type {other}, which is not supported"
            ))),
        }
    }
}

impl Table {
    fn numbers(&self, name: &str) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.rows());
        for part in self.parts(name) {
            let part = part.as_primitive::<Float64Type>();
            match part.null_count() {
                0 => numbers.extend_from_slice(part.values()),
                _ => numbers.extend(part.iter().map(|value| value.unwrap_or(f64::NAN))),
            }
        }
        numbers
    }

    fn whole(&self, name: &str) -> Vec<Option<u64>> {
        let mut all = Vec::with_capacity(self.rows());
        for part in self.parts(name) {
            match part.as_primitive_opt::<UInt64Type>() {
                Some(part) => all.extend(part.iter()),
                None => {
                    let part = part.as_primitive::<UInt32Type>().iter();
                    all.extend(part.map(|value| value.map(u64::from)));
                }
            }
        }
        all
    }

    /// Lists as rows, padded with NaN.
    fn matrix<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let lists = || self.parts(name).map(|part| part.as_list::<i32>());
        let lengths = lists().flat_map(|part| part.iter().map(|list| list.map_or(0, |l| l.len())));
        let width = lengths.max().unwrap_or(0);
        let mut values = vec![f64::NAN; self.rows() * width];
        let mut rows = values.chunks_exact_mut(width.max(1));
        for list in lists().flat_map(|part| part.iter()) {
            let Some(row) = rows.next() else { break };
            if let Some(list) = list {
                let list = list.as_primitive::<Float64Type>();
                for (to, value) in row.iter_mut().zip(list) {
                    *to = value.unwrap_or(f64::NAN);
                }
            }
        }
        let shape = [self.rows(), width];
        Ok(values.into_pyarray(py).reshape(shape)?.into_any())
    }
}
