//! The header of a table file: made, and checked before it is believed.

use serde::{Deserialize, Serialize};

use super::CacheFault;
use super::arrays::{Arrays, places};
use super::key::{CacheKind, key};
use super::layout::{ALIGNMENT, CHECKSUM, MAGIC, NUMBER, ORDER_MARK, PRELUDE, VERSION, aligned};
use crate::store::ProgramRecord;

/// What a table file says about itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CacheHeader {
    /// What the table holds.
    pub kind: CacheKind,
    /// Hash of kind, format version and inputs, hexadecimal.
    pub key: String,
    /// Program that computed it.
    pub program: String,
    /// BLAKE3 of the data, hexadecimal.
    pub data: String,
    /// Its arrays, in the order in which they lie.
    pub arrays: Vec<ArrayHeader>,
}

/// What a table file says about one array.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArrayHeader {
    /// Its name.
    pub name: String,
    /// Its unit, SI.
    pub unit: String,
    /// Extent of each axis, slowest first.
    pub shape: Vec<usize>,
    /// Where it starts, counted from the start of the data \[bytes\].
    pub offset: usize,
    /// Its length \[bytes\].
    pub bytes: usize,
}

/// A checked header, and where the rest of the file is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Head {
    pub header: CacheHeader,
    /// What the table was computed from, in canonical form.
    pub inputs: String,
    /// Where the data start \[bytes\].
    pub data: usize,
}

impl CacheHeader {
    /// The header of some arrays; the checksum of the data is given by their writer.
    pub(super) fn new(kind: CacheKind, inputs: &str, arrays: &Arrays, data: String) -> Self {
        let mut end: usize = 0;
        let arrays = arrays.iter().map(|array| {
            let offset = end.next_multiple_of(ALIGNMENT);
            let bytes = NUMBER * array.values.len();
            end = offset + bytes;
            ArrayHeader {
                name: array.name.clone(),
                unit: array.unit.clone(),
                shape: array.shape.clone(),
                offset,
                bytes,
            }
        });
        Self {
            kind,
            key: key(kind, inputs),
            program: ProgramRecord::current().to_string(),
            data,
            arrays: arrays.collect(),
        }
    }

    /// Everything in front of the data.
    pub(super) fn encode(&self, inputs: &str) -> Result<Vec<u8>, serde_json::Error> {
        // A line end, so that `strings` shows header and inputs on a line each.
        let header = serde_json::to_string(self)? + "\n";
        Ok(envelope(&header, inputs))
    }

    /// Length of the data \[bytes\]; refuses arrays that do not follow each other as a writer
    /// places them, and with it any that overlap, reach out of the file or are not aligned.
    fn data_length(&self) -> Result<usize, CacheFault> {
        let mut end = 0;
        for (index, array) in self.arrays.iter().enumerate() {
            let refuse = |detail| CacheFault::Layout {
                array: array.name.clone(),
                detail,
            };
            if self.arrays[..index].iter().any(|a| a.name == array.name) {
                return Err(refuse("there are two of that name"));
            }
            if !array.offset.is_multiple_of(ALIGNMENT) {
                return Err(refuse("it does not start at a multiple of 64 bytes"));
            }
            if Some(array.offset) != aligned(end) {
                return Err(refuse("it does not lie behind the one before"));
            }
            let bytes = places(&array.shape).and_then(|n| n.checked_mul(NUMBER));
            if bytes != Some(array.bytes) {
                return Err(refuse("its length does not fit its shape"));
            }
            end = (array.offset.checked_add(array.bytes))
                .ok_or_else(|| refuse("it does not lie in the file"))?;
        }
        Ok(end)
    }
}

/// The kind of a table that an earlier version of this program kept for every speed; none where
/// it is another.
fn kind_of_before(header: &[u8]) -> Option<&'static str> {
    let header: serde_json::Value = serde_json::from_slice(header).ok()?;
    let mut known = ["spectral", "fused"].into_iter();
    known.find(|kind| header["kind"] == **kind)
}

/// Prelude, header, inputs and zeros, with their checksum.
pub(super) fn envelope(header: &str, inputs: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(PRELUDE + header.len() + inputs.len() + ALIGNMENT);
    bytes.extend(MAGIC);
    bytes.extend(ORDER_MARK.to_ne_bytes());
    bytes.extend(VERSION.to_ne_bytes());
    bytes.extend((header.len() as u64).to_ne_bytes());
    bytes.extend((inputs.len() as u64).to_ne_bytes());
    bytes.resize(PRELUDE, 0);
    bytes.extend(header.as_bytes());
    bytes.extend(inputs.as_bytes());
    bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
    let sum = checksum(&bytes);
    bytes[CHECKSUM].copy_from_slice(sum.as_bytes());
    bytes
}

/// Of everything in front of the data but itself.
fn checksum(bytes: &[u8]) -> blake3::Hash {
    let mut hash = blake3::Hasher::new();
    hash.update(&bytes[..CHECKSUM.start]);
    hash.update(&bytes[CHECKSUM.end..]);
    hash.finalize()
}

/// What there is in front of the data \[bytes\], as the prelude of a file says; none where it says
/// nothing possible.
pub(super) fn head_length(start: &[u8]) -> Option<usize> {
    let length = |at| {
        let bytes = start.get(at..at + 8)?;
        usize::try_from(u64::from_ne_bytes(bytes.try_into().ok()?)).ok()
    };
    let header_end = PRELUDE.checked_add(length(16)?)?;
    aligned(header_end.checked_add(length(24)?)?)
}

/// Checks everything about a file of some length but its data. `file` is its beginning, with all
/// that is in front of the data where the file is that long.
///
/// # Errors
/// The first thing that is wrong.
pub(super) fn read_head(file: &[u8], length: usize) -> Result<Head, CacheFault> {
    if file.is_empty() {
        return Err(CacheFault::Empty);
    }
    let cut_off = |needed| CacheFault::CutOff {
        found: length,
        needed,
    };
    // A short file that begins otherwise is no table that was cut off.
    if !file.starts_with(&MAGIC[..MAGIC.len().min(file.len())]) {
        return Err(CacheFault::Magic);
    }
    if file.len() < PRELUDE {
        return Err(cut_off(PRELUDE));
    }
    match u32::from_ne_bytes(field(file, 8)) {
        ORDER_MARK => {}
        mark if mark == ORDER_MARK.swap_bytes() => return Err(CacheFault::ByteOrder),
        _ => return Err(CacheFault::HeaderChecksum),
    }
    match u32::from_ne_bytes(field(file, 12)) {
        VERSION => {}
        found => {
            let known = VERSION;
            return Err(CacheFault::Version { found, known });
        }
    }
    let data = head_length(file).ok_or(CacheFault::HeaderChecksum)?;
    // Sums that have just been made without overflow.
    let header_end = PRELUDE + u64::from_ne_bytes(field(file, 16)) as usize;
    let inputs_end = header_end + u64::from_ne_bytes(field(file, 24)) as usize;
    let head = file.get(..data).ok_or_else(|| cut_off(data))?;
    if checksum(head) != blake3::Hash::from_bytes(field(file, CHECKSUM.start)) {
        return Err(CacheFault::HeaderChecksum);
    }
    let unclear = |detail: String| CacheFault::Header { detail };
    let header = &head[PRELUDE..header_end];
    let header: CacheHeader =
        serde_json::from_slice(header).map_err(|error| match kind_of_before(header) {
            Some(kind) => CacheFault::Earlier { kind },
            None => unclear(error.to_string()),
        })?;
    let inputs = std::str::from_utf8(&head[header_end..inputs_end])
        .map_err(|error| unclear(error.to_string()))?;
    if header.key != key(header.kind, inputs) {
        return Err(CacheFault::Key);
    }
    let expected = (header.data_length()?.checked_add(data))
        .ok_or_else(|| unclear("its arrays have no end".into()))?;
    match length {
        found if found < expected => Err(cut_off(expected)),
        found if found > expected => Err(CacheFault::TooLong { found, expected }),
        _ => Ok(Head {
            inputs: inputs.to_owned(),
            header,
            data,
        }),
    }
}

/// Checks the data of a file whose header is checked.
///
/// # Errors
/// They are not those that were written.
pub(super) fn check_data(file: &[u8], head: &Head) -> Result<(), CacheFault> {
    let sum = blake3::hash(&file[head.data..]);
    match sum.to_hex().as_str() == head.header.data {
        true => Ok(()),
        false => Err(CacheFault::DataChecksum),
    }
}

/// Some bytes of the prelude, which is known to be there.
fn field<const N: usize>(file: &[u8], at: usize) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.copy_from_slice(&file[at..at + N]);
    bytes
}
