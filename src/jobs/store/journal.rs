//! Which points of an unfinished run are finished? An append-only file beside the results, from which the same command
//! continues after an interruption, a crash or a power cut.
//!
//! ```text
//! magic │ record: header (hash of the job, shard, program) │ record: point │ record: point …
//! record = length (u64, little endian) │ first 8 bytes of BLAKE3 of the payload │ payload
//! ```
//!
//! Payloads have postcard's encoding, which keeps every bit of a number. A point that is cut off or damaged ends the
//! journal: this point and all later ones are dropped and computed again. A damaged header is refused if points may
//! follow it. A run locks the file, so that two runs cannot share a folder.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::OFlags;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::file::{Shard, create_folder};
use super::fsync;
use super::{PointRow, ProgramRecord, StoreError};
use crate::propagate::instructions;

/// Identifies the file and the version of its encoding.
const MAGIC: &[u8; 8] = b"atlas-j4";

/// Size of the frame in front of a payload, length and checksum \[bytes\].
const FRAME: usize = 16;

/// Longest time between syncs: a power cut loses only the points since the last one.
pub const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// The run that a journal belongs to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Header {
    job_hash: String,
    shard: Option<Shard>,
    program: ProgramRecord,
    /// Vector instructions that computed the first points.
    instructions: String,
}

/// The journal of a run, open and locked.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Offset of the first point.
    points: u64,
    /// Offset of the next record; before [`Journal::replay`], the end of the file.
    end: u64,
    last_sync: Instant,
    unsynced: bool,
    instructions: String,
}

impl Journal {
    /// Opens the journal of a job (of a shard of it) in a results folder, or starts one; `fresh` drops an earlier run's
    /// records.
    ///
    /// # Errors
    /// The folder or the file cannot be written, another process uses the journal, its header is damaged, or it belongs
    /// to another job or another build of this program.
    pub fn open(
        folder: &Path,
        job_hash: &str,
        shard: Option<Shard>,
        fresh: bool,
    ) -> Result<Self, StoreError> {
        create_folder(folder)?;
        let path = journal_path(folder, shard);
        let header = Header {
            job_hash: job_hash.to_owned(),
            shard,
            program: ProgramRecord::current(),
            instructions: instructions().to_owned(),
        };
        let file = open_locked(&path)?;
        let mut journal = Self {
            path,
            file,
            points: 0,
            end: 0,
            last_sync: Instant::now(),
            unsynced: false,
            instructions: header.instructions.clone(),
        };
        let mut start = MAGIC.to_vec();
        start.extend(record(&header, &journal.path)?);
        if fresh {
            return journal.begin(&start);
        }
        let mut reader = journal.reader(0)?;
        let mut magic = Vec::new();
        (&mut reader)
            .take(MAGIC.len() as u64)
            .read_to_end(&mut magic)
            .map_err(|source| StoreError::io(&journal.path, "read", source))?;
        if !MAGIC.starts_with(&magic) {
            return Err(StoreError::ForeignJournal { path: journal.path });
        }
        match next_record::<Header>(&mut reader, &journal.path)? {
            Some((found, _)) if found.job_hash != header.job_hash => Err(StoreError::OtherJob {
                path: journal.path,
                found: found.job_hash,
                wanted: header.job_hash,
            }),
            Some((found, _)) if found.shard != header.shard => {
                Err(StoreError::ForeignJournal { path: journal.path })
            }
            Some((found, _)) if found.program != header.program => Err(StoreError::OtherProgram {
                path: journal.path,
                found: found.program.to_string(),
                running: header.program.to_string(),
            }),
            Some((found, length)) => {
                journal.instructions = found.instructions;
                journal.points = MAGIC.len() as u64 + length;
                journal.end = journal.length()?;
                Ok(journal)
            }
            // The file ends with or inside the header, so there is no point to lose.
            None if journal.length()? <= start.len() as u64 => journal.begin(&start),
            None => Err(StoreError::ForeignJournal { path: journal.path }),
        }
    }

    /// Vector instructions that computed the points in the journal, and those of this process if they differ.
    pub fn instructions(&self) -> Vec<String> {
        let here = instructions().to_owned();
        if self.end > self.points && self.instructions != here {
            vec![self.instructions.clone(), here]
        } else {
            vec![here]
        }
    }

    /// Size of the file \[bytes\].
    fn length(&self) -> Result<u64, StoreError> {
        let metadata = self.file.metadata();
        let metadata = metadata.map_err(|source| StoreError::io(&self.path, "read", source))?;
        Ok(metadata.len())
    }

    /// Empties the file and writes its start, the magic and the header. Removes the file if the write fails.
    fn begin(mut self, start: &[u8]) -> Result<Self, StoreError> {
        let begun = self
            .cut(0)
            .and_then(|()| self.write(start))
            .and_then(|()| self.sync())
            .and_then(|()| self.sync_name());
        match begun {
            Ok(()) => {
                self.points = self.end;
                Ok(self)
            }
            Err(error) => {
                // No point is lost, even if the start was written but is not durable.
                self.end = 0;
                self.abandon();
                Err(error)
            }
        }
    }

    /// Makes the file's name durable.
    fn sync_name(&self) -> Result<(), StoreError> {
        fsync::sync_folder_of(&self.path)
            .map_err(|source| StoreError::io(&self.path, "write", source))
    }

    fn reader(&self, from: u64) -> Result<BufReader<&File>, StoreError> {
        let mut reader = BufReader::with_capacity(1 << 20, &self.file);
        reader
            .seek(SeekFrom::Start(from))
            .map_err(|source| StoreError::io(&self.path, "read", source))?;
        Ok(reader)
    }

    /// Passes the existing points to `take`, in the order of the file. Cuts off the first damaged record and all that
    /// follows. Call this once, before anything is appended.
    ///
    /// # Errors
    /// The file cannot be read, or `take` refuses a point.
    pub fn replay(
        &mut self,
        mut take: impl FnMut(PointRow) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let mut end = self.points;
        {
            let mut reader = self.reader(end)?;
            while let Some((row, length)) = next_record(&mut reader, &self.path)? {
                take(row)?;
                end += length;
            }
        }
        self.cut(end)
    }

    /// Passes every existing point once to `take`, by ascending number, one at a time in memory.
    ///
    /// # Errors
    /// The file cannot be read, or `take` refuses a point.
    pub fn in_order(
        &mut self,
        mut take: impl FnMut(PointRow) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let mut places = BTreeMap::new();
        {
            let mut at = self.points;
            let mut reader = self.reader(at)?;
            while let Some((row, length)) = next_record::<PointRow>(&mut reader, &self.path)? {
                // Repeated records of a point have the same results.
                places.entry(row.point_id).or_insert((at, length));
                at += length;
            }
        }
        for (at, length) in places.into_values() {
            let mut bytes = vec![0; length as usize];
            let read = self.file.read_exact_at(&mut bytes, at);
            read.map_err(|source| StoreError::io(&self.path, "read", source))?;
            if let Some((row, _)) = next_record(&mut bytes.as_slice(), &self.path)? {
                take(row)?;
            }
        }
        self.cut(self.end)
    }

    /// Adds a finished point. It is safe from a crash of the program immediately, and from a power cut after the next
    /// [`Journal::sync`].
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&mut self, row: &PointRow) -> Result<(), StoreError> {
        let bytes = record(row, &self.path)?;
        self.write(&bytes)?;
        self.unsynced = true;
        self.sync_if_due()
    }

    /// Makes appended points durable once [`SYNC_INTERVAL`] has passed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn sync_if_due(&mut self) -> Result<(), StoreError> {
        if self.unsynced && self.last_sync.elapsed() >= SYNC_INTERVAL {
            self.sync()?;
        }
        Ok(())
    }

    /// Makes appended points durable.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn sync(&mut self) -> Result<(), StoreError> {
        self.file
            .sync_data()
            .map_err(|source| StoreError::io(&self.path, "write", source))?;
        self.last_sync = Instant::now();
        self.unsynced = false;
        Ok(())
    }

    /// Removes the file after all its points have reached the result files.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove(self) -> Result<(), StoreError> {
        fs::remove_file(&self.path).map_err(|source| StoreError::io(&self.path, "remove", source))
    }

    /// Ends a run that cannot continue. Removes the journal if it has no points.
    pub fn abandon(self) {
        if self.end <= self.points {
            // A file that cannot be removed does no harm.
            _ = fs::remove_file(&self.path);
        }
    }

    fn cut(&mut self, end: u64) -> Result<(), StoreError> {
        self.end = end;
        self.file
            .set_len(end)
            .and_then(|()| self.file.seek(SeekFrom::Start(end)))
            .map_err(|source| StoreError::io(&self.path, "write", source))?;
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.file
            .write_all(bytes)
            .map_err(|source| StoreError::io(&self.path, "write", source))?;
        self.end += bytes.len() as u64;
        Ok(())
    }
}

/// Path of a run's journal. It is hidden because readers of the results do not need it.
pub fn journal_path(folder: &Path, shard: Option<Shard>) -> PathBuf {
    folder.join(match shard {
        None => ".journal".to_owned(),
        Some(shard) => format!(".journal.{}", shard.stem()),
    })
}

/// Size of a point in a journal \[bytes\].
pub fn journal_bytes(row: &PointRow) -> u64 {
    // A row is plain data, which always has an encoding.
    postcard::to_allocvec(row).map_or(0, |payload| (FRAME + payload.len()) as u64)
}

/// Opens and locks the file, creating it if necessary.
fn open_locked(path: &Path) -> Result<File, StoreError> {
    let refused = |source| StoreError::io(path, "write", source);
    loop {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            // A run writes in its folder, not to the target of a link there.
            .custom_flags(OFlags::NOFOLLOW.bits() as i32)
            .open(path)
            .map_err(refused)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(StoreError::Busy {
                    path: path.to_path_buf(),
                });
            }
            // On a file system without locks, two runs cannot be distinguished.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        // Another run may have ended and removed the file between opening and locking.
        let opened = file.metadata().map_err(refused)?;
        match fs::symlink_metadata(path) {
            Ok(there) if (there.dev(), there.ino()) == (opened.dev(), opened.ino()) => {
                return Ok(file);
            }
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(source) => return Err(refused(source)),
        }
    }
}

fn record(payload: &impl Serialize, path: &Path) -> Result<Vec<u8>, StoreError> {
    let mut bytes = vec![0; FRAME];
    bytes = postcard::to_extend(payload, bytes)
        .map_err(|error| StoreError::io(path, "write", io::Error::other(error)))?;
    let (frame, payload) = bytes.split_at_mut(FRAME);
    frame[..8].copy_from_slice(&(payload.len() as u64).to_le_bytes());
    frame[8..].copy_from_slice(&checksum(payload));
    Ok(bytes)
}

fn checksum(payload: &[u8]) -> [u8; 8] {
    let mut sum = [0; 8];
    sum.copy_from_slice(&blake3::hash(payload).as_bytes()[..8]);
    sum
}

/// The next record and its length in the file; `None` if it is cut off or damaged.
fn next_record<T: DeserializeOwned>(
    reader: &mut impl Read,
    path: &Path,
) -> Result<Option<(T, u64)>, StoreError> {
    let refused = |source| StoreError::io(path, "read", source);
    let mut frame = [0; FRAME];
    match reader.read_exact(&mut frame) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        Err(source) => return Err(refused(source)),
    }
    let (length, sum) = frame.split_at(8);
    let length = length
        .iter()
        .rev()
        .fold(0, |length, byte| length << 8 | u64::from(*byte));
    // The buffer grows with the bytes that are read: a damaged length does not allocate memory.
    let mut payload = Vec::new();
    reader
        .take(length)
        .read_to_end(&mut payload)
        .map_err(refused)?;
    if payload.len() as u64 != length || checksum(&payload) != *sum {
        return Ok(None);
    }
    let decoded = postcard::from_bytes(&payload).ok();
    Ok(decoded.map(|value| (value, FRAME as u64 + length)))
}

#[cfg(test)]
mod tests;
