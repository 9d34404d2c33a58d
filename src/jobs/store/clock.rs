//! Points in time as text: RFC 3339, UTC, whole seconds.

use jiff::Timestamp;
use std::time::{Duration, Instant, SystemTime};

/// `2026-03-01T12:00:00Z`; a time after the year 9999 is shown as 1970.
pub fn timestamp(time: SystemTime) -> String {
    format!("{:.0}", Timestamp::try_from(time).unwrap_or_default())
}

/// The start of an activity, and the time since then.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    began: SystemTime,
    clock: Instant,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self {
            began: SystemTime::now(),
            clock: Instant::now(),
        }
    }

    /// The time since the start, independent of changes of the wall clock.
    pub fn elapsed(&self) -> Duration {
        self.clock.elapsed()
    }

    /// The start as text.
    pub fn started(&self) -> String {
        timestamp(self.began)
    }

    /// The present time as text; ignores a wall clock that was set back.
    pub fn now(&self) -> String {
        timestamp(SystemTime::now().max(self.began + self.elapsed()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::UNIX_EPOCH;

    #[test]
    fn a_clock_that_was_set_back_is_not_believed() {
        let ahead = Duration::from_secs(86_400);
        let watch = Stopwatch {
            began: SystemTime::now() + ahead,
            clock: Instant::now(),
        };
        assert!(watch.now() >= watch.started(), "{watch:?}");
    }

    #[test]
    fn known_instants() {
        // From `date -u -d @N +%FT%TZ`.
        for (milliseconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399_999, "2000-02-28T23:59:59Z"),
            (951_782_400_000, "2000-02-29T00:00:00Z"),
            (1_767_225_599_000, "2025-12-31T23:59:59Z"),
            (4_107_542_400_000, "2100-03-01T00:00:00Z"),
        ] {
            let time = UNIX_EPOCH + Duration::from_millis(milliseconds);
            assert_eq!(timestamp(time), text);
        }
    }
}
