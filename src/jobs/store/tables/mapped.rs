//! A table that can be used: a checked file as memory, or the arrays of a builder where no file
//! could be kept.

use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::Path;

use super::arrays::Arrays;
use super::header::{ArrayHeader, CacheHeader, Head, check_data, head_length, read_head};
use super::key::CacheKind;
use super::layout::PRELUDE;
use super::map::Mapping;
use super::{CacheError, CacheFault};
use crate::propagate::Beside;

/// A read-only table. Cloning is not offered: share it by reference or in an `Arc`.
#[derive(Debug)]
pub struct MappedTable {
    header: CacheHeader,
    inputs: String,
    body: Body,
    /// What kernels make of it when they need it.
    pub(super) beside: Beside,
}

#[derive(Debug)]
enum Body {
    /// A file and where its data start.
    File {
        mapping: Mapping,
        data: usize,
    },
    Memory(Arrays),
}

impl MappedTable {
    /// Opens a table file of any kind and checks every byte of it.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn open(path: &Path) -> Result<Self, CacheFault> {
        let file = open(path)?;
        let mapping = Mapping::of(file, path).map_err(CacheFault::Unreadable)?;
        let bytes = mapping.bytes();
        let head = read_head(bytes, bytes.len())?;
        check_data(bytes, &head)?;
        let Head {
            header,
            inputs,
            data,
        } = head;
        let body = Body::File { mapping, data };
        Ok(Self {
            header,
            inputs,
            body,
            beside: Beside::new(),
        })
    }

    /// The same, and refuses a table of another kind or from other inputs.
    pub(super) fn open_as(path: &Path, kind: CacheKind, inputs: &str) -> Result<Self, CacheFault> {
        let table = Self::open(path)?;
        if table.header.kind != kind {
            return Err(CacheFault::Kind {
                found: table.header.kind.name(),
                wanted: kind.name(),
            });
        }
        match table.inputs == inputs {
            true => Ok(table),
            false => Err(CacheFault::Inputs),
        }
    }

    /// A table that has no file.
    pub(super) fn in_memory(kind: CacheKind, inputs: String, arrays: Arrays) -> Self {
        Self {
            header: CacheHeader::new(kind, &inputs, &arrays, String::new()),
            inputs,
            body: Body::Memory(arrays),
            beside: Beside::new(),
        }
    }

    /// The same table in pages that the calling thread touches first; none where it has no file,
    /// or the system grants no memory.
    pub fn copied(&self) -> Option<Self> {
        let Body::File { mapping, data } = &self.body else {
            return None;
        };
        let body = Body::File {
            mapping: mapping.copied().ok()?,
            data: *data,
        };
        Some(Self {
            header: self.header.clone(),
            inputs: self.inputs.clone(),
            body,
            beside: Beside::new(),
        })
    }

    /// Bytes of its arrays.
    pub fn bytes(&self) -> usize {
        self.header.arrays.iter().map(|array| array.bytes).sum()
    }

    /// What the table says about itself; of one that is not kept the data have no checksum.
    pub fn header(&self) -> &CacheHeader {
        &self.header
    }

    /// What it was computed from: JSON with sorted keys.
    pub fn inputs(&self) -> &str {
        &self.inputs
    }

    /// Whether its numbers are those of a file.
    pub fn has_file(&self) -> bool {
        matches!(self.body, Body::File { .. })
    }

    /// Shape (slowest axis first) and values (row by row) of an array.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn array(&self, name: &str) -> Result<(&[usize], &[f64]), CacheError> {
        self.find(name).ok_or_else(|| self.no_array(name))
    }

    /// Unit of an array.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn unit(&self, name: &str) -> Result<&str, CacheError> {
        let array = self.array_header(name);
        (array.map(|array| array.unit.as_str())).ok_or_else(|| self.no_array(name))
    }

    /// Names of the arrays, in the order in which they lie.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.header.arrays.iter().map(|array| array.name.as_str())
    }

    fn no_array(&self, name: &str) -> CacheError {
        CacheError::NoArray {
            name: name.into(),
            known: self.names().collect::<Vec<_>>().join(", "),
        }
    }

    fn array_header(&self, name: &str) -> Option<&ArrayHeader> {
        self.header.arrays.iter().find(|array| array.name == name)
    }

    fn find(&self, name: &str) -> Option<(&[usize], &[f64])> {
        match &self.body {
            Body::File { mapping, data } => {
                let array = self.array_header(name)?;
                let start = data + array.offset;
                let values = mapping.numbers(start..start + array.bytes)?;
                Some((&array.shape, values))
            }
            Body::Memory(arrays) => {
                let array = arrays.iter().find(|array| array.name == name)?;
                Some((&array.shape, &array.values))
            }
        }
    }
}

/// Reads the beginning of a table file, and checks everything about it but its data.
pub(super) fn open_head(path: &Path) -> Result<Head, CacheFault> {
    let file = open(path)?;
    let length = (file.metadata()).map_err(CacheFault::Unreadable)?.len();
    let mut start = Vec::new();
    let more = |bytes: usize, start: &mut Vec<u8>| {
        let read = (&file).take(bytes as u64).read_to_end(start);
        read.map_err(CacheFault::Unreadable)
    };
    more(PRELUDE, &mut start)?;
    // A damaged length asks for anything: no more than there is.
    if let Some(end) = head_length(&start).filter(|end| *end as u64 <= length) {
        more(end.saturating_sub(PRELUDE), &mut start)?;
    }
    read_head(&start, usize::try_from(length).unwrap_or(usize::MAX))
}

/// Opens a table file that is worth a look.
fn open(path: &Path) -> Result<File, CacheFault> {
    // Asked before it is opened: opening a pipe would wait for its writer.
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(CacheFault::NotAFile);
    }
    if metadata.len() == 0 {
        return Err(CacheFault::Empty);
    }
    File::open(path).map_err(unreadable)
}

fn unreadable(error: std::io::Error) -> CacheFault {
    match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => CacheFault::Missing,
        _ => CacheFault::Unreadable(error),
    }
}
